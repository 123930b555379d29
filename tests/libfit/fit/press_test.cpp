#include <gtest/gtest.h>

#include "tests/libfit/fit/synthetic.hpp"

namespace palpate::test {
namespace {

// Random monotone controls of a random size, in the model class.
Eigen::VectorXd random_controls(const CurveBasis& basis, unsigned seed, double force_N) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> draw(0, 1);
  Eigen::VectorXd increments(basis.size() - 1);
  for (double& a : increments) a = draw(random) < 0.2 ? 0 : draw(random) * force_N / basis.size();
  return fit::controls_of(increments);
}

Curve curve_of(const CurveBasis& basis, const Eigen::VectorXd& control) {
  return [tables = tabulate(basis), control](double x) {
    return runtime::curve_value(fit::view(tables), control.data(), x);
  };
}

TEST(press, recovers_curves_of_the_model_class_from_noiseless_rows) {
  for (int degree = 1; degree <= 4; ++degree) {
    const CurveBasis basis{degree, {0, 0.002, 0.003, 0.007, 0.01}};
    Recorder rig;
    std::vector<Eigen::VectorXd> truth;
    for (unsigned seed = 1; seed <= 12; ++seed) {
      const int p = rig.add_point(Vec3(0.1 * seed, 1, -0.3));
      truth.push_back(random_controls(basis, seed, 3));
      rig.press(p, curve_of(basis, truth.back()), 0.01, 40);
    }
    FitOptions options{.degree = degree};
    options.knots_m[0] = basis.knots_m;
    const FittedCurves fitted = fit_curves(rig.samples, options);
    for (Eigen::Index p = 0; p < fitted.curves.points(); ++p) {
      const Eigen::VectorXd found = fitted.curves.control[0].row(p);
      const auto at = static_cast<std::size_t>(p);
      EXPECT_LT((found - truth[at]).cwiseAbs().maxCoeff(), 1e-6 * truth[at].maxCoeff())
          << "degree " << degree << " seed " << p + 1 << "\n"
          << found << "\n\n"
          << truth[at];
    }
  }
}

TEST(press, linear_rows_get_one_piece_and_their_slope) {
  Recorder rig;
  rig.press(
      rig.add_point(Vec3::UnitZ()), [](double d) { return 400 * d; }, 0.01, 20);
  FitReport report;
  const FittedCurves fitted = fit_curves(rig.samples, {}, {}, &report);
  EXPECT_EQ(fitted.curves.basis[0].pieces(), 1) << report.kind[0].reason;
  EXPECT_LT(relative_rmse(
                fitted_curve(fitted, 0, CurveKind::normal), [](double d) { return 400 * d; }, 0.02),
            1e-6);
}

TEST(press, fitted_curves_rise_from_zero_whatever_the_rows) {
  for (unsigned seed = 1; seed <= 30; ++seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> draw(0.5, 1);
    Recorder rig;
    rig.press(
        rig.add_point(Vec3::UnitX()), [&](double) { return draw(random); }, 0.01, 25);
    const FittedCurves fitted = fit_curves(rig.samples, {.pieces = {6, 2, 4}});
    for (const auto& control : fitted.curves.control) {
      EXPECT_EQ(control(0, 0), 0.0);
      for (Eigen::Index j = 1; j < control.cols(); ++j) {
        EXPECT_GE(control(0, j), control(0, j - 1)) << "seed " << seed;
        EXPECT_EQ(control(0, j), static_cast<double>(static_cast<float>(control(0, j))));
      }
    }
    if (fitted.status[0] == FitStatus::failed) continue;
    const auto& lateral = fitted.curves.control[1];
    for (Eigen::Index j = 1; j < lateral.cols(); ++j)
      EXPECT_GT(lateral(0, j), lateral(0, j - 1)) << "seed " << seed;
  }
}

TEST(press, hertz_curve_meets_the_tolerance_with_the_pieces_chosen) {
  const Curve hertz = [](double d) { return 2000 * std::pow(d, 1.5); };
  Recorder rig;
  rig.press(rig.add_point(Vec3::UnitZ()), hertz, 0.01, 40);
  FitReport report;
  const FittedCurves fitted = fit_curves(rig.samples, {.tolerance = 0.005}, {}, &report);
  EXPECT_LT(relative_rmse(fitted_curve(fitted, 0, CurveKind::normal), hertz, 0.01), 0.005);
  EXPECT_LE(fitted.curves.basis[0].pieces(), 4);
  EXPECT_NE(report.kind[0].reason.find("meets the tolerance"), std::string::npos);
  ASSERT_FALSE(report.kind[0].evidence.empty());
}

TEST(press, order_of_rows_does_not_matter) {
  Recorder rig;
  rig.press(
      rig.add_point(Vec3::UnitZ()), [](double d) { return 50 * d + 4e4 * d * d; }, 0.01, 30);
  add_noise(rig.samples, 0.01, 3);
  const FittedCurves forward = fit_curves(rig.samples);
  Samples shuffled = rig.samples;
  std::vector<Eigen::Index> order(30);
  for (Eigen::Index i = 0; i < 30; ++i) order[static_cast<std::size_t>(i)] = (7 * i + 4) % 30;
  shuffled.deflection = rig.samples.deflection(order, Eigen::all);
  shuffled.force = rig.samples.force(order, Eigen::all);
  const FittedCurves mixed = fit_curves(shuffled);
  const auto& a = forward.curves.control[0];
  const auto& b = mixed.curves.control[0];
  ASSERT_EQ(a.cols(), b.cols());
  EXPECT_LT((a - b).cwiseAbs().maxCoeff(), 3e-7 * a.maxCoeff());  // one float32 step at most
  EXPECT_EQ(forward.message, mixed.message);
}

}  // namespace
}  // namespace palpate::test
