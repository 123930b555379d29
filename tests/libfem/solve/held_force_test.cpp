// Holds of given force: the tool sinks while the body creeps.

#include <gtest/gtest.h>

#include <cmath>

#include "block.hpp"
#include "libfem/solve/experiments/simulate.hpp"

namespace palpate::fem {
namespace {

const Vec3 kInward = -Vec3::UnitZ();
constexpr double kShare = 1, kTime_s = 0.2;

SimulationSetup relaxing_block(double poisson) {
  SimulationSetup setup = block_setup(0);
  setup.materials = {
      {"neo-hookean",
       {kYoung_Pa, poisson},
       {Eigen::VectorXd::Constant(1, kShare), Eigen::VectorXd::Constant(1, kTime_s)}}};
  return setup;
}

/// A force that is reached after approach_s and held for `hold_s` in `rows` rows.
ToolPath held(double force_N, double deepest_m, double approach_s, double hold_s, int rows) {
  ToolPath path{0, (deepest_m * kInward).transpose().replicate(1 + rows, 1)};
  path.held_N.setConstant(1 + rows, force_N);
  path.time_s.setConstant(1 + rows, approach_s);
  for (int k = 1; k <= rows; ++k)
    path.time_s[k] += hold_s * std::pow(10, 2.5 * (k - rows) / (rows - 1));
  return path;
}

void expect_held(const PointRows& rows, double force_N) {
  double before_m = 0;
  for (const PointRow& row : rows.rows) {
    ASSERT_EQ(row.status, RowStatus::good) << row.step;
    EXPECT_NEAR(row.force.dot(kInward) / force_N, 1, 1e-3) << row.step;
    EXPECT_GT(row.deflection.dot(kInward), before_m) << row.step;
    before_m = row.deflection.dot(kInward);
  }
}

// nu 0: all of the body relaxes alike, and a punch pressed lightly meets F = int psi d(k d). With
// psi(t) = 1 + g e^{-t/tau} its depth is 1 + g - g e^{-t/((1 + g) tau)} times that at first: it
// creeps 1 + g times as slowly as it relaxes.
TEST(HeldForce, a_punch_creeps_as_the_closed_form_of_one_branch) {
  constexpr double kApproach_s = 1e-3, kForce_N = 1e-3;
  SimulationSetup setup = relaxing_block(0);
  setup.probe.shape = "flat";
  const PointRows rows =
      Simulator(setup).follow(block_top(), kInward, held(kForce_N, 5e-5, kApproach_s, 2, 40));
  expect_held(rows, kForce_N);
  for (const PointRow& row : rows.rows) {
    const double since_s = row.time_s - kApproach_s;
    const double expected = 1 + kShare - kShare * std::exp(-since_s / ((1 + kShare) * kTime_s));
    EXPECT_NEAR(row.deflection.norm() / rows.rows[0].deflection.norm() / expected, 1, 0.005)
        << since_s;
  }
}

// Meshes are those of the deepest that the tool may go, so forces differ by what rows state.
TEST(HeldForce, the_force_of_a_row_is_extrapolated_and_what_the_path_of_its_deflections_meets) {
  constexpr double kForce_N = 0.35;
  SimulationSetup setup = relaxing_block(kPoisson);
  setup.options.coarse_ratio = 1.6;
  setup.options.growth = 0.6;
  const Simulator simulator(setup);
  const ToolPath asked = held(kForce_N, 0.006, 0.1, 1, 5);
  const PointRows rows = simulator.follow(block_top(), kInward, asked);
  expect_held(rows, kForce_N);
  ToolPath found{0, asked.deflections, asked.time_s};
  for (const PointRow& row : rows.rows) found.deflections.row(row.step) = row.deflection;
  const PointRows again = simulator.follow(block_top(), kInward, found);
  for (std::size_t i = 0; i < rows.rows.size(); ++i)
    EXPECT_LT((again.rows[i].force - rows.rows[i].force).norm(),
              again.rows[i].force_error + rows.rows[i].force_error)
        << i;
}

TEST(HeldForce, what_cannot_be_reached_has_a_status_and_no_force) {
  const PointRows rows =
      Simulator(relaxing_block(0)).follow(block_top(), kInward, held(5, 0.002, 0.1, 1, 3));
  ASSERT_EQ(rows.rows.size(), 4u);
  EXPECT_EQ(rows.rows[0].status, RowStatus::not_converged);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_TRUE(i == 0 || rows.rows[i].status == RowStatus::not_reached) << i;
    EXPECT_EQ(rows.rows[i].force, Vec3(Vec3::Zero())) << i;
    EXPECT_TRUE(std::isnan(rows.rows[i].force_error)) << i;
  }
}

TEST(HeldForce, steps_that_ask_for_a_deflection_have_it) {
  ToolPath path = held(0.1, 0.003, 0.1, 1, 3);
  path.deflections.row(0) = 0.0015 * kInward;
  path.held_N[0] = NAN;
  const PointRows rows = Simulator(relaxing_block(0)).follow(block_top(), kInward, path);
  EXPECT_EQ(rows.rows[0].deflection, Vec3(0.0015 * kInward));
  EXPECT_GT(std::abs(rows.rows[0].force.dot(kInward) - 0.1), 0.005);
  for (std::size_t i = 1; i < rows.rows.size(); ++i) {
    EXPECT_EQ(rows.rows[i].status, RowStatus::good) << i;
    EXPECT_NEAR(rows.rows[i].force.dot(kInward), 0.1, 1e-4) << i;
  }
}

TEST(HeldForce, samples_know_the_force_and_are_found_again_by_it) {
  const Simulator simulator(relaxing_block(0));
  TestPoints points;
  points.position = block_top().transpose();
  points.normal = kInward.transpose();
  points.name = {"p"};
  const ExperimentList list =
      paths_at(points, {held(0.05, 0.002, 0.1, 1, 3)}, ExperimentKind::hold);
  const Samples rows = simulate(simulator, list, press_only(1));
  EXPECT_EQ(rows.held_N, list.experiments[0].path.held_N);
  EXPECT_EQ(rows.time_s, list.experiments[0].path.time_s);
  EXPECT_EQ(rows.kind.front(), ExperimentKind::hold);
  EXPECT_TRUE(without_rows(list, known_rows(list, rows, 1), 1).empty());
  SimulateOptions resumed;
  resumed.already_done = known_rows(list, rows, 1);
  const Samples kept = simulate(simulator, list, press_only(1), resumed);
  EXPECT_EQ(kept.held_N, rows.held_N);
  EXPECT_EQ(kept.deflection, rows.deflection);
}

}  // namespace
}  // namespace palpate::fem
