// Torques about a ball's centre and at a handle, and where a slip begins.

#include <gtest/gtest.h>

#include <cmath>

#include "libfit/validation/replay.hpp"

namespace palpate::validation {
namespace {

Samples one_row(const Vec3& force_N, const Vec3& torque_Nm) {
  Samples rows;
  rows.point_normal = Vec3(0, 0, 1).transpose();
  rows.point = {0};
  rows.status = {RowStatus::good};
  rows.deflection = Vec3(0.001, 0, 0.002).transpose();
  rows.force = force_N.transpose();
  rows.force_error = Eigen::VectorXd::Zero(1);
  rows.torque = torque_Nm.transpose();
  return rows;
}

double largest_share(const Vec3& reference_Nm, const Vec3& engine_Nm) {
  const Samples rows = one_row(Vec3::Zero(), reference_Nm);
  Replayed engine(rows);
  engine.is_answered = {1};
  engine.torque_Nm = engine_Nm.transpose();
  return summarize(compare(rows, engine, Levers{})).all.torque.max_rel;
}

TEST(Torque, of_a_soft_body_is_over_a_tenth_of_its_largest_and_of_none_has_no_share) {
  EXPECT_NEAR(largest_share(Vec3(1e-6, 0, 0), Vec3(1.2e-6, 0, 0)), 0.2, 1e-12);
  EXPECT_TRUE(std::isnan(largest_share(Vec3::Zero(), Vec3(1e-6, 0, 0))));
}

TEST(Torque, is_about_the_centre_of_a_ball_where_a_force_through_it_does_not_count) {
  const Samples rows = one_row({1, 0, 5}, {0, 0.001, 0});
  Replayed engine(rows);
  engine.is_answered = {1};
  const Comparison of_ball = compare(rows, engine, Levers{0.01});
  ASSERT_EQ(of_ball.rows.size(), 1u);
  EXPECT_LT((of_ball.torque_Nm(0, 0.01) - Vec3(0, 0.011, 0)).norm(), 1e-15);
  const ErrorFigures error = summarize(of_ball).all.torque;
  EXPECT_NEAR(error.max, 0.011, 1e-15);
  EXPECT_NEAR(error.max_rel, 1, 1e-12);
  EXPECT_NEAR(summarize(compare(rows, engine, Levers{})).all.torque.max, 0.001, 1e-15);
}

// A straight press is turned by nothing, a side force by its lever: 100 N mm of 1 N at 100 mm.
TEST(Torque, at_a_handle_is_the_side_force_times_its_length_and_a_lean_moves_the_grip) {
  Samples rows = one_row({1, 0, 5}, Vec3::Zero());
  Replayed engine(rows);
  engine.is_answered = {1};
  engine.force_N = Vec3(0.8, 0, 6).transpose();
  const Levers held{0, 0.1};
  const StatedError upright = summarize(compare(rows, engine, held)).all;
  EXPECT_NEAR(upright.handle.typical, 0.1, 1e-15);
  EXPECT_NEAR(upright.handle.max, 0.02, 1e-15);
  EXPECT_NEAR(upright.handle.max_rel, 0.2, 1e-12);
  EXPECT_EQ(upright.torque.max, 0);
  // The shaft leans by the force's own angle: the grip lies behind it, and nothing turns the hand.
  rows.point_normal = Vec3(0, 0, -1).transpose();  // outward is z, where x and y are the tangents
  rows.force = Vec3(1, 0, -5).transpose();
  rows.lean = Eigen::Vector2d(-1, 0).transpose() / std::sqrt(26);
  EXPECT_NEAR(compare(rows, engine, held).torque_Nm(0, held.handle_m).norm(), 0, 1e-15);
  EXPECT_TRUE(std::isnan(summarize(compare(rows, engine, Levers{0.01})).all.handle.max));
}

// Coulomb's friction on a spring: the side force is min(k x, mu N).
TEST(SlipOnset, is_where_the_side_force_stops_growing_in_mm_and_newtons) {
  constexpr double kPush_N = 2, kStiffness_N_m = 400, kStep_m = 1e-4;
  Samples rows;
  rows.point_normal = Vec3(0, 0, 1).transpose();
  const int steps = 60;
  rows.deflection.resize(steps, 3);
  rows.force.resize(steps, 3);
  rows.force_error = Eigen::VectorXd::Zero(steps);
  for (int i = 0; i < steps; ++i) {
    const double x_m = kStep_m * (i < 40 ? i : 80 - i);  // it turns at 4 mm
    rows.point.push_back(0);
    rows.experiment.push_back(0);
    rows.path.push_back(PathKind::back_and_forth);
    rows.status.push_back(RowStatus::good);
    rows.deflection.row(i) << x_m, 0, 0.002;
    rows.force.row(i) << std::min(kStiffness_N_m * x_m, 0.3 * kPush_N), 0, kPush_N;
  }
  Replayed engine(rows);
  engine.is_answered.assign(steps, 1);
  engine.is_sliding.assign(steps, 1);
  for (int i = 0; i < steps; ++i)
    engine.force_N.row(i) << std::min(0.5 * kStiffness_N_m * rows.deflection(i, 0), 0.25 * kPush_N),
        0, kPush_N;
  const SlipOnset onset = summarize(compare(rows, engine)).slip_onset;
  EXPECT_EQ(onset.paths, 1u);
  // 0.9 of 0.6 N at 400 N/m are 1.35 mm, of 0.5 N at 200 N/m 2.25 mm.
  EXPECT_NEAR(onset.place_m.p95, 0.9e-3, 1e-9);
  EXPECT_NEAR(onset.force_N.p95, 0.9 * 0.1, 1e-9);
  engine.is_sliding.assign(steps, 0);
  EXPECT_EQ(summarize(compare(rows, engine)).slip_onset.paths, 0u) << "it sticks to the end";
  engine.is_sliding.assign(steps, 1);
  engine.force_N.col(0).setZero();
  EXPECT_EQ(summarize(compare(rows, engine)).slip_onset.paths, 0u) << "nothing holds it aside";
}

}  // namespace
}  // namespace palpate::validation
