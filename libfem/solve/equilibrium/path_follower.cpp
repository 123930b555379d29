#include "libfem/solve/equilibrium/path_follower.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "libfem/contact/contact.hpp"

namespace palpate::fem {
namespace {

/// From one pose of the probe, or of both, to another.
struct PoseStep {
  Vec3 first = Vec3::Zero(), second = Vec3::Zero();

  double length_m() const { return std::hypot(first.norm(), second.norm()); }
  double dot(const PoseStep& other) const {
    return first.dot(other.first) + second.dot(other.second);
  }
};

PoseStep step_between(const ProbePose& from, const ProbePose& to) {
  PoseStep out{to.tip - from.tip};
  if (to.second) out.second = to.second->tip - from.second->tip;
  return out;
}

ProbePose after(ProbePose pose, const PoseStep& step, double share) {
  pose.tip += step.first * share;
  if (pose.second) pose.second->tip += step.second * share;
  return pose;
}

/// Force along the axis, of both probes where there are two.
double pressing_force_N(const BodyState& state) {
  const double first = state.contact.force_N.dot(state.pose.axis);
  return state.pose.second ? first + state.contact.second_force_N.dot(state.pose.second->axis)
                           : first;
}

/// An accepted state with its velocity: displacement per metre of the probe's path. falls: it
/// is on a branch past a limit point, where deeper presses have less force.
struct PathState {
  BodyState state;
  Points velocity;     // empty before the first step
  PoseStep direction;  // of length 1
  bool falls = false;
  double time_s = 0;  // since first touch; NaN in slow motion
};

/// Outcome of a step or of a series of them.
struct StepOutcome {
  RowStatus status = RowStatus::good;
  StepCheck step_check = StepCheck::none;
};

/// All paths on one mesh being followed.
struct Following {
  Equilibrium& equilibrium;
  const Probe& probe;
  bool uzawa_update;
  int stiffenings = 0;
};

/// One equilibrium from `moving` to `pose` at `time_s`, which `moving` becomes when it is accepted.
/// motion: expected motion of the body; no rows where it is unknown.
StepOutcome try_step(Following& following, PathState& moving, const ProbePose& pose, double time_s,
                     bool must_rise, bool may_fall, bool may_shorten, const Points& motion) {
  const double dt_s = time_s - moving.time_s;
  const bool remembers = !std::isnan(dt_s) || following.equilibrium.body().softens();
  if (remembers)
    following.equilibrium.begin_step(
        moving.state, std::isnan(dt_s) ? std::numeric_limits<double>::infinity() : dt_s);
  const PoseStep step = step_between(moving.state.pose, pose);
  const double length = step.length_m();
  Points guess = moving.state.u;
  // Going on in the same direction, the body goes on as it did.
  if (motion.size())
    guess += motion;
  else if (moving.velocity.size() && moving.direction.dot(step) > 0.9 * length)
    guess += length * moving.velocity;
  BodyState next;
  if (!following.equilibrium.solve(moving.state, pose, guess, next, may_shorten))
    return {RowStatus::not_converged};
  StepCheck step_check = check_step(moving.state, next, must_rise, 0.02 * following.probe.length_m);
  const double before_N = pressing_force_N(moving.state), next_N = pressing_force_N(next);
  // A force that falls is believed from steps this much shorter than the first try on, and when it
  // falls by no more than this share: a body that jumps to somewhere else falls by as much in any
  // step.
  if (step_check == StepCheck::does_not_rise && may_fall && before_N - next_N <= 0.1 * before_N &&
      following.equilibrium.is_stable(next))
    step_check = StepCheck::falls;
  if (step_check != StepCheck::none && step_check != StepCheck::falls)
    return {step_check == StepCheck::inverted ? RowStatus::inverted : RowStatus::rejected,
            step_check};
  moving.falls = must_rise ? step_check == StepCheck::falls : moving.falls;
  if (length > 0) {
    moving.velocity = (next.u - moving.state.u) / length;
    moving.direction = {step.first / length, step.second / length};
  }
  if (remembers) following.equilibrium.end_step(next);
  moving.state = std::move(next);
  moving.time_s = time_s;
  return {};
}

/// Reaches `pose` in as many steps as it takes, none longer than a quarter of the probe's length. A
/// step that overlaps too far is tried again with twice the penalty, which then stays, four times.
/// The distance of a hold is in shares of its time. motion: as above, over the complete segment; it
/// is used if one step suffices, and dropped if that fails.
StepOutcome reach(Following& following, PathState& moving, const ProbePose& pose, double time_s,
                  bool must_rise, const Points& motion) {
  const ProbePose start = moving.state.pose;
  const PoseStep segment = step_between(start, pose);
  const double start_s = moving.time_s, moved_m = segment.length_m();
  const double distance = moved_m > 0 ? moved_m : time_s > start_s ? 1 : 0;
  if (distance == 0) return {};
  const double pieces =
      std::max({1.0, std::ceil(moved_m / (0.25 * following.probe.length_m) - 1e-9),
                moved_m > 0 ? following.equilibrium.body().steps_in_time(start_s, time_s) : 1.0});
  const double full_step = distance / pieces;
  const double shortest = full_step * std::ldexp(0.75, -6);
  double step = full_step, done = 0;
  bool is_guided = motion.size() > 0 && pieces == 1;
  while (done < distance) {
    const double here = distance - done < 1.25 * step ? distance - done : step;
    const ProbePose goal =
        done + here >= distance ? pose : after(start, segment, (done + here) / distance);
    const double goal_s = done + here >= distance
                              ? time_s
                              : start_s + (time_s - start_s) * ((done + here) / distance);
    const bool may_fall = moving.falls || here <= 1.25 * 0.25 * full_step;
    // On a press near nu 1/2 iterations that seem astray converge; on drags they do not.
    const bool may_shorten = !must_rise && here / 2 >= shortest;
    const StepOutcome outcome = try_step(following, moving, goal, goal_s, must_rise, may_fall,
                                         may_shorten, is_guided ? motion : Points());
    if (outcome.status == RowStatus::good) {
      done += here;
      step = std::min(2 * step, full_step);
    } else if (is_guided) {
      is_guided = false;
    } else if (outcome.step_check == StepCheck::overlaps && following.stiffenings < 4) {
      following.equilibrium.stiffen_contact(2);
      ++following.stiffenings;
    } else {
      step = here / 2;
      if (step < shortest) return outcome;
    }
  }
  return {};
}

/// The row of an accepted state: sums of the equilibrium after an Uzawa update (method, 10).
PathRow record(Following& following, PathState& moving, const PathTarget& target,
               const OnRow& on_row) {
  Equilibrium& equilibrium = following.equilibrium;
  BodyState& state = moving.state;
  PathRow row;
  if (moving.falls) row.step_check = StepCheck::falls;
  const double depth = target.deflection.dot(state.pose.axis);
  // A body that springs back slowly releases a tool before it is out.
  const bool may_release = state.step != nullptr;
  row.status = depth > 0 && state.contact.points == 0 && !may_release ? RowStatus::no_contact
                                                                      : RowStatus::good;
  BodyState rigid;
  const bool is_rigid = state.contact.points > 0 && following.uzawa_update &&
                        equilibrium.uzawa_update(state, rigid) && pressing_force_N(rigid) > 0;
  const BodyState& recorded = is_rigid ? rigid : state;
  row.force_N = recorded.contact.force_N;
  row.torque_Nm = recorded.contact.torque_Nm;
  row.second_force_N = recorded.contact.second_force_N;
  if (is_rigid) {
    equilibrium.end_step(rigid.u, state);
    row.penalty_shift_N = row.force_N - state.contact.force_N;
    // Overlaps shrink by the same factor with each update; twice, as points at the rim come and
    // go.
    const double left = 2 * rigid.contact.mean_penetration_m / state.contact.mean_penetration_m;
    // With friction the path to a state has crept as well, which an update of its last equilibrium
    // cannot undo: of the shift, up to 0.4 was left against a penalty ten times as stiff. So it is
    // where the body remembers its strain.
    const double min_left = state.step || following.probe.friction > 0 ? 0.5 : 0;
    row.penalty_error_N = std::max(left, min_left) * row.penalty_shift_N.norm();
  } else if (state.contact.points > 0) {
    // Hertz: force goes as depth to the power of 3/2, and depth is short of the mean overlap.
    row.penalty_error_N =
        1.5 * row.force_N.norm() * std::min(1.0, state.contact.mean_penetration_m / depth);
  }
  row.solver_error_N = equilibrium.options().residual * row.force_N.norm();
  if (on_row) on_row(target.row, recorded.u);
  return row;
}

/// Motion of the body from the target before to this one, by `ahead`.
Points motion_to(const std::vector<ProbePath>& paths, const Waypoints& ahead, std::size_t path,
                 std::size_t target) {
  if (ahead.empty()) return {};
  const Points& there = ahead[path][target];
  const ProbePath& here = paths[path];
  if (target == 0 && here.from_path < 0) return there;
  const Points& before =
      target > 0 ? ahead[path][target - 1] : ahead[here.from_path][here.from_target];
  return there.rows() == before.rows() ? Points(there - before) : Points();
}

/// Writes the outcome into the next row that was to be recorded; those after it stay not_reached.
void note_failure(const ProbePath& path, std::size_t target, const StepOutcome& outcome,
                  std::vector<PathRow>& rows) {
  for (; target < path.targets.size(); ++target)
    if (const int row = path.targets[target].row; row >= 0) {
      rows[row].status = outcome.status;
      rows[row].step_check = outcome.step_check;
      return;
    }
}

/// True if the outward normal is against the axis at a corner or in the middle.
bool looks_against(const FaceNodes& nodes, const Vec3& axis) {
  constexpr double kPlaces[][2] = {{0, 0}, {1, 0}, {0, 1}, {1.0 / 3, 1.0 / 3}};
  return std::ranges::any_of(kPlaces, [&](const auto& at) {
    return area_normal_at(face_point(0, at[0], at[1]), nodes).dot(axis) < 0;
  });
}

double gap_at(const FaceNodes& nodes, const Probe& probe, const ProbePose& pose, double r,
              double s) {
  return probe.distance(pose.axis, place_at(face_point(0, r, s), nodes) - pose.tip).distance_m;
}

/// Least gap over one curved face: a grid, then ever smaller grids about the best point.
double min_gap_of_face(const FaceNodes& nodes, const Probe& probe, const ProbePose& pose) {
  constexpr int kGrid = 4;
  double r0 = 1.0 / 3, s0 = 1.0 / 3, half = 2.0 / 3;
  double least = gap_at(nodes, probe, pose, r0, s0);
  for (int round = 0; round < 12; ++round, half /= 2) {
    const double centre_r = r0, centre_s = s0;
    for (int i = -kGrid; i <= kGrid; ++i)
      for (int j = -kGrid; j <= kGrid; ++j) {
        const double r = std::clamp(centre_r + half * i / kGrid, 0.0, 1.0);
        const double s = std::clamp(centre_s + half * j / kGrid, 0.0, 1.0 - r);
        const double gap = gap_at(nodes, probe, pose, r, s);
        if (gap < least) {
          least = gap;
          r0 = r;
          s0 = s;
        }
      }
  }
  return least;
}

}  // namespace

StepCheck check_step(const BodyState& before, const BodyState& after, bool must_rise,
                     double deepest_penetration_m) {
  const double force_before_N = pressing_force_N(before), force_N = pressing_force_N(after);
  const bool has_area = after.contact.area_m2 > 0;
  if (!(after.min_J > 0)) return StepCheck::inverted;
  if (!(after.contact.greatest_penetration_m <= deepest_penetration_m)) return StepCheck::overlaps;
  if (must_rise && !has_area) return StepCheck::no_area;
  if (has_area && !(force_N > 0)) return StepCheck::pulls;
  if (must_rise && !(force_N > force_before_N)) return StepCheck::does_not_rise;
  return StepCheck::none;
}

std::vector<PathRow> follow_paths(Equilibrium& equilibrium, const Probe& probe,
                                  const ProbePose& touch, const std::vector<ProbePath>& paths,
                                  int rows, bool uzawa_update, const Progress& progress,
                                  const OnRow& on_row, const Waypoints& ahead, Waypoints* reached) {
  Following following{equilibrium, probe, uzawa_update};
  std::vector<PathRow> out(rows);
  std::map<std::pair<int, int>, PathState> kept;  // at targets where later paths start
  for (const ProbePath& path : paths)
    if (path.from_path >= 0) kept[{path.from_path, path.from_target}];

  if (reached != nullptr) {
    reached->resize(paths.size());
    for (std::size_t t = 0; t < paths.size(); ++t) (*reached)[t].resize(paths[t].targets.size());
  }
  for (std::size_t t = 0; t < paths.size(); ++t) {
    const ProbePath& path = paths[t];
    PathState moving;
    if (path.from_path >= 0) {
      moving = kept[{path.from_path, path.from_target}];
      if (moving.state.u.size() == 0) continue;  // never reached
    } else {
      moving.state = equilibrium.rest(touch);
      if (!path.targets.empty() && std::isnan(path.targets.front().time_s))
        moving.time_s = path.targets.front().time_s;
    }
    for (std::size_t i = 0; i < path.targets.size(); ++i) {
      if (progress.stopped()) return out;
      const PathTarget& target = path.targets[i];
      const StepOutcome outcome =
          reach(following, moving, after(touch, {target.deflection, target.second_deflection}, 1),
                target.time_s, target.must_rise, motion_to(paths, ahead, t, i));
      if (outcome.status != RowStatus::good) {
        note_failure(path, i, outcome, out);
        break;
      }
      if (reached != nullptr) (*reached)[t][i] = moving.state.u;
      if (target.row >= 0) out[target.row] = record(following, moving, target, on_row);
      const auto keep = kept.find({static_cast<int>(t), static_cast<int>(i)});
      if (keep != kept.end()) keep->second = moving;
    }
  }
  return out;
}

std::optional<double> first_touch_m(const QuadraticMesh& mesh, const Probe& probe,
                                    const ProbePose& pose, double reach_m) {
  // Faces that may touch: not held, and looking against the axis somewhere.
  std::vector<FaceNodes> faces;
  for (Eigen::Index f = 0; f < mesh.faces.rows(); ++f) {
    const FaceNodes nodes = nodes_of_face(mesh.nodes, mesh.faces.row(f));
    bool is_open = false;
    for (const std::int32_t n : mesh.faces.row(f)) is_open |= !mesh.is_held[n];
    if (is_open && looks_against(nodes, pose.axis)) faces.push_back(nodes);
  }
  double travel = 0;
  for (int advance = 0; advance < 200; ++advance) {
    const ProbePose here{pose.tip + travel * pose.axis, pose.axis};
    double least = 1e300;
    for (const FaceNodes& nodes : faces) {
      // Cheap lower bound first: distances are Lipschitz 1.
      double spread = 0;
      const Vec3 middle = place_at(face_point(0, 1.0 / 3, 1.0 / 3), nodes);
      for (const Vec3& node : nodes) spread = std::max(spread, (node - middle).norm());
      const double bound = gap_at(nodes, probe, here, 1.0 / 3, 1.0 / 3) - 1.5 * spread;
      if (bound < least) least = std::min(least, min_gap_of_face(nodes, probe, here));
    }
    if (std::abs(least) <= 1e-9 * probe.length_m) return travel;
    travel += least;  // no point of the probe moves farther than it travels
    if (std::abs(travel) > reach_m) return std::nullopt;
  }
  return travel;
}

}  // namespace palpate::fem
