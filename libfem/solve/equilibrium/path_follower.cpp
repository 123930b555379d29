#include "libfem/solve/equilibrium/path_follower.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace palpate::fem {
namespace {

/// An accepted state with how it is moving: displacement per metre of the probe's way. falls: it is
/// on a branch past a limit point, where deeper presses have less force.
struct Walker {
  BodyState state;
  Points velocity;  // empty before the first step
  Vec3 direction = Vec3::Zero();
  bool falls = false;
};

struct StepRules {
  double longest_m, deepest_penetration_m, solver_residual;
  int max_cuts, max_stiffenings;
  bool gives_back;
  double min_penalty_left;  // of what giving back the overlap has changed
};

// With friction the way to a state has crept as well, which its last equilibrium cannot give back:
// of the shift, up to 0.4 was left against a penalty ten times as stiff.
constexpr double kCreepLeft = 0.5;
// A force that falls is believed from steps this much shorter than the first try on, and when it
// falls by no more than this share: a body that jumps to somewhere else falls by as much in any
// step.
constexpr double kFallingStep = 0.25, kLargestFall = 0.1;

/// How a step or a series of them ended.
struct Outcome {
  RowStatus status = RowStatus::good;
  RowDoubt doubt = RowDoubt::none;
};

/// One walk over all tracks on one mesh.
struct Walk {
  Equilibrium& equilibrium;
  StepRules rules;
  int stiffenings = 0;
};

RowStatus failure(SolveStatus status) {
  return status == SolveStatus::inverted ? RowStatus::inverted : RowStatus::not_converged;
}

bool falls_on_a_stable_branch(Equilibrium& equilibrium, const BodyState& before,
                              const BodyState& after) {
  const double pushed_before = before.contact.force_N.dot(before.pose.axis);
  const double pushed = after.contact.force_N.dot(after.pose.axis);
  return pushed_before - pushed <= kLargestFall * pushed_before && equilibrium.is_stable(after);
}

/// One equilibrium from the walker's state to `tip`; moves the walker when it is accepted.
Outcome try_step(Walk& walk, Walker& walker, const Vec3& tip, bool must_rise, bool may_fall,
                 bool may_shorten) {
  const Vec3 way = tip - walker.state.pose.tip;
  const double length = way.norm();
  Points guess = walker.state.u;
  // Going on in the same direction, the body goes on as it did.
  if (walker.velocity.size() && walker.direction.dot(way) > 0.9 * length)
    guess += length * walker.velocity;
  BodyState next;
  const SolveStatus solved =
      walk.equilibrium.solve(walker.state, {tip, walker.state.pose.axis}, guess, next, may_shorten);
  if (solved != SolveStatus::solved) return {failure(solved)};
  RowDoubt doubt = judge_step(walker.state, next, must_rise, walk.rules.deepest_penetration_m);
  if (doubt == RowDoubt::does_not_rise && may_fall &&
      falls_on_a_stable_branch(walk.equilibrium, walker.state, next))
    doubt = RowDoubt::falls;
  if (doubt != RowDoubt::none && doubt != RowDoubt::falls)
    return {doubt == RowDoubt::inverted ? RowStatus::inverted : RowStatus::rejected, doubt};
  walker.falls = must_rise ? doubt == RowDoubt::falls : walker.falls;
  walker.velocity = (next.u - walker.state.u) / length;
  walker.direction = way / length;
  walker.state = std::move(next);
  return {};
}

/// Reaches `tip` in as many steps as it takes. A step that overlaps too far is tried again with
/// twice the penalty, which then stays.
Outcome reach(Walk& walk, Walker& walker, const Vec3& tip, bool must_rise) {
  const StepRules& rules = walk.rules;
  const Vec3 start = walker.state.pose.tip;
  const double way = (tip - start).norm();
  if (way == 0) return {};
  const double whole_step = way / std::max(1.0, std::ceil(way / rules.longest_m - 1e-9));
  const double shortest = whole_step * std::ldexp(0.75, -rules.max_cuts);
  double step = whole_step, done = 0;
  while (done < way) {
    const double here = way - done < 1.25 * step ? way - done : step;
    const Vec3 goal =
        done + here >= way ? tip : Vec3(start + (tip - start) * ((done + here) / way));
    const bool may_fall = walker.falls || here <= 1.25 * kFallingStep * whole_step;
    // On a press near nu 1/2 iterations that seem astray find their way; on drags they do not.
    const bool may_shorten = !must_rise && here / 2 >= shortest;
    const Outcome outcome = try_step(walk, walker, goal, must_rise, may_fall, may_shorten);
    if (outcome.status == RowStatus::good) {
      done += here;
      step = std::min(2 * step, whole_step);
    } else if (outcome.doubt == RowDoubt::overlaps && walk.stiffenings < rules.max_stiffenings) {
      walk.equilibrium.stiffen_contact(2);
      ++walk.stiffenings;
    } else {
      step = here / 2;
      if (step < shortest) return outcome;
    }
  }
  return {};
}

/// The row of an accepted state: sums of the equilibrium with the overlap given back.
TrackRow record(Walk& walk, const Walker& walker, const Vec3& deflection) {
  const StepRules& rules = walk.rules;
  const BodyState& state = walker.state;
  TrackRow row;
  if (walker.falls) row.doubt = RowDoubt::falls;
  const double depth = deflection.dot(state.pose.axis);
  row.status = depth > 0 && state.contact.points == 0 ? RowStatus::no_contact : RowStatus::good;
  row.force_N = state.contact.force_N;
  row.torque_Nm = state.contact.torque_Nm;
  row.greatest_penetration_m = state.contact.greatest_penetration_m;
  row.min_J = state.min_J;
  if (state.contact.points > 0) {
    BodyState rigid;
    const bool is_rigid = rules.gives_back &&
                          walk.equilibrium.give_back_overlap(state, rigid) == SolveStatus::solved &&
                          rigid.contact.force_N.dot(state.pose.axis) > 0;
    if (is_rigid) {
      row.force_N = rigid.contact.force_N;
      row.torque_Nm = rigid.contact.torque_Nm;
      row.penalty_shift_N = rigid.contact.force_N - state.contact.force_N;
      // Overlaps shrink by the same factor with each update; twice, as points at the rim come and
      // go.
      const double left = 2 * rigid.contact.mean_penetration_m / state.contact.mean_penetration_m;
      row.penalty_error_N = std::max(left, rules.min_penalty_left) * row.penalty_shift_N.norm();
    } else {
      // Hertz: force goes as depth to the power of 3/2, and depth is short of the mean overlap.
      row.penalty_error_N =
          1.5 * row.force_N.norm() * std::min(1.0, state.contact.mean_penetration_m / depth);
    }
  }
  row.solver_error_N = rules.solver_residual * row.force_N.norm();
  return row;
}

/// The next row that was to be recorded says why it could not be; those after it stay not_reached.
void note_failure(const Track& track, std::size_t waypoint, const Outcome& outcome,
                  std::vector<TrackRow>& rows) {
  for (; waypoint < track.waypoints.size(); ++waypoint)
    if (const int row = track.waypoints[waypoint].row; row >= 0) {
      rows[row].status = outcome.status;
      rows[row].doubt = outcome.doubt;
      return;
    }
}

}  // namespace

RowDoubt judge_step(const BodyState& before, const BodyState& after, bool must_rise,
                    double deepest_penetration_m) {
  const double pushed_before = before.contact.force_N.dot(before.pose.axis);
  const double pushed = after.contact.force_N.dot(after.pose.axis);
  const bool has_area = after.contact.area_m2 > 0;
  if (!(after.min_J > 0)) return RowDoubt::inverted;
  if (!(after.contact.greatest_penetration_m <= deepest_penetration_m)) return RowDoubt::overlaps;
  if (must_rise && !has_area) return RowDoubt::no_area;
  if (has_area && !(pushed > 0)) return RowDoubt::pulls;
  if (must_rise && !(pushed > pushed_before)) return RowDoubt::does_not_rise;
  return RowDoubt::none;
}

std::vector<TrackRow> walk_tracks(Equilibrium& equilibrium, const Probe& probe,
                                  const ProbePose& touch, const std::vector<Track>& tracks,
                                  int rows, const WalkOptions& options, const Progress& progress) {
  const StepRules rules{options.longest_step * probe.length_m,
                        options.greatest_penetration * probe.length_m,
                        equilibrium.options().residual,
                        options.max_cuts,
                        options.max_stiffenings,
                        options.gives_back,
                        probe.friction > 0 ? kCreepLeft : 0.0};
  Walk walk{equilibrium, rules};
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
      const Outcome outcome =
          reach(walk, walker, touch.tip + waypoint.deflection, waypoint.must_rise);
      if (outcome.status != RowStatus::good) {
        note_failure(track, w, outcome, out);
        break;
      }
      if (waypoint.row >= 0) out[waypoint.row] = record(walk, walker, waypoint.deflection);
      const auto keep = kept.find({static_cast<int>(t), static_cast<int>(w)});
      if (keep != kept.end()) keep->second = walker;
    }
  }
  return out;
}

}  // namespace palpate::fem
