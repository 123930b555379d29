#include "libfem/mesh/surface/surface.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <set>

#include "libfem/mesh/repair/facts.hpp"
#include "libfem/mesh/repair/repair_steps.hpp"
#include "tests/libfem/mesh/surface/surfaces.hpp"
#include "tests/support/error_of.hpp"

namespace palpate {
namespace {

using testing::together, testing::moved, testing::sphere;

std::vector<char> all_of(const Surface& surface) {
  return std::vector<char>(static_cast<std::size_t>(surface.vertices.rows()), 1);
}

std::vector<char> upper_half_of(const Surface& surface) {
  std::vector<char> is_up;
  for (const auto& p : surface.vertices.rowwise()) is_up.push_back(p.z() > -1e-9);
  return is_up;
}

double smallest_angle_deg(const TestPoints& points) {
  double smallest = 180;
  for (const auto& t : points.triangles.rowwise())
    for (int k = 0; k < 3; ++k) {
      const Vec3 at = points.position.row(t[k]);
      const Vec3 a = (points.position.row(t[(k + 1) % 3]).transpose() - at).normalized();
      const Vec3 b = (points.position.row(t[(k + 2) % 3]).transpose() - at).normalized();
      smallest = std::min(smallest, std::acos(a.dot(b)) * 180 / std::numbers::pi);
    }
  return smallest;
}

TEST(TestPointsOnASphere, have_the_asked_number_and_close_around_it) {
  const Surface fine = sphere(0.05, 4);
  for (const int count : {4, 5, 12, 60, 250}) {
    SCOPED_TRACE(count);
    const TestPoints points = choose_test_points(fine, all_of(fine), all_of(fine), count);
    ASSERT_EQ(points.position.rows(), count);
    EXPECT_EQ(points.triangles.rows(), 2 * count - 4);  // Euler, genus 0
    EXPECT_EQ(why_not_closed({points.position, points.triangles}), std::nullopt);
    EXPECT_EQ(points.name.front(), "p0001");
    EXPECT_EQ(points.name.size(), static_cast<std::size_t>(count));
    // Inward normals: angle-weighted normals of this sphere's facets are radial to 1e-3.
    for (Eigen::Index i = 0; i < count; ++i)
      EXPECT_LT(points.normal.row(i).dot(points.position.row(i).normalized()), -0.999);
  }
}

TEST(TestPointsOnASphere, may_be_ten_to_ten_thousand) {
  const Surface fine = sphere(0.05, 6);
  for (const int count : {10, 100, 1000, 10000}) {
    SCOPED_TRACE(count);
    const TestPoints points = choose_test_points(fine, all_of(fine), all_of(fine), count);
    ASSERT_EQ(points.position.rows(), count);
    EXPECT_EQ(points.triangles.rows(), 2 * count - 4);
    EXPECT_GT(smallest_angle_deg(points), 10);
  }
}

TEST(TestPointsOnASphere, are_evenly_spread) {
  const Surface fine = sphere(0.05, 5);
  const TestPoints points = choose_test_points(fine, all_of(fine), all_of(fine), 100);
  EXPECT_GT(smallest_angle_deg(points), 25);
  // Every fine vertex has a point within the covering radius of a hexagonal packing, with slack
  // for what no triangulation of 100 points on a sphere avoids.
  const double spacing = std::sqrt(area_m2(fine) / 100 * 2 / std::sqrt(3.0));
  double farthest = 0, nearest_pair = 1;
  for (const auto& v : fine.vertices.rowwise())
    farthest = std::max(farthest, (points.position.rowwise() - v).rowwise().norm().minCoeff());
  for (Eigen::Index i = 0; i < 100; ++i)
    for (Eigen::Index k = 0; k < i; ++k)
      nearest_pair =
          std::min(nearest_pair, (points.position.row(i) - points.position.row(k)).norm());
  EXPECT_LT(farthest, 1.6 * spacing / std::sqrt(3.0));
  EXPECT_GT(nearest_pair, 0.6 * spacing);
}

TEST(TestPoints, are_vertices_of_the_fine_surface_and_none_twice) {
  const Surface fine = sphere(0.05, 3);
  const TestPoints points = choose_test_points(fine, all_of(fine), all_of(fine), 40);
  std::set<Eigen::Index> used;
  for (const auto& p : points.position.rowwise()) {
    Eigen::Index nearest = 0;
    EXPECT_EQ((fine.vertices.rowwise() - p).rowwise().squaredNorm().minCoeff(&nearest), 0);
    used.insert(nearest);
  }
  EXPECT_EQ(used.size(), 40U);
}

TEST(TestPoints, cover_a_part_with_a_border_up_to_the_border) {
  const Surface fine = sphere(0.05, 4);
  const TestPoints points = choose_test_points(fine, upper_half_of(fine), upper_half_of(fine), 50);
  ASSERT_EQ(points.position.rows(), 50);
  EXPECT_GE(points.position.col(2).minCoeff(), -1e-9);
  const double area = area_m2({points.position, points.triangles});
  EXPECT_NEAR(area, 2 * std::numbers::pi * 0.05 * 0.05, 0.08 * area);
  int on_the_rim = 0;
  for (const auto& p : points.position.rowwise()) on_the_rim += p.z() < 1e-9;
  EXPECT_GE(on_the_rim, 8);
}

TEST(TestPoints, are_spread_over_every_piece) {
  const Surface one = sphere(0.05, 3);
  const Surface two = together(one, moved(one, Vec3(0.2, 0, 0)));
  const TestPoints points = choose_test_points(two, all_of(two), all_of(two), 40);
  ASSERT_EQ(points.position.rows(), 40);
  const auto left = (points.position.col(0).array() < 0.1).count();
  EXPECT_NEAR(static_cast<double>(left), 20, 4);
}

TEST(TestPoints, come_as_near_to_the_number_as_topology_lets_them) {
  const Surface one = sphere(0.05, 2);
  const Surface two = together(one, moved(one, Vec3(0.2, 0, 0)));
  EXPECT_EQ(choose_test_points(two, all_of(two), all_of(two), 5).position.rows(),
            8);  // two tetrahedra
}

TEST(TestPoints, more_than_there_are_vertices_means_every_vertex) {
  const Surface fine = sphere(0.05, 1);  // 18 vertices
  const TestPoints points = choose_test_points(fine, all_of(fine), all_of(fine), 5000);
  EXPECT_EQ(points.position, fine.vertices);
  EXPECT_EQ(points.triangles, fine.triangles);
}

TEST(TestPoints, a_region_pinched_at_a_vertex_is_triangulated_without_the_pinch) {
  const Surface fine = sphere(0.05, 3);
  std::vector<char> is_reachable(static_cast<std::size_t>(fine.vertices.rows()), 0);
  // Two caps that meet in vertex 4 (the north pole) only: opposite quadrants without their rims.
  for (Eigen::Index v = 0; v < fine.vertices.rows(); ++v)
    is_reachable[std::size_t(v)] = v == 4 || fine.vertices(v, 0) * fine.vertices(v, 1) > 1e-9;
  const TestPoints points = choose_test_points(fine, is_reachable, is_reachable, 20);
  EXPECT_EQ(points.position.rows(), 20);
}

TEST(TestPoints, the_same_input_gives_the_same_bits) {
  const Surface fine = sphere(0.05, 4);
  const TestPoints a = choose_test_points(fine, all_of(fine), all_of(fine), 77);
  const TestPoints b = choose_test_points(fine, all_of(fine), all_of(fine), 77);
  EXPECT_EQ(a.position, b.position);
  EXPECT_EQ(a.triangles, b.triangles);
}

TEST(TestPoints, nothing_to_reach_and_silly_numbers_are_refused) {
  const Surface fine = sphere(0.05, 2);
  EXPECT_THROW(choose_test_points(fine, all_of(fine), all_of(fine), 3), Error);
  EXPECT_THROW(choose_test_points(fine, all_of(fine), all_of(fine), 10001), Error);
  const std::vector<char> none(all_of(fine).size(), 0);
  EXPECT_EQ(testing_support::fact_of([&] { choose_test_points(fine, none, none, 10); }),
            "no triangle of the surface can be touched");
}

}  // namespace
}  // namespace palpate
