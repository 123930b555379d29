#pragma once

#include <memory>
#include <vector>

#include "libfem/solve/equilibrium/path_follower.hpp"
#include "libfit/core/body.hpp"
#include "libfit/core/progress.hpp"
#include "libfit/core/samples.hpp"

namespace palpate::fem {

using palpate::Experiments;

/// Sizes of meshes and accuracy of the solution.
struct SolverOptions {
  double element_size = 0.6;  ///< finest h, over the probe's contact radius at the shallowest depth
  /// h over distance from first touch or the probe's path, so at any rim too. Growth ends at 1: a
  /// coarse grid that asks for more is finer than its ratio says, and states too small an error.
  double growth = 0.6;
  double shallowest = 1.0 / 12;  ///< depth resolved like this, over the deepest
  double interface_share = 0.5;  ///< h of elements that two materials share, over h
  /// Distance from the contact in which elements end at a border, over its deepest radius. Presses
  /// on skin and fat over a tumour, of balls of 8 and 2 mm and on a dome of 80 mm, take 0.45, 0.40
  /// and 0.67 of the CPU time with 5, 0.69, 0.40 and 0.98 with 9, and their forces are 0.4,
  /// 0.7, 3.3 and 0.3, 0.5, 1.7 % (mean) off a mesh 2.6 times as fine that has no such bound.
  double interface_reach = 9;
  /// Base tets that carry a contact are halved where forces would else be wrong by more (relative)
  /// because of them; see refine_base(). 0: the base mesh is taken as it is, unquestioned.
  double max_base_error = 0.01;
  double coarse_ratio = 1.6;  ///< element size of the coarser grid that extrapolates force; 0: none
  /// Force error asked for, relative: where rows state more, the point is solved again on a mesh
  /// finer by coarse_ratio, the former one its coarse grid, up to twice. 0: as it comes.
  double force_tolerance = 0;
  EquilibriumOptions equilibrium;
  ContactSettings contact;
  bool uzawa_update = true;  ///< see follow_paths
};

/// A body, its materials and the probe.
/// volume, is_held: base mesh. held_at: what is held between its nodes, too; may be empty.
/// surface: fine, outward. materials: [0] is the body's own; region_at tells which one fills a
/// place of the rest body, empty means 0 everywhere. loads: on its boundary, beside what is held.
/// keeps_surface: rows tell how the vertices of `surface` move.
struct SimulationSetup {
  TetMesh volume;
  std::vector<char> is_held;
  HeldAt held_at;
  Surface surface;
  std::vector<MaterialParameters> materials;
  RegionAt region_at;
  BoundaryLoads loads;
  ProbeSpec probe;
  SolverOptions options;
  bool keeps_surface = false;
};

/// Work that a point took, on the meshes that its rows come from; deterministic.
struct PointCost {
  int nodes = 0, coarse_nodes = 0;
  SolverCounts solver;
};

/// The rows of one test point, their experiments numbered from 0: the press, then the drags. Force
/// and torque are extrapolated to size zero and to a rigid probe (method, 10). force_error is NaN
/// unless the row was solved. step_check: of the step that failed, where the status is rejected or
/// inverted. surface: where SimulationSetup::keeps_surface asks for it, on the finest mesh.
struct PointRows : SampleRows {
  Mat3 sway_m_N = Mat3::Zero();  ///< of the point (base_refinement.hpp)
  double scale = 0;              ///< Samples::point_scale of the point
  bool is_complete = false;      ///< not stopped by progress: such rows are for the bin
  PointCost cost = {};
};

/// Largest force_error of good rows, over their force or, where that is lighter, relative_floor()
/// of the largest. Infinite where none is good or one has no error. which: rows by their numbers.
double achieved_error(const SampleRows& rows, const std::vector<Eigen::Index>& which);
double achieved_error(const SampleRows& rows);

/// Makes experiments on one body. Const members are thread-safe and deterministic: each call owns
/// its mesh, factor and state. Work is in coordinates about the test point, so a body far from the
/// origin loses nothing but the digits of its own coordinates.
class Simulator {
 public:
  /// Throws Error as check_setup does.
  explicit Simulator(SimulationSetup setup);
  ~Simulator();
  Simulator(Simulator&&) noexcept;
  Simulator& operator=(Simulator&&) noexcept;

  /// position on the surface [m], normal inward unit. Drags, and paths of one tool in slow motion
  /// that are not straight, are followed on the coarse grid alone, and state more, but where
  /// SolverOptions::force_tolerance is asked for (M13k).
  PointRows press_and_drag(const Vec3& position, const Vec3& normal, const Experiments& experiments,
                           const Progress& progress = {}) const;

  /// The press alone on one coarse mesh, at a fifth of the cost or less: forces are too large by
  /// much the same share all over a body (M13e), and force_error is the solver's alone.
  PointRows press_quickly(const Vec3& position, const Vec3& normal, const Experiments& experiments,
                          const Progress& progress = {}) const;
  /// Share of that press's force at its end which is lost where only the half of what is held is
  /// that lies farther from the point: it comes from where the body is held. 0 where the press
  /// fails.
  double held_share(const Vec3& position, const Vec3& normal, const Experiments& experiments,
                    const Progress& progress = {}) const;
  /// The same of a relaxing body before anything has relaxed.
  PointRows press_at_once(const Vec3& position, const Vec3& normal, const Experiments& experiments,
                          const Progress& progress = {}) const;

  /// The probe follows successive deflections from first touch: one experiment `path`; path.time_s,
  /// where it has some, are felt by a body that relaxes, and recorded. A tool that leans touches
  /// with another point of it: from where that touches deflections count, about it torques are.
  /// For two tools (path.second) forces and errors are of both, the shape is a sphere.
  PointRows follow(const Vec3& position, const Vec3& normal, const ToolPath& path,
                   const Progress& progress = {}) const;

  /// du/dc [1/m] of the inward normal field of the surface at a test point, as Samples wants it:
  /// smoothed over what the probe touches.
  Mat3 normal_gradient(const Vec3& position, const Vec3& normal) const;

  const SimulationSetup& setup() const;

 private:
  struct State;
  std::unique_ptr<const State> state_;
};

/// Refuses what cannot work, before any work. Throws Error, with `where` a key of the scene: no
/// held node (the body would fly off), a material that is not stable, a probe that is no probe or
/// larger than the body, and numbers out of range.
void check_setup(const SimulationSetup& setup);

/// Refuses experiments that cannot work at a point: a depth larger than the body is thick there
/// along the press, drag depths beyond the press, steps below 1. Throws Error.
void check_experiments(const SimulationSetup& setup, const Experiments& experiments,
                       const Vec3& position, const Vec3& normal);

/// Drag directions: `count` unit tangents, at 0 and 90 degrees for two, at 360/count steps
/// otherwise, from the tangent nearest to the coordinate axis that is least along the normal.
std::vector<Vec3> drag_tangents(const Vec3& normal, int count);

}  // namespace palpate::fem
