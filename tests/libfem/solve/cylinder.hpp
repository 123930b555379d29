#pragma once

#include "data/generators/structured_block.hpp"
#include "libfem/mesh/topology.hpp"
#include "libfem/solve/experiments/simulator.hpp"

namespace palpate::fem {

constexpr double kCylinderRadius_m = 0.06, kCylinderHeight_m = 0.04;

/// A ball of 10 mm over the middle of a cylinder of 10 kPa whose bottom is held; no friction.
inline SimulationSetup ball_on_cylinder(double poisson) {
  SimulationSetup setup;
  setup.volume = structured_cylinder(kCylinderRadius_m, kCylinderHeight_m, 6, 3);
  for (Eigen::Index n = 0; n < setup.volume.nodes.rows(); ++n)
    setup.is_held.push_back(setup.volume.nodes(n, 2) < -0.9999 * kCylinderHeight_m);
  const TetMesh finer = structured_cylinder(kCylinderRadius_m, kCylinderHeight_m, 36, 3);
  setup.surface = {finer.nodes, boundary_triangles(finer.tets)};
  setup.materials = {{"neo-hookean", {10e3, poisson}}};
  setup.probe = sphere_spec(0.01);
  return setup;
}

}  // namespace palpate::fem
