#include <gtest/gtest.h>

#include "libfit/fit/spline/monotone_least_squares.hpp"
#include "tests/libfit/fit/synthetic.hpp"

// Data of NIST's Statistical Reference Datasets whose models are ours, with certified values
// (https://www.itl.nist.gov/div898/strd/lls/lls.shtml): NoInt1, a line through the origin, and
// Pontius, a load cell's calibration by a parabola with an offset, which a sensor's bias is here.

namespace palpate::test {
namespace {

// Correct significant digits of an estimate.
double digits(double estimate, double certified) {
  return -std::log10(std::max(std::abs(estimate - certified) / std::abs(certified), 1e-16));
}

void record(Recorder& rig, const std::vector<double>& depth, const std::vector<double>& push) {
  std::vector<Vec3> deflection, force;
  for (std::size_t i = 0; i < depth.size(); ++i) {
    deflection.emplace_back(0, 0, depth[i]);
    force.emplace_back(0, 0, push[i]);
  }
  rig.add(rig.add_point(Vec3::UnitZ()), ExperimentKind::press, deflection, force, 1.0);
}

constexpr double kNoInt1Slope = 2.07438016528926, kNoInt1SlopeError = 0.165289256198347e-1;

TEST(certified, a_line_through_zero_has_the_certified_slope_and_error) {
  std::vector<double> depth, push;
  for (int i = 0; i <= 10; ++i) depth.push_back(60 + i), push.push_back(130 + i);
  std::vector<fit::CurveRow> rows;
  for (std::size_t i = 0; i < depth.size(); ++i) rows.push_back({depth[i], push[i], 1, 0});
  fit::WeakPrior none{Eigen::MatrixXd::Zero(0, 1), Eigen::VectorXd::Zero(0), 0, 0};
  const Eigen::VectorXd a = fit::fit_increments({1, {0, 70}}, rows, Eigen::VectorXd::Zero(1), none);
  EXPECT_GT(digits(a[0] / 70, kNoInt1Slope), 13);

  // The whole fit stores float32, of 7 digits. These residuals run straight, not at random, so the
  // certified error, which takes them for independent, is a lower bound of ours.
  Recorder rig;
  record(rig, depth, push);
  FitOptions options{.degree = 1};
  options.knots_m[0] = {0, 70};
  const FittedCurves fitted = fit_curves(rig.samples, options);
  EXPECT_GT(digits(fitted.curves.control[0](0, 1) / 70, kNoInt1Slope), 5);
  EXPECT_GE(std::sqrt(fitted.covariance[0](0, 0)) / 70, 0.999 * kNoInt1SlopeError);
}

TEST(certified, a_load_cells_parabola_offset_and_errors_are_the_certified_ones) {
  const std::vector<double> first{.11019,  .21956,  .32949,  .43899,  .54803,  .65694,  .76562,
                                  .87487,  .98292,  1.09146, 1.20001, 1.30822, 1.41599, 1.52399,
                                  1.63194, 1.73947, 1.84646, 1.95392, 2.06128, 2.16844};
  const std::vector<double> second{.11052,  .22018,  .32939,  .43886,  .54798,  .65739,  .76596,
                                   .87474,  .98300,  1.09150, 1.20004, 1.30818, 1.41613, 1.52408,
                                   1.63159, 1.73965, 1.84696, 1.95445, 2.06177, 2.16829};
  const double b0 = 0.673565789473684e-3, b1 = 0.732059160401003e-6, b2 = -0.316081871345029e-14;
  const double b0_error = 0.107938612033077e-3, residual_deviation = 0.205177424076185e-3;
  const double x_scale = 3e6;  // of the last load; depth in our terms
  std::vector<double> depth, push;
  for (const auto& run : {first, second})
    for (std::size_t i = 0; i < run.size(); ++i) {
      depth.push_back((static_cast<double>(i) + 1) / 20);
      push.push_back(run[i]);
    }

  // Degree 2 in one piece: f = b0 + 2 a1 t (1 - t) + (a1 + a2) t^2 on t = x / 3e6.
  const SplineTables tables = tabulate(CurveBasis{2, {0, 1}});
  Eigen::MatrixXd A(40, 3);
  Eigen::VectorXd b(40), lower(3);
  for (Eigen::Index i = 0; i < 40; ++i) {
    const auto at = static_cast<std::size_t>(i);
    A.row(i) << fit::increment_weights(fit::view(tables), depth[at]).transpose(), 1;
    b[i] = push[at];
  }
  lower << 0, 0, -1;  // an offset has no sign
  const Eigen::VectorXd x = fit::bounded_least_squares(A, b, lower);
  EXPECT_GT(digits(x[2], b0), 9);
  EXPECT_GT(digits(2 * x[0] / x_scale, b1), 12);
  EXPECT_GT(digits((x[1] - x[0]) / (x_scale * x_scale), b2), 9);

  Recorder rig;  // through the whole fit, the offset a sensor's bias
  record(rig, depth, push);
  rig.samples.force_error.setConstant(residual_deviation);
  FitOptions options{.degree = 2};
  options.knots_m[0] = {0, 1};
  options.estimates[kBias] = true;
  const FittedCurves fitted = fit_curves(rig.samples, options);
  ASSERT_EQ(fitted.recordings.bias_N.size(), 1);
  EXPECT_NEAR(fitted.recordings.bias_N[0], b0, 0.1 * b0_error);
  EXPECT_NEAR(fitted.recordings.bias_deviation_N[0], b0_error, 0.35 * b0_error);
  for (std::size_t i = 0; i < 20; ++i) {
    const double t = depth[i], truth = b1 * x_scale * t + b2 * x_scale * x_scale * t * t;
    EXPECT_NEAR(fitted_curve(fitted, 0, CurveKind::normal)(t), truth, 0.1 * residual_deviation);
  }
}

}  // namespace
}  // namespace palpate::test
