#include "libfit/refine/next_points.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <numbers>
#include <random>

#include "tests/libfit/refine/surfaces.hpp"

namespace palpate::testing_refine {
namespace {

TestPoints points_of(const Surface& surface) {
  TestPoints points{surface.vertices, -vertex_normals(surface), {}, surface.triangles};
  points.name.assign(static_cast<std::size_t>(surface.vertices.rows()), "p");
  return points;
}

Surface surface_of(const TestPoints& points) { return {points.position, points.triangles}; }

// Each directed edge once: manifold and consistently oriented. Returns the number of border edges.
int border_edges(const Triangles& triangles) {
  std::map<std::pair<int, int>, int> count;
  for (const auto& t : triangles.rowwise())
    for (int k = 0; k < 3; ++k) ++count[{t[k], t[(k + 1) % 3]}];
  int borders = 0;
  for (const auto& [edge, times] : count) {
    EXPECT_EQ(times, 1) << edge.first << " " << edge.second;
    borders += count.count({edge.second, edge.first}) == 0;
  }
  return borders;
}

double worst_angle_sum_deg(const TestPoints& points) {
  std::map<std::pair<int, int>, double> opposite;
  for (const auto& t : points.triangles.rowwise())
    for (int k = 0; k < 3; ++k) {
      const Vec3 at = points.position.row(t[(k + 2) % 3]);
      const Vec3 a = points.position.row(t[k]).transpose() - at;
      const Vec3 b = points.position.row(t[(k + 1) % 3]).transpose() - at;
      opposite[{t[k], t[(k + 1) % 3]}] = std::atan2(a.cross(b).norm(), a.dot(b));
    }
  double worst = 0;
  for (const auto& [edge, angle] : opposite) {
    const auto other = opposite.find({edge.second, edge.first});
    if (other != opposite.end()) worst = std::max(worst, angle + other->second);
  }
  return worst * 180 / std::numbers::pi;
}

TEST(InsertPoint, a_plate_stays_a_delaunay_triangulation_of_the_same_area) {
  TestPoints points = points_of(plate(3, 3, 0.1, 0.1));
  const double area = area_m2(surface_of(points));
  std::mt19937 random(5);
  std::uniform_real_distribution<double> within(0.02, 0.08);
  for (int i = 0; i < 200; ++i) {
    NewTestPoint added{Vec3(within(random), within(random), 0), Vec3(0, 0, -1), "q", 0};
    (points.position.rowwise() - added.position.transpose()).rowwise().norm().minCoeff(&added.near);
    ASSERT_TRUE(insert_point(points, added)) << "seed 5, point " << i;
  }
  EXPECT_EQ(points.position.rows(), 16 + 200);
  EXPECT_EQ(points.triangles.rows(), 18 + 2 * 200) << "each point inside adds two";
  EXPECT_EQ(border_edges(points.triangles), 12);
  EXPECT_NEAR(area_m2(surface_of(points)), area, 1e-12 * area);
  EXPECT_LE(worst_angle_sum_deg(points), 180 + 1e-6);
}

TEST(InsertPoint, a_sphere_stays_closed_and_faces_outward) {
  const Surface fine = icosphere(4, 0.03);
  TestPoints points = points_of(icosphere(1, 0.03));
  std::mt19937 random(7);
  std::uniform_int_distribution<Eigen::Index> any(0, fine.vertices.rows() - 1);
  for (int i = 0; i < 150; ++i) {
    NewTestPoint added{fine.vertices.row(any(random)), {}, "q", 0};
    added.normal = -added.position.normalized();
    (points.position.rowwise() - added.position.transpose()).rowwise().norm().minCoeff(&added.near);
    insert_point(points, added);
  }
  EXPECT_GT(points.position.rows(), 42 + 100);
  EXPECT_EQ(points.triangles.rows(), 2 * points.position.rows() - 4) << "Euler";
  EXPECT_EQ(border_edges(points.triangles), 0);
  EXPECT_GT(volume_m3(surface_of(points)), 0.9 * 4.0 / 3 * std::numbers::pi * std::pow(0.03, 3));
}

TEST(InsertPoint, the_outline_goes_through_a_point_on_the_border) {
  TestPoints points = points_of(plate(2, 2, 0.1, 0.1));
  ASSERT_TRUE(insert_point(points, {Vec3(0.025, 0, 0), Vec3(0, 0, -1), "q", 0}));
  EXPECT_EQ(border_edges(points.triangles), 9);
  EXPECT_EQ(points.triangles.rows(), 9);
}

TEST(InsertPoint, the_other_of_two_plates_one_millimetre_apart_is_left_alone) {
  const Surface lower = plate(3, 3, 0.1, 0.1), upper = plate(3, 3, 0.1, 0.1, 0.001);
  TestPoints points = points_of(together(lower, upper));
  // Nearer to the upper plate's triangles through the air, but it belongs to the lower one.
  ASSERT_TRUE(insert_point(points, {Vec3(0.048, 0.05, 0.0007), Vec3(0, 0, -1), "q", 5}));
  for (const auto& t : points.triangles.rowwise()) {
    int on_upper = 0;
    for (int k = 0; k < 3; ++k) on_upper += t[k] >= 16 && t[k] < 32;
    EXPECT_TRUE(on_upper == 0 || on_upper == 3);
  }
}

TEST(InsertPoint, a_point_that_is_there_or_faces_away_is_refused) {
  TestPoints points = points_of(plate(2, 2, 0.1, 0.1));
  const Triangles before = points.triangles;
  EXPECT_FALSE(insert_point(points, {Vec3(0.05, 0.05, 0), Vec3(0, 0, -1), "q", 4}));
  EXPECT_FALSE(insert_point(points, {Vec3(0.04, 0.03, 0), Vec3(0, 0, 1), "q", 4}));
  EXPECT_EQ(points.triangles, before);
  EXPECT_EQ(points.position.rows(), 9);
}

}  // namespace
}  // namespace palpate::testing_refine
