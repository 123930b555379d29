#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include "libfem/solve/equilibrium/equilibrium.hpp"
#include "libfit/core/progress.hpp"
#include "libfit/core/samples.hpp"

namespace palpate::fem {

/// A place the probe must pass. deflection: from first touch [m]. row: what is recorded there, -1
/// for nothing. must_rise: the force along the axis has to be larger than before, as on a press.
/// time_s: since first touch, of a body that relaxes; the probe comes at constant speed. All of a
/// path's targets have one or none has: NaN is slow motion.
/// second_deflection: of a second probe, from its own first touch.
struct PathTarget {
  Vec3 deflection = Vec3::Zero();
  int row = -1;
  bool must_rise = false;
  double time_s = std::numeric_limits<double>::quiet_NaN();
  Vec3 second_deflection = Vec3::Zero();
};

/// A path of the probe. It starts at the state that an earlier path left at one of its targets, or
/// at first touch (from_path -1).
struct ProbePath {
  int from_path = -1;
  int from_target = -1;
  std::vector<PathTarget> targets;
};

/// Checks the step from one equilibrium to the next. must_rise: of a press, where force and contact
/// area have to be there and grow.
StepCheck check_step(const BodyState& before, const BodyState& after, bool must_rise,
                     double deepest_penetration_m);

/// Record of a target. Force [N] and torque about the tip [N m] are of the probe on the
/// body after an Uzawa update (method, 10), zero unless the status is good or no_contact.
/// penalty_shift_N: what the update has changed; penalty_error_N: what may be left of it.
/// solver_error_N: what the residual may hide. step_check: why the row is `rejected` or `inverted`,
/// or that a good one `falls`.
struct PathRow {
  RowStatus status = RowStatus::not_reached;
  StepCheck step_check = StepCheck::none;
  Vec3 force_N = Vec3::Zero();
  Vec3 torque_Nm = Vec3::Zero();
  Vec3 second_force_N = Vec3::Zero();
  Vec3 penalty_shift_N = Vec3::Zero();
  double penalty_error_N = 0;
  double solver_error_N = 0;
};

/// Place along `axis` at which the probe touches the body at rest [m], measured from
/// `tip`: from there on inward where it is free, else outward to where it first is. Only what looks
/// against the axis counts, so not what stands behind the tool. Found to 1e-9 of its length by
/// conservative advancement, on the curved faces and not only at their quadrature points. Empty
/// when that is not within `reach_m` of the tip. Source: Mirtich 1996, conservative advancement.
std::optional<double> first_touch_m(const QuadraticMesh& mesh, const Probe& probe,
                                    const ProbePose& pose, double reach_m);

/// Told of each row that is recorded: its number, and the displacement of all nodes [m] in the
/// equilibrium whose force the row holds.
using OnRow = std::function<void(int row, const Points& u)>;

/// Displacements of all nodes [m] at the targets of all paths, no rows where one was not reached.
using Waypoints = std::vector<std::vector<Points>>;

/// Follows all paths from first touch at `touch`. rows: how many there are. ahead: what another
/// mesh found, at the nodes of this one; the search for an equilibrium begins with its motion since
/// the target before. May be empty. reached: takes what is found here. uzawa_update: rows are of
/// the equilibrium after one (Equilibrium::uzawa_update). A step that fails is halved up to six
/// times; what cannot be reached stays not_reached, and the row that failed says why. Returns early
/// when progress.stopped(), rows then not_reached.
std::vector<PathRow> follow_paths(Equilibrium& equilibrium, const Probe& probe,
                                  const ProbePose& touch, const std::vector<ProbePath>& paths,
                                  int rows, bool uzawa_update, const Progress& progress = {},
                                  const OnRow& on_row = {}, const Waypoints& ahead = {},
                                  Waypoints* reached = nullptr);

}  // namespace palpate::fem
