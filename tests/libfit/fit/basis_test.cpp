#include <gtest/gtest.h>

#include "tests/libfit/fit/synthetic.hpp"

// Bases that held-out rows support: docs/method.md, section 3.

namespace palpate::test {
namespace {

FitOptions presses(double tolerance, int jobs = 0) {
  FitOptions options{.family = CurveFamily::separable, .tolerance = tolerance};
  options.jobs = jobs;
  return options;
}

TEST(basis, follows_a_body_that_stiffens_at_its_end_although_its_rows_count_less_there) {
  // As a silicone does over its last two of twenty millimetres. Clipped as outliers, these rows
  // left bases of one or two pieces, up to 70 % off.
  for (const double strength_N : {60, 120, 240})
    for (const double power : {2.0, 3.0})
      for (const double from_m : {0.016, 0.0175}) {
        Recorder rig;
        rig.press(
            rig.add_point(Vec3::UnitZ()),
            [=](double d) {
              const double end = std::max(0.0, (d - from_m) / (0.02 - from_m));
              return 3e3 * d + 1e5 * d * d + strength_N * std::pow(end, power);
            },
            0.02, 40);
        for (Eigen::Index i = 0; i < rig.samples.rows(); ++i)
          rig.samples.force_error[i] = 0.05 * rig.samples.force.row(i).norm();
        FitReport report;
        fit_curves(rig.samples, presses(0.02), {}, &report);
        EXPECT_LT(report.error.max, 0.045) << strength_N << " N, power " << power << " from "
                                           << from_m << " m: " << report.kind[0].reason;
      }
}

TEST(basis, of_a_line_with_single_outliers_has_one_piece) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Recorder rig;
    for (int p = 0; p < 4; ++p)
      rig.press(
          rig.add_point(Vec3::UnitZ()), [](double d) { return 300 * d; }, 0.01, 60);
    add_noise(rig.samples, 0.01, seed);
    for (Eigen::Index i = 7; i < rig.samples.rows(); i += 19) rig.samples.force.row(i) *= 1.5;
    FitReport report;
    const FittedCurves fitted = fit_curves(rig.samples, presses(0.02), {}, &report);
    EXPECT_EQ(fitted.curves.basis[0].pieces(), 1) << "seed " << seed << report.kind[0].reason;
  }
}

}  // namespace
}  // namespace palpate::test
