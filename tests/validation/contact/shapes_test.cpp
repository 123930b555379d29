#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "layer.hpp"
#include "tests/libfem/probes/solids.hpp"

namespace palpate::fem {
namespace {

constexpr double kRadius_m = 0.006, kDepth_m = 0.0015;

ProbeSpec shape(const std::string& name,
                std::map<std::string, std::vector<double>, std::less<>> values) {
  ProbeSpec probe;
  probe.shape = name;
  probe.values = std::move(values);
  probe.friction = 0.3;
  return probe;
}

/// Rows of a press to 1.5 mm in two steps and a drag of 1.5 mm at its end.
Pressed press_and_drag(const ProbeSpec& probe) {
  Experiments experiments;
  experiments.depth_m = kDepth_m;
  experiments.press_steps = 2;
  experiments.drag_depths_m = {kDepth_m};
  experiments.drag_distance_m = 0.0015;
  experiments.drag_directions = 1;
  experiments.drag_steps = 2;
  const double start = validation::cpu_seconds();
  PointRows result = Simulator(layer_setup(0.45, probe, {0.03, 0.12, 0.03}))
                         .press_and_drag(layer_top(), -Vec3::UnitZ(), experiments);
  return {std::move(result), validation::cpu_seconds() - start};
}

double difference(const Pressed& a, const Pressed& b) {
  double worst = 0;
  for (Eigen::Index i = 0; i < a.result.rows(); ++i)
    worst = std::max(worst, (a.result.force.row(i) - b.result.force.row(i)).norm() /
                                b.result.force.row(i).norm());
  return worst;
}

const Pressed& ball() {
  static const Pressed pressed = press_and_drag(sphere_spec(kRadius_m, 0.3));
  return pressed;
}

TEST(Shapes, a_capsule_end_presses_as_a_ball_does) {
  for (Eigen::Index row = 0; row < ball().result.rows(); ++row)
    EXPECT_EQ(ball().result.status[row], RowStatus::good);
  const Pressed capsule =
      press_and_drag(shape("capsule", {{"radius", {kRadius_m}}, {"length", {0.04}}}));
  EXPECT_LT(difference(capsule, ball()), 2e-4);  // the solver's residual is 1e-3
}

TEST(Shapes, a_fine_mesh_of_a_ball_presses_as_the_ball_does) {
  ProbeSpec probe = shape("mesh", {{"smoothing", {kRadius_m / 20}}});
  probe.mesh = ball_mesh(kRadius_m, 5);
  const Pressed mesh = press_and_drag(probe);
  const double off = difference(mesh, ball());
  std::printf("mesh of a ball: %.2f %% off, %.2f s CPU against %.2f s\n", 100 * off, mesh.cpu_s,
              ball().cpu_s);
  validation::record_case("SHAPES/mesh_of_a_ball", ball().force_N(1), mesh.force_N(1), "N",
                          mesh.force_N(1) / ball().force_N(1) - 1, mesh.cpu_s);
  EXPECT_LT(off, 0.02);
}

TEST(Shapes, every_shape_is_pressed_and_dragged_to_the_end) {
  ProbeSpec lying = shape("capsule", {{"radius", {0.004}}, {"length", {0.02}}});
  lying.orientation = Vec3::UnitX();
  ProbeSpec box = shape("mesh", {});
  box.mesh = box_mesh(Vec3(0.004, 0.005, 0.012));
  const std::vector<std::pair<std::string, ProbeSpec>> shapes{
      {"flat", shape("flat", {{"radius", {0.005}}, {"edge_radius", {0.0005}}})},
      {"capsule lying", lying},
      {"cone of 65 degrees",
       shape("cone", {{"half_angle", {1.1344640137963142}}, {"tip_radius", {0.001}}})},
      {"mesh of a box", box}};
  for (const auto& [name, probe] : shapes) {
    const Pressed pressed = press_and_drag(probe);
    int good = 0;
    double before = 0;
    for (Eigen::Index i = 0; i < pressed.result.rows(); ++i) {
      good += pressed.result.status[i] == RowStatus::good;
      if (pressed.result.kind[i] != ExperimentKind::press ||
          pressed.result.status[i] != RowStatus::good)
        continue;
      EXPECT_GT(pressed.force_N(i), before) << name << " step " << i;
      before = pressed.force_N(i);
    }
    const SolverCounts& counts = pressed.result.cost.solver;
    std::printf(
        "%s: %d nodes, %.2f s CPU, %d Newton, %d factorizations, %d of %td rows, %.4f N at 1.5 "
        "mm\n",
        name.c_str(), pressed.result.cost.nodes, pressed.cpu_s, counts.newton,
        counts.factorizations, good, pressed.result.rows(), before);
    std::fflush(stdout);
    validation::record_case("SHAPES/" + name + "/good_rows",
                            static_cast<double>(pressed.result.rows()), good, "", 0, pressed.cpu_s);
    EXPECT_EQ(good, static_cast<int>(pressed.result.rows())) << name;
  }
}

}  // namespace
}  // namespace palpate::fem
