#include "libfem/solve/tracks.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace palpate::fem {
namespace {

/// An accepted state with how it is moving: displacement per metre of the probe's way.
struct Walker {
  BodyState state;
  Points velocity;            // empty before the first step
  Vec3 direction = Vec3::Zero();
  double penalty_bias_N = 0;  // of the latest press step
};

struct StepRules {
  double longest_m, deepest_penetration_m, solver_residual;
  int most_cuts;
};

/// Why a solved state cannot be believed, `good` when it can.
RowStatus judge(const BodyState& before, const BodyState& after, bool must_rise,
                const StepRules& rules) {
  const double pushed_before = before.contact.force_N.dot(before.pose.axis);
  const double pushed = after.contact.force_N.dot(after.pose.axis);
  if (!(after.least_J > 0)) return RowStatus::inverted;
  if (after.contact.greatest_penetration_m > rules.deepest_penetration_m) return RowStatus::rejected;
  if (must_rise && !(pushed > pushed_before && after.contact.points > 0)) return RowStatus::rejected;
  if (after.contact.points > 0 && !(pushed > 0)) return RowStatus::rejected;
  return RowStatus::good;
}

RowStatus failure(SolveStatus status) {
  return status == SolveStatus::inverted ? RowStatus::inverted : RowStatus::not_converged;
}

/// One equilibrium from the walker's state to `tip`; moves the walker when it is accepted.
RowStatus try_step(Equilibrium& equilibrium, Walker& walker, const Vec3& tip, bool must_rise,
                   const StepRules& rules) {
  const Vec3 way = tip - walker.state.pose.tip;
  const double length = way.norm();
  Points guess = walker.state.u;
  // Going on in the same direction, the body goes on as it did.
  if (walker.velocity.size() && walker.direction.dot(way) > 0.9 * length)
    guess += length * walker.velocity;
  BodyState next;
  const SolveStatus solved =
      equilibrium.solve(walker.state, {tip, walker.state.pose.axis}, guess, next);
  if (solved != SolveStatus::solved) return failure(solved);
  const RowStatus verdict = judge(walker.state, next, must_rise, rules);
  if (verdict != RowStatus::good) return verdict;
  walker.velocity = (next.u - walker.state.u) / length;
  walker.direction = way / length;
  // To first order the penalty's shortfall of force is the rate of its own energy (method, 6).
  if (must_rise)
    walker.penalty_bias_N = (next.contact.energy_J - walker.state.contact.energy_J) / length;
  walker.state = std::move(next);
  return RowStatus::good;
}

/// Reaches `tip` in as many steps as it takes.
RowStatus reach(Equilibrium& equilibrium, Walker& walker, const Vec3& tip, bool must_rise,
                const StepRules& rules) {
  const Vec3 start = walker.state.pose.tip;
  const double way = (tip - start).norm();
  if (way == 0) return RowStatus::good;
  const double whole_step = way / std::max(1.0, std::ceil(way / rules.longest_m - 1e-9));
  const double shortest = whole_step * std::ldexp(0.75, -rules.most_cuts);
  double step = whole_step, done = 0;
  while (done < way) {
    const double here = way - done < 1.25 * step ? way - done : step;
    const Vec3 goal = done + here >= way ? tip : Vec3(start + (tip - start) * ((done + here) / way));
    const RowStatus status = try_step(equilibrium, walker, goal, must_rise, rules);
    if (status == RowStatus::good) {
      done += here;
      step = std::min(2 * step, whole_step);
    } else {
      step = here / 2;
      if (step < shortest) return status;
    }
  }
  return RowStatus::good;
}

TrackRow record(const Walker& walker, const Vec3& deflection, const StepRules& rules) {
  const BodyState& state = walker.state;
  TrackRow row;
  const bool is_pressed = deflection.dot(state.pose.axis) > 0;
  row.status = is_pressed && state.contact.points == 0 ? RowStatus::no_contact : RowStatus::good;
  row.force_N = state.contact.force_N;
  row.torque_Nm = state.contact.torque_Nm;
  row.penalty_bias_N = std::abs(walker.penalty_bias_N);
  row.solver_error_N = rules.solver_residual * row.force_N.norm();
  row.greatest_penetration_m = state.contact.greatest_penetration_m;
  row.least_J = state.least_J;
  return row;
}

}  // namespace

std::vector<TrackRow> walk_tracks(Equilibrium& equilibrium, const Probe& probe,
                                  const ProbePose& touch, const std::vector<Track>& tracks, int rows,
                                  const WalkOptions& options, const Progress& progress) {
  const StepRules rules{options.longest_step * probe.length_m,
                        options.greatest_penetration * probe.length_m,
                        equilibrium.options().residual, options.most_cuts};
  std::vector<TrackRow> out(rows);
  std::map<std::pair<int, int>, Walker> kept;  // at waypoints where later tracks start
  for (const Track& track : tracks)
    if (track.from_track >= 0) kept[{track.from_track, track.from_waypoint}];

  for (std::size_t t = 0; t < tracks.size(); ++t) {
    const Track& track = tracks[t];
    Walker walker;
    if (track.from_track >= 0) {
      walker = kept[{track.from_track, track.from_waypoint}];
      if (walker.state.u.size() == 0) continue;  // never reached
    } else {
      walker.state = equilibrium.rest(touch);
    }
    for (std::size_t w = 0; w < track.waypoints.size(); ++w) {
      if (progress.stopped()) return out;
      const Waypoint& waypoint = track.waypoints[w];
      const RowStatus status =
          reach(equilibrium, walker, touch.tip + waypoint.deflection, waypoint.must_rise, rules);
      if (status != RowStatus::good) {
        for (std::size_t later = w; later < track.waypoints.size(); ++later)
          if (track.waypoints[later].row >= 0) {
            out[track.waypoints[later].row].status = status;
            break;
          }
        break;
      }
      if (waypoint.row >= 0) out[waypoint.row] = record(walker, waypoint.deflection, rules);
      const auto keep = kept.find({static_cast<int>(t), static_cast<int>(w)});
      if (keep != kept.end()) keep->second = walker;
    }
  }
  return out;
}

}  // namespace palpate::fem
