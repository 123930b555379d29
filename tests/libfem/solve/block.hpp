#pragma once

#include "data/generators/structured_block.hpp"
#include "libfem/mesh/grade/grade_mesh.hpp"
#include "libfem/mesh/topology.hpp"
#include "libfem/solve/experiments/simulator.hpp"

namespace palpate::fem {

inline std::vector<char> held_below(const Points& nodes, double height) {
  std::vector<char> is_held;
  for (Eigen::Index n = 0; n < nodes.rows(); ++n) is_held.push_back(nodes(n, 2) < height);
  return is_held;
}

/// The base mesh with quadratic nodes, flat faces and no refinement.
inline QuadraticMesh ungraded(const TetMesh& base, const std::vector<char>& is_held) {
  GradeOptions options;
  options.path = {{Vec3::Zero(), Vec3::Zero(), 1e6}};
  return grade_mesh(base, is_held, SmoothSurface({base.nodes, boundary_triangles(base.tets)}),
                    options);
}

constexpr double kYoung_Pa = 10e3, kPoisson = 0.45;

/// A flat block of 60 x 60 x 30 mm, held at its bottom, and a ball of 8 mm; a coarse mesh without
/// coarse grid. scale: factor on all lengths.
inline SimulationSetup block_setup(double friction, double scale = 1) {
  SimulationSetup setup;
  setup.volume = structured_block(scale * Vec3(0.06, 0.06, 0.03), {4, 4, 2});
  setup.is_held = held_below(setup.volume.nodes, scale * 1e-6);
  setup.surface = {setup.volume.nodes, boundary_triangles(setup.volume.tets)};
  setup.materials = {{"neo-hookean", {kYoung_Pa, kPoisson}}};
  setup.probe = sphere_spec(scale * 0.008, friction);
  setup.options.coarse_ratio = 0;
  setup.options.element_size = setup.options.growth = 0.8;
  return setup;
}

/// Not a node of the base mesh, nor on one of its edges.
inline Vec3 block_top(double scale = 1) { return scale * Vec3(0.031, 0.0283, 0.03); }

/// Of presses there.
inline TestPoints one_point(const Vec3& at = block_top()) {
  return {at.transpose(), -Vec3::UnitZ().transpose(), {"p"}, {}};
}

/// A press of 4 mm in 3 steps and one drag of 4 mm (along x) at full depth: 3 rows, and 1 back.
inline Experiments press_and_one_drag(double scale = 1) {
  Experiments experiments;
  experiments.depth_m = scale * 0.004;
  experiments.press_steps = 3;
  experiments.drag_depths_m = {experiments.depth_m};
  experiments.drag_distance_m = scale * 0.004;
  experiments.drag_directions = 1;
  experiments.drag_steps = 4;
  return experiments;
}

/// The first `steps` rows of the press alone.
inline Experiments press_only(int steps) {
  Experiments experiments = press_and_one_drag();
  experiments.press_steps = steps;
  experiments.drag_depths_m.clear();
  return experiments;
}

}  // namespace palpate::fem
