#pragma once

#include <functional>
#include <limits>
#include <vector>

#include "libfem/solve/experiments/simulator.hpp"
#include "libfit/core/experiments.hpp"
#include "libfit/core/samples.hpp"

namespace palpate::fem {

/// Factor of one step of a press on one mesh: a line over the logarithm of its force
/// [N], held beyond the forces that it was found at.
struct QuickStep {
  double scale = 1;  ///< at log_force
  double log_force = 0, lowest = 0, highest = 0;
  double error = 0;  ///< relative: what the line leaves at the worst of the points and what their
                     ///< own rows state (median)
};

/// Correction of presses on one mesh, from points that were pressed on two as well (M13e).
/// steps: of the press; empty where nothing is told. slope: of all their lines, 0 where one factor
/// for all points is as good. p95: of what is left in all rows, light rows over relative_floor() of
/// their point's largest force.
struct QuickScale {
  std::vector<QuickStep> steps;
  double slope = 0;
  double p95 = 0;
  int points = 0;  ///< that told it

  explicit operator bool() const { return !steps.empty(); }
  /// A step that no point reached on both meshes has what the one before it has.
  const QuickStep& step(std::int32_t number) const;
  /// force_N: of the row on one mesh. Not where nothing is told.
  double factor(std::int32_t step, double force_N) const;
  /// Tells samples of one comparison from those of another (Effort): the deepest step's scale.
  double number() const { return steps.empty() ? 0 : steps.back().scale; }
};

/// two_meshes, one_mesh: rows of the same points in the same order; the latter with scale 1.
/// There is a slope where lines predict points left out better than factors do; what is left is
/// then what is left in points left out. max_error: rows on two meshes that state more of
/// themselves [relative] tell nothing.
QuickScale compare_quick(const Samples& two_meshes, const Samples& one_mesh,
                         double max_error = std::numeric_limits<double>::infinity());

/// jobs: threads, 0 for one per processor. already_done: rows of an earlier run, numbered as those
/// of the result; an experiment that has rows there keeps them and is not simulated again. quick:
/// what presses on one mesh lack; none: they are left as they are.
struct SimulateOptions {
  int jobs = 0;
  Samples already_done = {};
  QuickScale quick = {};
  /// Columns of Samples::surface, also where no experiment of the list tells how the surface moves:
  /// its rows are joined to others that do. 0: as the list has it.
  Eigen::Index surface_columns = 0;
};

/// Who makes experiments of a kind: the same tool, or another on the same body.
using SimulatorOf = std::function<const Simulator&(const Experiment&)>;

/// Called when an experiment is finished, one call at a time. `so_far` gathers all that is
/// finished, as a later run takes it in `already_done`.
using OneDone = std::function<void(const std::function<Samples()>& so_far)>;

/// A list of experiments, in parallel; rows in its order, the same bits whatever the number of
/// threads. each: what is done at a test point. Stops early on progress.stopped(): the result then
/// holds what is finished. Callers check_experiments first; a point that is thinner than the press
/// is deep is tried all the same, and its rows say how far it went.
Samples simulate(const SimulatorOf& simulator, const ExperimentList& list, const Experiments& each,
                 const SimulateOptions& options = {}, const OneDone& on_done = {},
                 const Progress& progress = {});
Samples simulate(const Simulator& simulator, const ExperimentList& list, const Experiments& each,
                 const SimulateOptions& options = {}, const OneDone& on_done = {},
                 const Progress& progress = {});

/// A press, and a drag at each depth along each direction.
int experiments_per_point(const Experiments& each);

/// Forces of a press at first over those of slow motion: the median over points and
/// rows, one coarse mesh each way. 0 where no point tells. Points that fail are left out.
double force_at_first(const Simulator& simulator, const TestPoints& points,
                      const Experiments& experiments, const Progress& progress = {});

/// The Prony series of a contact with a half-space of a material whose shape relaxes and whose bulk
/// does not (M14c): a branch for each of the material's, weaker and slower. at_first: its shares
/// are scaled so that they sum to at_first - 1; 0: they are those of the half-space.
Relaxation relaxation_of_contact(const Material& material, double at_first = 0);

/// A straight press in cycles, from first touch along the inward normal: to half the depth, nearly
/// out, in to all of it, nearly out and in again.
ToolPath cycled_press(int point, const Vec3& inward, double depth_m);

/// The path after a straight press to preload_m and out again.
ToolPath after_press(const ToolPath& path, const Vec3& inward, double preload_m);

/// Rows of a hold, the last at its end, evenly in the logarithm of time over two decades.
inline constexpr int kHoldRows = 5;

/// The path at a constant speed from first touch, with the time of each row, and a hold of hold_s
/// at its end; 0: none. Rows that stand still where they were are left out: a row takes time.
ToolPath in_time(const ToolPath& path, double speed_m_s, double hold_s);

}  // namespace palpate::fem
