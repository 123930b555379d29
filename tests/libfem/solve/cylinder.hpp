#pragma once

#include <algorithm>
#include <cmath>

#include "libfem/mesh/grade/boundary.hpp"
#include "libfem/mesh/grade/structured_block.hpp"
#include "libfem/solve/simulator.hpp"

namespace palpate::fem {

constexpr double kCylinderRadius_m = 0.06, kCylinderHeight_m = 0.04;

/// A cylinder with its top in z = 0: a square block bent to a disc, straight inside, round at the
/// rim.
inline TetMesh cylinder(int across, int layers) {
  TetMesh mesh = structured_block(Vec3(2, 2, 1), {across, across, layers});
  for (Eigen::Index n = 0; n < mesh.nodes.rows(); ++n) {
    const double x = mesh.nodes(n, 0) - 1, y = mesh.nodes(n, 1) - 1;
    const double ring = std::max(std::abs(x), std::abs(y)), away = std::hypot(x, y);
    const double pull = 1 - ring * ring + ring * ring * (away > 0 ? ring / away : 1);
    mesh.nodes.row(n) << kCylinderRadius_m * pull * x, kCylinderRadius_m * pull * y,
        kCylinderHeight_m * (mesh.nodes(n, 2) - 1);
  }
  return mesh;
}

/// A ball of 10 mm over the middle of a cylinder of 10 kPa whose bottom is held; no friction.
inline SimulationSetup ball_on_cylinder(double poisson) {
  SimulationSetup setup;
  setup.volume = cylinder(6, 3);
  for (Eigen::Index n = 0; n < setup.volume.nodes.rows(); ++n)
    setup.is_held.push_back(setup.volume.nodes(n, 2) < -0.9999 * kCylinderHeight_m);
  const TetMesh finer = cylinder(36, 3);
  setup.surface = {finer.nodes, boundary_triangles(finer.tets)};
  setup.materials = {{"neo-hookean", {10e3, poisson}}};
  setup.probe = sphere_spec(0.01);
  return setup;
}

}  // namespace palpate::fem
