#include "libfit/refine/refine.hpp"

#include <gtest/gtest.h>

#include <random>

#include "tests/libfit/refine/blending.hpp"

namespace palpate::testing_refine {
namespace {

// Of root mean square errors between successive halvings of the spacing. Returns the largest ones.
std::vector<double> expect_second_order(const Surface& fine,
                                        const std::vector<FittedCurves>& points,
                                        const std::vector<Triangles>& triangles) {
  std::vector<double> errors, largest, orders;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Model model = refine(points[i], fine, all(fine), triangles[i]);
    const FieldError error = field_error(model, kSmooth);
    EXPECT_EQ(error.covered, fine.vertices.rows());
    expect_partition_of_unity(model);
    errors.push_back(error.rms);
    largest.push_back(error.most);
    if (i > 0) orders.push_back(std::log2(errors[i - 1] / errors[i]));
  }
  testing::Test::RecordProperty("rms_orders", testing::PrintToString(orders));
  for (const double order : orders) EXPECT_GE(order, 1.9);
  return largest;
}

std::vector<double> expect_second_order(const Surface& fine, const std::vector<Surface>& points) {
  std::vector<FittedCurves> curves;
  std::vector<Triangles> triangles;
  for (const Surface& each : points) {
    curves.push_back(curves_at(each, kSmooth));
    triangles.push_back(each.triangles);
  }
  return expect_second_order(fine, curves, triangles);
}

TEST(Refine, converges_with_second_order_on_a_sphere) {
  const std::vector<double> largest = expect_second_order(
      icosphere(6, 0.03), {icosphere(2, 0.03), icosphere(3, 0.03), icosphere(4, 0.03)});
  for (std::size_t i = 1; i < 3; ++i) EXPECT_GE(std::log2(largest[i - 1] / largest[i]), 1.8);
}

TEST(Refine, converges_with_second_order_on_a_saddle) {
  expect_second_order(saddle(144), {saddle(6), saddle(12), saddle(24)});
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

FittedCurves scattered_curves(int count, unsigned seed) {
  const Surface points = scattered_on_sphere(count, 0.03, seed);
  FittedCurves curves = curves_at(points, kSmooth);
  curves.normal = -points.vertices / 0.03;
  return curves;
}

TEST(Refine, converges_with_second_order_on_scattered_points) {
  expect_second_order(
      icosphere(6, 0.03),
      {scattered_curves(160, 7), scattered_curves(640, 7), scattered_curves(2560, 7)},
      {kNone, kNone, kNone});
}

// A rig's points as they come: between ten and ten thousand, none of them a vertex.
TEST(Refine, ten_to_ten_thousand_scattered_points_close_around_a_sphere) {
  const Surface fine = icosphere(7, 0.03);
  for (const int count : {10, 100, 1000, 10000}) {
    SCOPED_TRACE(count);
    RefineReport report;
    const Model model = refine(scattered_curves(count, 11), fine, all(fine), kNone, {}, &report);
    EXPECT_EQ(report.triangles.rows(), 2 * count - 4) << "Euler, seed 11";
    EXPECT_TRUE(report.uncovered.empty());
    EXPECT_NEAR(model.blend_weight.rowwise().sum().minCoeff(), 1, 1e-14);
    EXPECT_NEAR(model.blend_weight.rowwise().sum().maxCoeff(), 1, 1e-14);
    EXPECT_GE(model.blend_weight.minCoeff(), 0);
  }
}

}  // namespace
}  // namespace palpate::testing_refine
