#pragma once

#include <algorithm>

#include "data/generators/structured_block.hpp"
#include "libfem/mesh/topology.hpp"
#include "libfem/solve/experiments/simulator.hpp"
#include "tests/validation/record.hpp"

namespace palpate::fem {

constexpr double kYoung_Pa = 10e3;

/// A layer of 10 kPa, held at its bottom, square and centred about the origin, its top at z = 0; no
/// twin.
struct LayerSize {
  double thick_m = 0.04, width_m = 0.24, cell_m = 0.04;
};

inline SimulationSetup layer_setup(double poisson, const ProbeSpec& probe,
                                   const LayerSize& size = {}) {
  SimulationSetup setup;
  const int across = static_cast<int>(size.width_m / size.cell_m + 0.5);
  const int down = std::max(1, static_cast<int>(size.thick_m / size.cell_m + 0.5));
  setup.volume =
      structured_block(Vec3(size.width_m, size.width_m, size.thick_m), {across, across, down});
  setup.volume.nodes.rowwise() -=
      Eigen::RowVector3d(size.width_m / 2, size.width_m / 2, size.thick_m);
  for (Eigen::Index n = 0; n < setup.volume.nodes.rows(); ++n)
    setup.is_held.push_back(setup.volume.nodes(n, 2) < 1e-6 - size.thick_m);
  setup.surface = {setup.volume.nodes, boundary_triangles(setup.volume.tets)};
  setup.materials = {{"neo-hookean", {kYoung_Pa, poisson}}};
  setup.probe = probe;
  setup.options.coarse_ratio = 0;
  return setup;
}

/// Near the middle of the top, on no node or edge of the base mesh.
inline Vec3 layer_top() { return {0.0031, -0.0017, 0}; }

/// The press of one test point and what it cost.
struct Pressed {
  PointRows result;
  double cpu_s;

  double force_N(std::size_t row) const { return -result.force.row(row).z(); }
};

inline Pressed press(const SimulationSetup& setup, double depth_m, int steps) {
  Experiments experiments;
  experiments.depth_m = depth_m;
  experiments.press_steps = steps;
  const double start = validation::cpu_seconds();
  PointRows result = Simulator(setup).press_and_drag(layer_top(), -Vec3::UnitZ(), experiments);
  return {std::move(result), validation::cpu_seconds() - start};
}

}  // namespace palpate::fem
