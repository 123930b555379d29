// A ball that is pressed down at the foot of a step rests on the step before it reaches the floor.

#include <gtest/gtest.h>

#include <numbers>

#include "block.hpp"
#include "libfem/solve/experiments/simulator_state.hpp"

namespace palpate::fem {
namespace {

const Vec3 kInward = -Vec3::UnitZ();
constexpr double kFloor_m = 0.02, kTop_m = 0.03, kFoot_m = 0.03, kBank_m = 0.003;

/// The block of block_setup with a step of 10 mm across it whose bank stands at 73 degrees.
SimulationSetup step_setup() {
  SimulationSetup setup = block_setup(0.2);
  setup.volume = structured_block(Vec3(7, 0.06, 1), {7, 4, 3});
  constexpr double kAcross_m[] = {0, 0.012, 0.024, kFoot_m, kFoot_m + kBank_m, 0.04, 0.05, 0.06};
  for (auto node : setup.volume.nodes.rowwise()) {
    const auto column = static_cast<std::size_t>(std::lround(node[0]));
    node[2] *= column <= 3 ? kFloor_m : kTop_m;
    node[0] = kAcross_m[column];
  }
  setup.is_held = held_below(setup.volume.nodes, 1e-6);
  setup.surface = {setup.volume.nodes, boundary_triangles(setup.volume.tets)};
  return setup;
}

double angle_deg(const PointRows& rows, Eigen::Index row) {
  return std::acos(rows.force.row(row).normalized().dot(kInward)) * 180 / std::numbers::pi;
}

TEST(WedgedPress, at_the_foot_of_a_step_says_so_and_keeps_its_force) {
  const Vec3 foot(kFoot_m - 0.0048, 0.0283, kFloor_m);
  const Simulator simulator(step_setup());
  Experiments press = press_only(2);
  press.depth_m = 0.002;
  for (const bool is_quick : {false, true}) {
    const PointRows result = is_quick ? simulator.press_quickly(foot, kInward, press)
                                      : simulator.press_and_drag(foot, kInward, press);
    ASSERT_EQ(result.rows(), 2);
    for (Eigen::Index row = 0; row < result.rows(); ++row) {
      EXPECT_GT(angle_deg(result, row), 45);
      EXPECT_GT(result.force.row(row).norm(), 1e-3);
      EXPECT_EQ(result.status[row], RowStatus::wedged) << angle_deg(result, row) << " degrees";
    }
  }
}

TEST(WedgedPress, ten_millimetres_away_from_the_step_is_good) {
  const PointRows result =
      Simulator(step_setup()).press_and_drag({0.013, 0.0283, kFloor_m}, kInward, press_only(2));
  for (Eigen::Index row = 0; row < result.rows(); ++row) {
    EXPECT_LT(angle_deg(result, row), 15);
    EXPECT_EQ(result.status[row], RowStatus::good);
  }
}

TEST(WedgedPress, begins_at_45_degrees_and_is_none_of_drags_and_paths) {
  const auto status_at = [](double degrees, ExperimentKind kind, RowStatus before) {
    const double angle = degrees * std::numbers::pi / 180;
    ExperimentPlan plan;
    plan.add_row(kind, 0, 0, Vec3::Zero());
    plan.rows.status[0] = before;
    plan.rows.force.row(0) = 0.3 * (std::cos(angle) * kInward + std::sin(angle) * Vec3::UnitY());
    mark_wedged(kInward, plan.rows);
    return plan.rows.status[0];
  };
  const RowStatus good = RowStatus::good;
  EXPECT_EQ(status_at(30, ExperimentKind::press, good), good);
  EXPECT_EQ(status_at(44.9, ExperimentKind::press, good), good);
  EXPECT_EQ(status_at(45.1, ExperimentKind::press, good), RowStatus::wedged);
  EXPECT_EQ(status_at(71, ExperimentKind::press, good), RowStatus::wedged);
  EXPECT_EQ(status_at(71, ExperimentKind::press, RowStatus::rejected), RowStatus::rejected);
  EXPECT_EQ(status_at(71, ExperimentKind::drag, good), good);
  EXPECT_EQ(status_at(71, ExperimentKind::path, good), good);
  ExperimentPlan without_force;
  without_force.add_row(ExperimentKind::press, 0, 0, Vec3::Zero());
  without_force.rows.status[0] = good;
  mark_wedged(kInward, without_force.rows);
  EXPECT_EQ(without_force.rows.status[0], good);
}

}  // namespace
}  // namespace palpate::fem
