#include "libfit/refine/refine.hpp"

#include <gtest/gtest.h>

#include <numeric>
#include <random>

#include "libfit/refine/points_on_surface.hpp"
#include "tests/libfit/refine/blending.hpp"

namespace palpate::testing_refine {
namespace {

TEST(MatchTriangles, follow_points_given_in_another_order) {
  const Surface points = icosphere(2, 0.03);
  TestPoints test_points;
  test_points.position = points.vertices;
  test_points.triangles = points.triangles;
  std::vector<int> order(static_cast<std::size_t>(points.vertices.rows()));
  std::iota(order.begin(), order.end(), 0);
  std::shuffle(order.begin(), order.end(), std::mt19937(3));
  Points shuffled = points.vertices(order, Eigen::all);
  shuffled.array() += 1e-9;  // rounded on the way: less than 1e-6 of the body
  const Triangles matched = match_triangles(shuffled, test_points, 0.1);
  ASSERT_EQ(matched.rows(), points.triangles.rows());
  for (Eigen::Index t = 0; t < matched.rows(); ++t)
    for (int k = 0; k < 3; ++k)
      EXPECT_EQ(order[static_cast<std::size_t>(matched(t, k))], points.triangles(t, k));
}

TEST(MatchTriangles, other_points_have_none) {
  const Surface points = icosphere(1, 0.03);
  TestPoints test_points;
  test_points.position = points.vertices;
  test_points.triangles = points.triangles;
  Points moved = points.vertices;
  moved(5, 1) += 1e-5;
  EXPECT_EQ(match_triangles(moved, test_points, 0.1).rows(), 0);
  EXPECT_EQ(match_triangles(points.vertices.topRows(41), test_points, 0.1).rows(), 0);
  Points twice = points.vertices;
  twice.row(1) = twice.row(0);
  EXPECT_EQ(match_triangles(twice, test_points, 0.1).rows(), 0);
}

TEST(MatchTriangles, a_body_is_refined_on_its_own_triangulation) {
  Body body;
  body.surface = icosphere(4, 0.03);
  body.in_region = all(body.surface);
  const Surface points = icosphere(1, 0.03);
  body.test_points.position = points.vertices;
  body.test_points.triangles = points.triangles;
  RefineReport report;
  FittedCurves curves = curves_at(points, kSmooth);
  refine(curves, body, {}, &report);
  EXPECT_FALSE(report.is_own_triangulation);
  curves.position(0, 0) += 1e-4;
  refine(curves, body, {}, &report);
  EXPECT_TRUE(report.is_own_triangulation);
}

}  // namespace
}  // namespace palpate::testing_refine
