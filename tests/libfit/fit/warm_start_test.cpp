#include <gtest/gtest.h>

#include <algorithm>
#include <optional>

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
  EXPECT_EQ(again.curves.control.back(), first.curves.control.back());
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

// Refits as from a file: rows of the points wanted are handed out, and counted.
std::optional<FittedCurves> refit(const Samples& samples, const FittedCurves& earlier,
                                  FitReport& report, std::size_t& points_read,
                                  FitOptions options = {}) {
  Samples points = samples;
  points.point.clear(), points.experiment.clear(), points.kind.clear(), points.step.clear();
  points.status.clear();
  points.deflection.resize(0, 3), points.force.resize(0, 3), points.torque.resize(0, 3);
  points.force_error.resize(0);
  points_read = 0;
  const auto read_rows = [&](const std::vector<char>& is_wanted) {
    Samples part = points;
    std::vector<Eigen::Index> rows;
    for (Eigen::Index i = 0; i < samples.rows(); ++i) {
      const auto at = static_cast<std::size_t>(i);
      if (!is_wanted[static_cast<std::size_t>(samples.point[at])]) continue;
      rows.push_back(i);
      part.point.push_back(samples.point[at]), part.experiment.push_back(samples.experiment[at]);
      part.kind.push_back(samples.kind[at]), part.step.push_back(samples.step[at]);
      part.status.push_back(samples.status[at]);
    }
    part.deflection = samples.deflection(rows, Eigen::all);
    part.force = samples.force(rows, Eigen::all), part.torque = samples.torque(rows, Eigen::all);
    part.force_error = samples.force_error(rows);
    points_read += static_cast<std::size_t>(std::count(is_wanted.begin(), is_wanted.end(), 1));
    return part;
  };
  options.warm_start = &earlier;
  return refit_curves(points, index_rows(samples), static_cast<std::size_t>(samples.rows()),
                      read_rows, options, {}, &report);
}

void expect_the_same(const FittedCurves& a, const FittedCurves& b) {
  for (std::size_t kind = 0; kind < kCurveKinds; ++kind) {
    EXPECT_EQ(a.curves.control[kind], b.curves.control[kind]) << kCurveNames[kind];
    const auto &u = a.covariance[kind], &v = b.covariance[kind];
    EXPECT_TRUE((u.array() == v.array() || (u.array().isNaN() && v.array().isNaN())).all())
        << kCurveNames[kind];
  }
  EXPECT_EQ(a.rms_residual_N, b.rms_residual_N);
  EXPECT_EQ(a.max_residual_N, b.max_residual_N);
  EXPECT_EQ(a.depth_range_m, b.depth_range_m);
  EXPECT_EQ(a.rows_hash, b.rows_hash);
  EXPECT_EQ(a.scores.rows, b.scores.rows);
  EXPECT_EQ(a.scores.worst_row, b.scores.worst_row);
  EXPECT_EQ(a.scores.worst_experiment, b.scores.worst_experiment);
  EXPECT_EQ(a.scores.relative_error, b.scores.relative_error);
}

void expect_the_same(const FitReport& a, const FitReport& b) {
  EXPECT_NEAR(a.median_relative_error, b.median_relative_error, 1e-6);
  EXPECT_NEAR(a.p95_relative_error, b.p95_relative_error, 1e-6);
  EXPECT_NEAR(a.max_relative_error, b.max_relative_error, 1e-6);
  EXPECT_EQ(a.rows, b.rows);
  EXPECT_EQ(a.rows_used, b.rows_used);
  EXPECT_EQ(a.widest_band, b.widest_band);
  ASSERT_EQ(a.worst.size(), b.worst.size());
  for (std::size_t i = 0; i < a.worst.size(); ++i) {
    EXPECT_EQ(a.worst[i].name, b.worst[i].name);
    EXPECT_EQ(a.worst[i].relative_residual, b.worst[i].relative_residual);
    EXPECT_EQ(a.worst[i].reason, b.worst[i].reason);
  }
}

TEST(WarmStart, reads_the_rows_of_the_changed_point_alone_and_reports_on_all) {
  Samples samples = some_points(8);
  const FittedCurves first = fit_curves(samples);
  scale_rows_of(samples, 3, 1.2);
  FitReport report, whole_report;
  std::size_t points_read = 0;
  const auto warm = refit(samples, first, report, points_read);
  ASSERT_TRUE(warm);
  EXPECT_EQ(points_read, 1U);
  EXPECT_EQ(report.kept, 7U);
  expect_the_same(*warm, fit_curves(samples, {}, {}, &whole_report));
  expect_the_same(report, whole_report);
}

TEST(WarmStart, points_added_and_removed_leave_the_others_unread) {
  const Samples eight = some_points(8), nine = some_points(9);
  FitReport report, whole_report;
  std::size_t points_read = 9;
  const auto fewer = refit(eight, fit_curves(nine), report, points_read);
  ASSERT_TRUE(fewer);
  EXPECT_EQ(points_read, 0U);
  const FittedCurves eight_whole = fit_curves(eight, {}, {}, &whole_report);
  expect_the_same(*fewer, eight_whole);
  expect_the_same(report, whole_report);
  const auto more = refit(nine, eight_whole, report, points_read);
  ASSERT_TRUE(more);
  EXPECT_EQ(points_read, 1U);
  expect_the_same(*more, fit_curves(nine, {}, {}, &whole_report));
  expect_the_same(report, whole_report);
}

TEST(WarmStart, reads_all_where_weights_depend_on_other_points_or_scores_are_not_known) {
  Samples samples = some_points(4);
  FitReport report;
  std::size_t points_read = 0;
  FittedCurves first = fit_curves(samples);
  scale_rows_of(samples, 1, 1.2);
  for (Eigen::Index i = 0; i < samples.rows(); ++i)
    if (samples.point[static_cast<std::size_t>(i)] == 1) samples.force_error[i] = 1e-3;
  EXPECT_FALSE(refit(samples, first, report, points_read));
  first.scores = {};  // of a file of before
  EXPECT_FALSE(refit(samples, first, report, points_read));
  FitOptions options;
  options.warm_start = &first;
  fit_curves(samples, options, {}, &report);
  EXPECT_EQ(report.kept, 0U);
}

// The strength of smoothing is kept like the bases, and of points that their neighbours moved the
// rows are read for their scores alone.
TEST(warm_start, of_smoothed_curves_reads_rows_of_what_moved) {
  Recorder rig;
  for (int i = 0; i < 8; ++i)
    for (int j = 0; j < 8; ++j) {
      const int p = rig.add_point(-Vec3::UnitZ());
      rig.samples.point_position.row(p) << 0.01 * i, 0.01 * j, 0;
      const double k = 300 * (1 + 0.3 * std::sin(0.45 * i) * std::cos(0.35 * j));
      rig.press(
          p, [k](double d) { return k * d; }, 0.01, 20);
    }
  add_noise(rig.samples, 0.25, 17);
  FitOptions options;
  options.family = CurveFamily::separable;
  options.pieces = {1, 1, 1};
  options.smoothing = std::nullopt;
  const FittedCurves first = fit_curves(rig.samples, options);
  ASSERT_GT(first.smoothing[0], 0) << "seed 17: " << first.smoothing_reason[0];
  for (Eigen::Index i = 0; i < rig.samples.rows(); ++i)
    if (rig.samples.point[static_cast<std::size_t>(i)] == 17) rig.samples.force.row(i) *= 1.1;
  const FittedCurves whole = fit_curves(rig.samples, options);
  FitReport report;
  std::size_t points_read = 0;
  const auto warm = refit(rig.samples, first, report, points_read, options);
  ASSERT_TRUE(warm);
  EXPECT_EQ(report.kept, 63U);
  EXPECT_GT(points_read, 1U) << "neighbours move";
  ASSERT_EQ(warm->smoothing, whole.smoothing) << "seed 17";
  expect_the_same(*warm, whole);
}

}  // namespace
}  // namespace palpate::test
