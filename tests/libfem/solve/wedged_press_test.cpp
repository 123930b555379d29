// A ball that is pressed down at the foot of a step rests on the step before it reaches the floor.

#include <gtest/gtest.h>

#include <numbers>

#include "block.hpp"
#include "libfem/solve/experiments/record_rows.hpp"

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

double angle_deg(const PointRow& row) {
  return std::acos(row.force.normalized().dot(kInward)) * 180 / std::numbers::pi;
}

TEST(WedgedPress, at_the_foot_of_a_step_says_so_and_keeps_its_force) {
  const Vec3 foot(kFoot_m - 0.0048, 0.0283, kFloor_m);
  const Simulator simulator(step_setup());
  Experiments press = press_only(2);
  press.depth_m = 0.002;
  for (const bool is_quick : {false, true}) {
    const PointRows result = is_quick ? simulator.press_quickly(foot, kInward, press)
                                      : simulator.press_and_drag(foot, kInward, press);
    ASSERT_EQ(result.rows.size(), 2u);
    for (const PointRow& row : result.rows) {
      EXPECT_GT(angle_deg(row), 45);
      EXPECT_GT(row.force.norm(), 1e-3);
      EXPECT_EQ(row.status, RowStatus::wedged) << angle_deg(row) << " degrees";
    }
  }
}

TEST(WedgedPress, ten_millimetres_away_from_the_step_is_good) {
  const PointRows result =
      Simulator(step_setup()).press_and_drag({0.013, 0.0283, kFloor_m}, kInward, press_only(2));
  for (const PointRow& row : result.rows) {
    EXPECT_LT(angle_deg(row), 15);
    EXPECT_EQ(row.status, RowStatus::good);
  }
}

TEST(WedgedPress, begins_at_45_degrees_and_is_none_of_drags_and_paths) {
  const auto status_at = [](double degrees, ExperimentKind kind, RowStatus before) {
    const double angle = degrees * std::numbers::pi / 180;
    std::vector<PointRow> rows(1);
    rows[0].kind = kind;
    rows[0].status = before;
    rows[0].force = 0.3 * (std::cos(angle) * kInward + std::sin(angle) * Vec3::UnitY());
    mark_wedged(kInward, rows);
    return rows[0].status;
  };
  const RowStatus good = RowStatus::good;
  EXPECT_EQ(status_at(30, ExperimentKind::press, good), good);
  EXPECT_EQ(status_at(44.9, ExperimentKind::press, good), good);
  EXPECT_EQ(status_at(45.1, ExperimentKind::press, good), RowStatus::wedged);
  EXPECT_EQ(status_at(71, ExperimentKind::press, good), RowStatus::wedged);
  EXPECT_EQ(status_at(71, ExperimentKind::press, RowStatus::rejected), RowStatus::rejected);
  EXPECT_EQ(status_at(71, ExperimentKind::drag, good), good);
  EXPECT_EQ(status_at(71, ExperimentKind::path, good), good);
  std::vector<PointRow> without_force(1);
  without_force[0].status = good;
  mark_wedged(kInward, without_force);
  EXPECT_EQ(without_force[0].status, good);
}

}  // namespace
}  // namespace palpate::fem
