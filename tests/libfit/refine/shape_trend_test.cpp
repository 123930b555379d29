// Forces that follow the shape of the surface (M12d).

#include "libfit/refine/shape_trend.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <random>

#include "libfit/refine/next_points.hpp"
#include "tests/libfit/refine/blending.hpp"

namespace palpate::testing_refine {
namespace {

constexpr double kSide_m = 0.12, kHeight_m = 0.002, kWave_1_m = 130;

double height_m(const Vec3& p) {
  return kHeight_m * std::sin(kWave_1_m * p.x()) * std::sin(kWave_1_m * p.y());
}
Surface wavy(int cells) {
  return sheet(cells, cells, [](double u, double v) {
    Vec3 p(u * kSide_m, v * kSide_m, 0);
    p.z() = height_m(p);
    return p;
  });
}
/// Mean curvature where waves are flat: minus half of the Laplacian of the height.
double curvature_1_m(const Vec3& p) { return kWave_1_m * kWave_1_m * height_m(p); }

ShapeCovariates covariates(const Surface& surface, double radius_m) {
  return shape_covariates(surface, vertex_normals(surface), all(surface), {}, radius_m);
}

TEST(ShapeCovariates, of_a_ball_are_its_curvature_and_inward_normals) {
  const Surface ball = icosphere(4, 0.03);
  const ShapeCovariates shape = covariates(ball, 0.008);
  for (Eigen::Index v = 0; v < ball.vertices.rows(); ++v) {
    EXPECT_NEAR(shape.at_vertex(v, 0) * 0.03, 1, 0.03) << "vertex " << v;
    EXPECT_LT((shape.at_vertex.row(v).tail<3>() * 0.03 + ball.vertices.row(v)).norm(), 3e-4);
  }
}

TEST(ShapeCovariates, of_a_saddle_are_flat_and_on_a_coarse_mesh_no_worse_than_its_ring) {
  const Surface saddle = sheet(40, 40, [](double u, double v) {
    const double x = 0.06 * (u - 0.5), y = 0.06 * (v - 0.5);
    return Vec3(x, y, (x * x - y * y) / 0.2);
  });
  const Eigen::Index middle = 20 * 41 + 20;
  EXPECT_NEAR(covariates(saddle, 0.008).at_vertex(middle, 0), 0, 0.05);
  const Surface ball = icosphere(2, 0.03);  // edges of 9 mm
  EXPECT_NEAR(covariates(ball, 0.001).at_vertex.col(0).mean() * 0.03, 1, 0.1);
}

TEST(ShapeTrend, a_force_that_follows_curvature_is_interpolated_three_times_better) {
  const Surface fine = wavy(60), coarse = wavy(10);
  const Field force = [](const Vec3& p) { return 3 * std::exp(-0.01 * curvature_1_m(p)); };
  const FittedCurves curves = curves_at(coarse, force);
  RefineReport report;
  const FieldError with =
      field_error(refine(curves, fine, all(fine), coarse.triangles, {}, &report), force);
  EXPECT_TRUE(report.interpolation.follows_shape) << "chosen by leaving points out";
  EXPECT_LT(report.interpolation.shape_error, 0.5 * report.interpolation.plain_error);
  RefineOptions off;
  off.follows_shape = false;
  const FieldError without =
      field_error(refine(curves, fine, all(fine), coarse.triangles, off), force);
  EXPECT_LT(3 * with.rms, without.rms);
}

TEST(ShapeTrend, a_force_that_does_not_follow_shape_is_left_alone_to_the_bit) {
  const Surface fine = wavy(60), coarse = wavy(10);
  for (const unsigned seed : {1U, 2U, 3U}) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> phase(0, 6);
    const double a = phase(random), b = phase(random);
    const Field force = [=](const Vec3& p) {
      return 3 + std::sin(40 * p.x() + a) + std::cos(35 * p.y() + b);
    };
    const FittedCurves curves = curves_at(coarse, force);
    RefineReport report;
    const Model model = refine(curves, fine, all(fine), coarse.triangles, {}, &report);
    EXPECT_FALSE(report.interpolation.follows_shape) << "seed " << seed;
    RefineOptions off;
    off.follows_shape = false;
    EXPECT_EQ(model.curves.control[0],
              refine(curves, fine, all(fine), coarse.triangles, off).curves.control[0]);
  }
}

TEST(ShapeTrend, placement_expects_what_is_left_of_the_force_over_its_trend) {
  const Surface fine = wavy(60), coarse = wavy(10);
  const FittedCurves curves =
      curves_at(coarse, [](const Vec3& p) { return 3 * std::exp(-0.01 * curvature_1_m(p)); });
  const auto expected_sum = [&](bool follows_shape) {
    RefineOptions options;
    options.follows_shape = follows_shape;
    RefineReport refined;
    const Model model = refine(curves, fine, all(fine), coarse.triangles, options, &refined);
    EXPECT_EQ(refined.interpolation.follows_shape, follows_shape);
    const auto errors = expected_errors(curves, model, refined, 1e-9);
    return std::accumulate(errors.begin(), errors.end(), 0.0);
  };
  EXPECT_LT(2 * expected_sum(true), expected_sum(false));
}

// One press in a groove would bend the trend of a whole body.
TEST(ShapeTrend, a_poor_point_speaks_for_its_own_place_alone) {
  const Surface fine = wavy(60), coarse = wavy(10);
  const Field force = [](const Vec3& p) { return 3 * std::exp(-0.01 * curvature_1_m(p)); };
  constexpr Eigen::Index kPoor = 5 * 11 + 5, kItsVertex = 6 * 5 * 61 + 6 * 5;
  const auto refined = [&](float factor, FitStatus status) {
    FittedCurves curves = curves_at(coarse, force);
    curves.curves.control[0](kPoor, 1) *= factor;
    curves.status[kPoor] = status;
    RefineReport report;
    const Model model = refine(curves, fine, all(fine), coarse.triangles, {}, &report);
    return std::pair(model.curves.control[0](kItsVertex, 1), report);
  };
  const auto [trusted_N, misled] = refined(16, FitStatus::good);
  const auto [kept_N, report] = refined(16, FitStatus::poor);
  const auto [sound_N, without] = refined(1, FitStatus::poor);
  EXPECT_TRUE(report.interpolation.follows_shape);
  EXPECT_EQ(report.interpolation.points, misled.interpolation.points - 1);
  EXPECT_NE(misled.trend.at_vertex, without.trend.at_vertex) << "else this test says nothing";
  EXPECT_EQ(report.interpolation.shape_error, without.interpolation.shape_error);
  EXPECT_EQ(report.trend.at_vertex, without.trend.at_vertex) << "whatever its curve is";
  EXPECT_EQ(kept_N, trusted_N) << "it stays in the model";
  EXPECT_EQ(kept_N, 16 * sound_N);
}

TEST(ShapeTrend, keeps_curves_at_test_points_and_curves_that_rise) {
  const Surface fine = wavy(60), coarse = wavy(10);
  const FittedCurves curves =
      curves_at(coarse, [](const Vec3& p) { return 3 * std::exp(-0.01 * curvature_1_m(p)); });
  RefineOptions on;
  on.follows_shape = true;
  const Model model = refine(curves, fine, all(fine), coarse.triangles, on);
  for (int i = 0; i <= 10; ++i)
    for (int j = 0; j <= 10; ++j) {
      const Eigen::RowVectorXd own = curves.curves.control[0].row(i * 11 + j),
                               found = model.curves.control[0].row(6 * i * 61 + 6 * j);
      EXPECT_LT((own - found).norm(), 1e-6 * own.norm()) << "point " << i << ", " << j;
    }
  for (const auto& row : model.curves.control[0].rowwise())
    for (Eigen::Index k = 1; k < row.size(); ++k) EXPECT_GE(row[k], row[k - 1]);
}

TEST(ShapeTrend, is_never_extrapolated_past_the_shapes_that_were_felt) {
  ShapeCovariates shape;
  shape.at_point.setZero(4, 4);
  shape.at_point.col(0) << 0, 10, 20, 30;
  shape.at_vertex.setZero(2, 4);
  shape.at_vertex(0, 0) = 30;
  shape.at_vertex(1, 0) = 3000;
  const ShapeTrend trend = trend_over(
      shape,
      regress_on_shape(shape, Eigen::Vector4d(0, 0.1, 0.2, 0.3), std::vector<char>(4, 1),
                       {{1, {0, 0, 2}, {0.25, 0.25, 0.5}}, {2, {1, 1, 0}, {0.5, 0.25, 0.25}}}));
  EXPECT_GT(trend.at_vertex[0], 0.05);
  EXPECT_EQ(trend.at_vertex[1], trend.at_vertex[0]);
}

}  // namespace
}  // namespace palpate::testing_refine
