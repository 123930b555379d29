// A ball pressed into a soft block with libfem: press. Prints depth and force, beside Hertz's force
// on a half-space (Johnson, Contact Mechanics, 1985, 4.22).
#include <cmath>
#include <cstdio>

#include "data/generators/structured_block.hpp"
#include "libfem/mesh/topology.hpp"
#include "libfem/solve/experiments/simulator.hpp"
#include "libfit/core/error.hpp"

int main() try {
  using namespace palpate;
  const double young_Pa = 10e3, poisson = 0.45, radius_m = 0.008;
  fem::SimulationSetup setup;

  // 1. The body: a block of 60 x 60 x 30 mm of tetrahedra. This mesh may be coarse: each press
  //    makes a finer one around its contact.
  setup.volume = fem::structured_block({0.06, 0.06, 0.03}, {4, 4, 2});
  setup.surface = {setup.volume.nodes, fem::boundary_triangles(setup.volume.tets)};

  // 2. The support: the bottom is held, or the body would fly off.
  for (const auto& node : setup.volume.nodes.rowwise()) setup.is_held.push_back(node.z() < 1e-6);

  // 3. Material and probe, by the names that a scene has. Values are SI, in the order of the law's
  //    parameters.
  setup.materials = {{"neo-hookean", {young_Pa, poisson}}};
  setup.probe = sphere_spec(radius_m);

  // 4. Accuracy: elements of 0.9 contact radii. Each press is solved on a second mesh, too, from
  //    which the force for elements of size zero is extrapolated.
  setup.options.element_size = 0.9;

  // 5. The experiment: a press of 3 mm in 6 steps, no drags. The normal points into the body.
  Experiments press;
  press.depth_m = 0.003;
  press.press_steps = 6;
  const Vec3 top(0.031, 0.0283, 0.03), inward(0, 0, -1);

  // 6. Solve. The simulator checks its setup first, and throws Error with a remedy.
  const fem::Simulator simulator(setup);
  const fem::PointRows point = simulator.press_and_drag(top, inward, press);

  // 7. Rows state how far their force may be wrong. A row whose status is not good has no force.
  const double modulus_Pa = young_Pa / (1 - poisson * poisson);
  std::printf("depth [mm]  force [N]  error [N]  Hertz [N]\n");
  for (Eigen::Index row = 0; row < point.rows(); ++row) {
    if (point.status[row] != RowStatus::good) return 1;
    const double depth_m = point.deflection.row(row).dot(inward);
    const double hertz_N = 4. / 3 * modulus_Pa * std::sqrt(radius_m * std::pow(depth_m, 3));
    std::printf("%10.2f  %9.5f  %9.5f  %9.5f\n", 1e3 * depth_m, point.force.row(row).dot(inward),
                point.force_error[row], hertz_N);
  }
  return 0;
} catch (const palpate::Error& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
