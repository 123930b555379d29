#include "libfit/refine/refine.hpp"

#include <gtest/gtest.h>

#include <random>

#include "tests/libfit/refine/blending.hpp"

namespace palpate::testing_refine {
namespace {

// Observed order between successive halvings of the spacing, from root mean square errors.
std::vector<double> orders(const std::vector<FieldError>& errors, double FieldError::*measure) {
  std::vector<double> orders;
  for (std::size_t i = 1; i < errors.size(); ++i)
    orders.push_back(std::log2(errors[i - 1].*measure / errors[i].*measure));
  return orders;
}

TEST(Refine, converges_with_second_order_on_a_sphere) {
  const Surface fine = icosphere(6, 0.03);
  std::vector<FieldError> errors;
  for (int level = 2; level <= 4; ++level) {
    const Surface points = icosphere(level, 0.03);
    const Model model = refine(curves_at(points, kSmooth), fine, all(fine), points.triangles);
    errors.push_back(field_error(model, kSmooth));
    EXPECT_EQ(errors.back().covered, fine.vertices.rows());
  }
  for (const double order : orders(errors, &FieldError::rms)) EXPECT_GE(order, 1.9);
  for (const double order : orders(errors, &FieldError::most)) EXPECT_GE(order, 1.8);
  RecordProperty("rms_orders", testing::PrintToString(orders(errors, &FieldError::rms)));
  RecordProperty("max_orders", testing::PrintToString(orders(errors, &FieldError::most)));
}

// z = (x^2 - y^2) / (2 R) over a square of 60 mm, R = 40 mm.
Surface saddle(int cells) {
  return sheet(cells, cells, [](double u, double v) {
    const double x = 0.06 * (u - 0.5), y = 0.06 * (v - 0.5);
    return Vec3(x, y, (x * x - y * y) / 0.08);
  });
}

TEST(Refine, converges_with_second_order_on_a_saddle) {
  const Surface fine = saddle(144);
  std::vector<FieldError> errors;
  for (const int cells : {6, 12, 24}) {
    const Surface points = saddle(cells);
    const Model model = refine(curves_at(points, kSmooth), fine, all(fine), points.triangles);
    errors.push_back(field_error(model, kSmooth));
    EXPECT_EQ(errors.back().covered, fine.vertices.rows());
    expect_partition_of_unity(model);
  }
  for (const double order : orders(errors, &FieldError::rms)) EXPECT_GE(order, 1.9);
  RecordProperty("rms_orders", testing::PrintToString(orders(errors, &FieldError::rms)));
}

// Points of a rig, at no vertex: evenly spread by the golden angle, each moved at random by up to
// a quarter of the spacing.
Surface scattered_on_sphere(int points, double radius_m, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> shift(-1, 1);
  const double spacing = std::sqrt(4 * M_PI / points);
  Surface s;
  s.vertices.resize(points, 3);
  for (int i = 0; i < points; ++i) {
    const double z = 1 - (2 * i + 1.0) / points, angle = i * M_PI * (3 - std::sqrt(5.0));
    Vec3 p(std::sqrt(1 - z * z) * std::cos(angle), std::sqrt(1 - z * z) * std::sin(angle), z);
    p += 0.25 * spacing / std::sqrt(3.0) * Vec3(shift(random), shift(random), shift(random));
    s.vertices.row(i) = radius_m * p.normalized().transpose();
  }
  return s;
}

TEST(Refine, converges_with_second_order_on_scattered_points) {
  const Surface fine = icosphere(6, 0.03);
  std::vector<FieldError> errors;
  for (const int count : {160, 640, 2560}) {
    const Surface points = scattered_on_sphere(count, 0.03, 7);
    FittedCurves curves = curves_at(points, kSmooth);
    curves.normal = -points.vertices / 0.03;
    RefineReport report;
    const Model model = refine(curves, fine, all(fine), kNone, {}, &report);
    EXPECT_EQ(report.triangles.rows(), 2 * count - 4) << "a closed triangulation, seed 7";
    errors.push_back(field_error(model, kSmooth));
    EXPECT_EQ(errors.back().covered, fine.vertices.rows());
  }
  for (const double order : orders(errors, &FieldError::rms)) EXPECT_GE(order, 1.9) << "seed 7";
  RecordProperty("rms_orders", testing::PrintToString(orders(errors, &FieldError::rms)));
}

// A rig's points as they come: between ten and ten thousand, none of them a vertex.
TEST(Refine, ten_to_ten_thousand_scattered_points_close_around_a_sphere) {
  const Surface fine = icosphere(7, 0.03);
  for (const int count : {10, 100, 1000, 10000}) {
    SCOPED_TRACE(count);
    const Surface points = scattered_on_sphere(count, 0.03, 11);
    FittedCurves curves = curves_at(points, kSmooth);
    curves.normal = -points.vertices / 0.03;
    RefineReport report;
    const Model model = refine(curves, fine, all(fine), kNone, {}, &report);
    EXPECT_EQ(report.triangles.rows(), 2 * count - 4) << "Euler, seed 11";
    EXPECT_TRUE(report.uncovered.empty());
    EXPECT_NEAR(model.blend_weight.rowwise().sum().minCoeff(), 1, 1e-14);
    EXPECT_NEAR(model.blend_weight.rowwise().sum().maxCoeff(), 1, 1e-14);
    EXPECT_GE(model.blend_weight.minCoeff(), 0);
  }
}

}  // namespace
}  // namespace palpate::testing_refine
