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

// A fit and what it leaves for the next.
struct Fitted {
  FitCache cache;
  FittedCurves curves;

  explicit Fitted(const Samples& samples, const FitOptions& wanted = kSeparable)
      : curves(fit_curves(samples, wanted, {}, nullptr, &cache)) {}
  FitOptions options(FitOptions wanted = kSeparable) const {
    wanted.warm_start = &curves, wanted.warm_cache = &cache;
    return wanted;
  }
};

TEST(WarmStart, without_a_change_every_point_is_kept_as_it_is) {
  const Samples samples = some_points(6);
  const Fitted first(samples);
  FitOptions options = first.options();
  FitReport report;
  const FittedCurves again = fit_curves(samples, options, {}, &report);
  EXPECT_EQ(report.points.kept, 6U);
  for (std::size_t kind = 0; kind < kCurveKinds; ++kind)
    EXPECT_EQ(again.curves.control[kind], first.curves.curves.control[kind]);
  EXPECT_EQ(again.curves.control.back(), first.curves.curves.control.back());
  EXPECT_EQ(again.rms_residual_N, first.curves.rms_residual_N);
}

TEST(WarmStart, another_option_or_another_place_asks_for_a_refit) {
  Samples samples = some_points(4);
  const Fitted first(samples);
  FitOptions options = first.options();
  FitReport report;
  samples.point_position(2, 0) += 1e-6;
  fit_curves(samples, options, {}, &report);
  EXPECT_EQ(report.points.kept, 3U);
  options.default_friction *= 1.1;
  fit_curves(samples, options, {}, &report);
  EXPECT_EQ(report.points.kept, 0U);
}

// A point that was pressed alone has the rings that theory gives the ball.
TEST(WarmStart, another_probe_asks_for_a_refit) {
  Recorder rig;
  for (int p = 0; p < 4; ++p)
    rig.press(
        rig.add_point(Vec3(0.1 * p, 0.2, -1)), [](double d) { return 300 * d * (1 + 40 * d); },
        0.01, 12);
  Samples samples = rig.samples;
  samples.probe = sphere_spec(0.004, 0.3);
  FitOptions rings;
  rings.family = CurveFamily::rings;
  const Fitted first(samples, rings);
  for (const ProbeSpec& other : {sphere_spec(0.008, 0.3), sphere_spec(0.004, 0.5)}) {
    samples.probe = other;
    FitReport report;
    const FittedCurves warm = fit_curves(samples, first.options(rings), {}, &report);
    EXPECT_EQ(report.points.kept, 0U);
    EXPECT_EQ(warm.curves.control.back(), fit_curves(samples, rings).curves.control.back());
  }
}

// tolerance: of covariances, over the largest; controls are exact in float32 and have equal bits.
void expect_the_same(const FittedCurves& a, const FittedCurves& b, double tolerance = 0) {
  for (std::size_t kind = 0; kind < kCurveKinds; ++kind) {
    EXPECT_EQ(a.curves.control[kind], b.curves.control[kind]) << kCurveNames[kind];
    const auto &u = a.covariance[kind], &v = b.covariance[kind];
    const double apart = tolerance * u.array().isNaN().select(0, u.array().abs()).maxCoeff();
    EXPECT_TRUE(((u - v).array().abs() <= apart || (u.array().isNaN() && v.array().isNaN())).all())
        << kCurveNames[kind];
  }
  EXPECT_EQ(a.rms_residual_N, b.rms_residual_N);
  EXPECT_EQ(a.max_residual_N, b.max_residual_N);
  EXPECT_EQ(a.depth_range_m, b.depth_range_m);
}

void expect_the_same(const FitReport& a, const FitReport& b) {
  EXPECT_NEAR(a.error.median, b.error.median, 1e-6);
  EXPECT_NEAR(a.error.p95, b.error.p95, 1e-6);
  EXPECT_NEAR(a.error.max, b.error.max, 1e-6);
  EXPECT_EQ(a.rows.all, b.rows.all);
  EXPECT_EQ(a.rows.used, b.rows.used);
  EXPECT_EQ(a.bands.widest, b.bands.widest);
  ASSERT_EQ(a.worst.size(), b.worst.size());
  for (std::size_t i = 0; i < a.worst.size(); ++i) {
    EXPECT_EQ(a.worst[i].name, b.worst[i].name);
    EXPECT_EQ(a.worst[i].relative_residual, b.worst[i].relative_residual);
    EXPECT_EQ(a.worst[i].reason, b.worst[i].reason);
  }
}

TEST(WarmStart, of_a_changed_point_reports_as_a_whole_fit) {
  Samples samples = some_points(8);
  const Fitted first(samples);
  scale_rows_of(samples, 3, 1.2);
  FitReport report, whole_report;
  const FittedCurves warm = fit_curves(samples, first.options(), {}, &report);
  EXPECT_EQ(report.points.kept, 7U);
  expect_the_same(warm, fit_curves(samples, kSeparable, {}, &whole_report));
  expect_the_same(report, whole_report);
}

TEST(WarmStart, keeps_points_where_others_were_added_or_removed) {
  const Samples eight = some_points(8), nine = some_points(9);
  const Fitted of_eight(eight), of_nine(nine);
  FitReport report, whole_report;
  const FittedCurves fewer = fit_curves(eight, of_nine.options(), {}, &report);
  EXPECT_EQ(report.points.kept, 8U);
  expect_the_same(fewer, fit_curves(eight, kSeparable, {}, &whole_report));
  expect_the_same(report, whole_report);
  const FittedCurves more = fit_curves(nine, of_eight.options(), {}, &report);
  EXPECT_EQ(report.points.kept, 8U);
  expect_the_same(more, fit_curves(nine, kSeparable, {}, &whole_report));
  expect_the_same(report, whole_report);
}

TEST(WarmStart, without_its_cache_takes_longer_and_brings_the_same) {
  Samples samples = some_points(5);
  add_noise(samples, 0.02, 5);  // the bands of exact rows are rounding
  const Fitted first(samples);
  scale_rows_of(samples, 2, 1.1);
  FitReport report;
  const FittedCurves with = fit_curves(samples, first.options(), {}, &report);
  EXPECT_EQ(report.points.kept, 4U);
  FitOptions options = first.options();
  options.warm_cache = nullptr;
  const FittedCurves without = fit_curves(samples, options, {}, &report);
  EXPECT_EQ(report.points.kept, 0U);
  constexpr double kRounding = 1e-6;  // knots came by way of metres
  expect_the_same(with, without, kRounding);
  const FitCache of_others{{"0123456789abcdef"}};
  options.warm_cache = &of_others;
  expect_the_same(with, fit_curves(samples, options, {}, &report), kRounding);
  EXPECT_EQ(report.points.kept, 0U);
}

TEST(WarmStart, asks_for_a_refit_where_a_row_that_a_fit_reads_changed) {
  Samples samples = some_points(5);
  const Fitted first(samples);
  for (auto& id : samples.experiment) id += 100;  // one recording more before them
  samples.torque.setOnes();                       // which no fit reads
  FitReport report;
  fit_curves(samples, first.options(), {}, &report);
  EXPECT_EQ(report.points.kept, 5U);
  samples.force(0, 0) += 1e-9;
  fit_curves(samples, first.options(), {}, &report);
  EXPECT_EQ(report.points.kept, 4U);
}

}  // namespace
}  // namespace palpate::test
