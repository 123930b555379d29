#include "libfit/validation/replay.hpp"

#include <gtest/gtest.h>

namespace palpate::validation {
namespace {

// Presses straight down at points along x, 1 mm in ten rows; stiffness of each [N/m].
Samples presses(const std::vector<double>& x_m, const std::vector<double>& stiffness_N_m) {
  constexpr int kRows = 10;
  Samples out;
  const auto points = static_cast<Eigen::Index>(x_m.size());
  out.point_position = Points::Zero(points, 3);
  out.point_normal = Points::Zero(points, 3);
  out.point_normal.col(2).setConstant(-1);
  out.deflection = out.force = out.torque = Points::Zero(kRows * points, 3);
  out.force_error = Eigen::VectorXd::Constant(kRows * points, 0.01);
  for (Eigen::Index p = 0; p < points; ++p) {
    out.point_position(p, 0) = x_m[p];
    out.point_name.push_back("p" + std::to_string(p));
    for (int k = 0; k < kRows; ++k) {
      const double depth_m = 1e-4 * (k + 1);
      out.point.push_back(static_cast<std::int32_t>(p));
      out.experiment.push_back(static_cast<std::int32_t>(p));
      out.kind.push_back(ExperimentKind::press);
      out.step.push_back(k);
      out.status.push_back(RowStatus::good);
      out.deflection(kRows * p + k, 2) = -depth_m;
      out.force(kRows * p + k, 2) = -stiffness_N_m[p] * depth_m;
    }
  }
  return out;
}

double last_N(const Replayed& answer) { return -answer.force_N(answer.force_N.rows() - 1, 2); }

TEST(recorded, the_nearest_press_answers_with_what_it_felt_at_that_depth) {
  const Samples fitted = presses({0, 0.01}, {100, 300}), asked = presses({0.002}, {1});
  const Replayed answer = neighbouring_presses(fitted, asked, 1);
  EXPECT_NEAR(last_N(answer), 100 * 1e-3, 1e-15);
  EXPECT_NEAR(-answer.force_N(4, 2), 100 * 5e-4, 1e-15);
}

TEST(recorded, inverse_distance_weighs_with_the_square) {
  const Samples fitted = presses({0, 0.03}, {100, 300}), asked = presses({0.01}, {1});
  EXPECT_NEAR(last_N(neighbouring_presses(fitted, asked, 8)), 1e-3 * (4 * 100 + 300) / 5, 1e-15);
}

TEST(recorded, a_point_never_answers_for_itself) {
  const Samples fitted = presses({0, 0.01, 0.03}, {100, 300, 900});
  const Replayed answer = neighbouring_presses(fitted, fitted, 1);
  EXPECT_NEAR(-answer.force_N(9, 2), 0.3, 1e-15);
  EXPECT_NEAR(last_N(answer), 0.3, 1e-15);
}

TEST(recorded, a_press_goes_on_straight_beyond_its_last_row) {
  Samples fitted = presses({0}, {100});
  for (std::size_t row = 5; row < 10; ++row) fitted.status[row] = RowStatus::rejected;
  EXPECT_NEAR(last_N(neighbouring_presses(fitted, presses({0.01}, {1}), 1)), 0.1, 1e-15);
}

TEST(recorded, drags_and_bad_rows_are_not_answered) {
  Samples asked = presses({0.01, 0.02}, {1, 1});
  for (std::size_t row = 0; row < 10; ++row) asked.kind[row] = ExperimentKind::drag;
  asked.status[10] = RowStatus::rejected;
  const Replayed answer = neighbouring_presses(presses({0}, {100}), asked, 1);
  for (int row = 0; row < 11; ++row) EXPECT_FALSE(answer.is_answered[row]) << row;
  for (int row = 11; row < 20; ++row) EXPECT_TRUE(answer.is_answered[row]) << row;
}

TEST(recorded, points_left_out_answer_with_the_curves_that_others_give_them) {
  FittedCurves curves;
  curves.position = Points::Zero(2, 3);
  curves.position(1, 0) = 0.01;
  curves.curves.basis.assign(kCurveKinds, CurveBasis{1, {0, 1e-3}});
  InterpolationChoice found;
  found.left_out = {1};
  found.left_out_normal = Controls::Zero(1, 2);
  found.left_out_normal(0, 1) = 0.5;
  const Replayed answer = left_out_presses(curves, found, presses({0, 0.01}, {1, 1}));
  EXPECT_FALSE(answer.is_answered[9]);
  EXPECT_NEAR(last_N(answer), 0.5, 1e-12);
}

}  // namespace
}  // namespace palpate::validation
