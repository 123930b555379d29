#include <gtest/gtest.h>

#include "tests/libfit/fit/synthetic.hpp"

namespace palpate::test {
namespace {

Samples some_points(int count) {
  Recorder rig;
  for (int p = 0; p < count; ++p) {
    const int point = rig.add_point(Vec3(0.1 * p, 0.2, -1));
    const double k = 300 + 20 * p;
    const Curve normal = [k](double d) { return k * d * (1 + 40 * d); };
    const Curve lateral = [k](double r) { return 0.7 * k * r; };
    const Curve limit = [k](double d) { return 0.35 * k * d; };
    rig.press(point, normal, 0.01, 12);
    for (const double depth_m : {0.004, 0.008})
      rig.flat_drag(point, normal, lateral, limit, depth_m, 0.012, 14, 0.3);
  }
  return rig.samples;
}

void scale_rows_of(Samples& samples, std::int32_t point, double factor) {
  for (Eigen::Index i = 0; i < samples.rows(); ++i)
    if (samples.point[static_cast<std::size_t>(i)] == point) samples.force.row(i) *= factor;
}

TEST(WarmStart, without_a_change_every_point_is_kept_as_it_is) {
  const Samples samples = some_points(6);
  const FittedCurves first = fit_curves(samples);
  FitOptions options;
  options.warm_start = &first;
  FitReport report;
  const FittedCurves again = fit_curves(samples, options, {}, &report);
  EXPECT_EQ(report.kept, 6U);
  for (std::size_t kind = 0; kind < kCurveKinds; ++kind)
    EXPECT_EQ(again.curves.control[kind], first.curves.control[kind]);
  EXPECT_EQ(again.curves.lean, first.curves.lean);
  EXPECT_EQ(again.rms_residual_N, first.rms_residual_N);
}

TEST(WarmStart, refits_the_changed_point_alone_and_brings_what_a_whole_fit_brings) {
  Samples samples = some_points(8);
  const FittedCurves first = fit_curves(samples);
  scale_rows_of(samples, 3, 1.2);
  FitOptions options;
  options.warm_start = &first;
  FitReport report;
  const FittedCurves warm = fit_curves(samples, options, {}, &report);
  EXPECT_EQ(report.kept, 7U);
  const FittedCurves whole = fit_curves(samples);
  for (std::size_t kind = 0; kind < kCurveKinds; ++kind) {
    ASSERT_EQ(whole.curves.basis[kind].knots_m, warm.curves.basis[kind].knots_m);
    const double size = whole.curves.control[kind].maxCoeff();
    EXPECT_LT((warm.curves.control[kind] - whole.curves.control[kind]).cwiseAbs().maxCoeff(),
              1e-9 * size)
        << kCurveNames[kind];
    EXPECT_NE(warm.curves.control[kind].row(3), first.curves.control[kind].row(3));
  }
}

TEST(WarmStart, another_option_or_another_place_asks_for_a_refit) {
  Samples samples = some_points(4);
  const FittedCurves first = fit_curves(samples);
  FitOptions options;
  options.warm_start = &first;
  FitReport report;
  samples.point_position(2, 0) += 1e-6;
  fit_curves(samples, options, {}, &report);
  EXPECT_EQ(report.kept, 3U);
  options.loss = FitLoss::squared;
  fit_curves(samples, options, {}, &report);
  EXPECT_EQ(report.kept, 0U);
}

}  // namespace
}  // namespace palpate::test
