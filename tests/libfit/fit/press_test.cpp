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

TEST(press, fitted_curves_rise_from_zero_whatever_the_rows) {
  for (unsigned seed = 1; seed <= 30; ++seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> draw(0.5, 1);
    Recorder rig;
    rig.press(
        rig.add_point(Vec3::UnitX()), [&](double) { return draw(random); }, 0.01, 25);
    const FittedCurves fitted =
        fit_curves(rig.samples, {.family = CurveFamily::separable, .pieces = {6, 2, 4}});
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
  const FittedCurves fitted =
      fit_curves(rig.samples, {.family = CurveFamily::separable, .tolerance = 0.005}, {}, &report);
  EXPECT_LT(relative_rmse(fitted_curve(fitted, 0, CurveKind::normal), hertz, 0.01), 0.005);
  EXPECT_LE(fitted.curves.basis[0].pieces(), 4);
  EXPECT_NE(report.kind[0].reason.find("meets the tolerance"), std::string::npos);
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

// Once 0.1 um of an encoder's noise made a drag of a press: its curve was 0.135 of the truth.
TEST(press, three_axes_give_the_curve_that_one_axis_gives) {
  const Curve hertz = [](double d) { return 2e4 * std::pow(d, 1.5); };
  for (const double jitter_m : {1e-7, 1e-6, 1e-5, 1e-4, 3e-4})
    for (const double degrees : {0., 2., 5., 10.})
      for (unsigned seed = 1; seed <= 3; ++seed) {
        Recorder rig, axis;
        std::mt19937 random(seed);
        std::normal_distribution<double> draw;
        for (int p = 0; p < 4; ++p) {
          const Vec3 u = rig.inward(rig.add_point(Vec3(0.2 * p, -0.3, 1)));
          axis.add_point(u);
          const Vec3 lean = std::tan(degrees * 3.14159 / 180) * rig.tangent(p, 0.7 * p + seed);
          const Vec3 drift = 0.05 * rig.tangent(p, 2.1 * seed);  // of the sensor's frame
          std::vector<Vec3> moved, felt, deep, push;
          for (int i = 1; i <= 12; ++i) {
            const double d = 3e-3 * i / 12;
            Vec3 noise = jitter_m * Vec3(draw(random), draw(random), draw(random));
            noise -= noise.dot(u) * u;
            moved.push_back(d * (u + lean) + noise);
            felt.push_back(hertz(d) * (u + drift));
            deep.push_back(d * u);
            push.push_back(hertz(d) * u);
          }
          rig.add(p, ExperimentKind::press, moved, felt);
          axis.add(p, ExperimentKind::press, deep, push);
        }
        const FittedCurves three = fit_curves(rig.samples), one = fit_curves(axis.samples);
        for (Eigen::Index p = 0; p < 4; ++p) {
          const double off = relative_rmse(fitted_curve(three, p, CurveKind::normal),
                                           fitted_curve(one, p, CurveKind::normal), 3e-3);
          EXPECT_LT(off, 1e-5) << "jitter " << jitter_m << " m, lean " << degrees
                               << " degrees, seed " << seed << ", point " << p;
          EXPECT_LT(relative_rmse(fitted_curve(three, p, CurveKind::normal), hertz, 3e-3), 0.02);
          EXPECT_EQ(three.status[static_cast<std::size_t>(p)], FitStatus::good)
              << three.message[static_cast<std::size_t>(p)];
        }
      }
}

}  // namespace
}  // namespace palpate::test
