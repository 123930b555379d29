#include "libfit/fit/neighbours/point_graph.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <set>

namespace palpate::test {
namespace {

using fit::point_graph;
using fit::PointEdge;

struct Scattered {
  Points position, normal;
  std::vector<char> takes_part;

  void add(const Vec3& at, const Vec3& inward) {
    const Eigen::Index p = position.rows();
    position.conservativeResize(p + 1, 3);
    normal.conservativeResize(p + 1, 3);
    position.row(p) = at;
    normal.row(p) = inward.normalized();
    takes_part.push_back(1);
  }
  std::vector<PointEdge> graph(const Triangles& triangles = {}) const {
    return point_graph(position, normal, takes_part, triangles);
  }
};

Scattered grid(int side, double height, const Vec3& inward) {
  Scattered points;
  for (int i = 0; i < side; ++i)
    for (int j = 0; j < side; ++j) points.add({0.01 * i, 0.01 * j, height}, inward);
  return points;
}

// Even points on a sphere (Fibonacci spiral).
Scattered sphere(int count, double radius) {
  Scattered points;
  for (int i = 0; i < count; ++i) {
    const double z = 1 - (2.0 * i + 1) / count, r = std::sqrt(1 - z * z);
    const double angle = i * std::numbers::pi * (3 - std::sqrt(5.0));
    const Vec3 out(r * std::cos(angle), r * std::sin(angle), z);
    points.add(radius * out, -out);
  }
  return points;
}

// Sizes of connected parts.
std::multiset<std::size_t> parts(std::size_t points, const std::vector<PointEdge>& edges) {
  std::vector<std::size_t> owner(points);
  for (std::size_t p = 0; p < points; ++p) owner[p] = p;
  for (bool is_changed = true; is_changed;) {
    is_changed = false;
    for (const PointEdge& e : edges) {
      auto &a = owner[static_cast<std::size_t>(e.first)],
           &b = owner[static_cast<std::size_t>(e.second)];
      if (a != b) a = b = std::min(a, b), is_changed = true;
    }
  }
  std::multiset<std::size_t> sizes;
  for (std::size_t p = 0; p < points; ++p) {
    const auto n = static_cast<std::size_t>(std::count(owner.begin(), owner.end(), p));
    if (n > 0) sizes.insert(n);
  }
  return sizes;
}

TEST(point_graph, of_a_square_grid_has_its_sides_and_no_diagonals) {
  const auto edges = grid(7, 0, -Vec3::UnitZ()).graph();
  EXPECT_EQ(edges.size(), 2U * 7 * 6);
  for (const PointEdge& e : edges) {
    EXPECT_LT(e.first, e.second);
    EXPECT_NEAR(e.weight, 1, 1e-9);
  }
}

TEST(point_graph, of_a_sphere_is_connected_with_two_to_three_edges_a_point) {
  const Scattered points = sphere(200, 0.05);
  const auto edges = points.graph();
  EXPECT_EQ(parts(200, edges), std::multiset<std::size_t>{200});
  EXPECT_GT(edges.size(), 300U);
  EXPECT_LT(edges.size(), 600U);
  for (const PointEdge& e : edges)
    EXPECT_LT((points.position.row(e.first) - points.position.row(e.second)).norm(), 0.03);
}

TEST(point_graph, never_joins_two_sides_of_a_thin_plate) {
  Scattered points = grid(6, 0, -Vec3::UnitZ());
  const Scattered back = grid(6, -0.001, Vec3::UnitZ());
  for (Eigen::Index p = 0; p < 36; ++p) points.add(back.position.row(p), back.normal.row(p));
  const auto edges = points.graph();
  EXPECT_EQ(parts(72, edges), (std::multiset<std::size_t>{36, 36}));
  EXPECT_EQ(edges.size(), 2U * 2 * 6 * 5);
}

TEST(point_graph, never_joins_sheets_one_above_the_other_that_face_alike) {
  for (const double gap_m : {0.003, 0.005, 0.02}) {
    Scattered points = grid(6, 0, -Vec3::UnitZ());
    const Scattered below = grid(6, -gap_m, -Vec3::UnitZ());
    for (Eigen::Index p = 0; p < 36; ++p)
      points.add(Vec3(below.position.row(p)) + Vec3(0.004, 0.003, 0), below.normal.row(p));
    EXPECT_EQ(parts(72, points.graph()), (std::multiset<std::size_t>{36, 36})) << gap_m;
  }
}

TEST(point_graph, takes_the_edges_of_triangles_where_they_are_known) {
  const Scattered points = grid(2, 0, -Vec3::UnitZ());
  Triangles triangles(2, 3);
  triangles << 0, 2, 3, 0, 3, 1;
  const auto edges = points.graph(triangles);
  ASSERT_EQ(edges.size(), 5U);
  EXPECT_NEAR(edges[2].weight, 0.5, 1e-12);  // the diagonal 0-3 is longer by root 2
}

TEST(point_graph, goes_around_points_that_do_not_take_part) {
  Scattered points = grid(3, 0, -Vec3::UnitZ());
  points.takes_part[4] = 0;  // the middle
  for (const PointEdge& e : points.graph()) EXPECT_TRUE(e.first != 4 && e.second != 4);
  EXPECT_EQ(parts(9, points.graph()), (std::multiset<std::size_t>{1, 8}));
}

TEST(point_graph, of_none_one_two_and_coincident_points_is_finite) {
  EXPECT_TRUE(Scattered{}.graph().empty());
  Scattered points;
  points.add(Vec3::Zero(), Vec3::UnitZ());
  EXPECT_TRUE(points.graph().empty());
  points.add(Vec3(0.01, 0, 0), Vec3::UnitZ());
  ASSERT_EQ(points.graph().size(), 1U);
  points.add(Vec3(0.01, 0, 0), Vec3::UnitZ());
  for (const PointEdge& e : points.graph()) EXPECT_TRUE(std::isfinite(e.weight));
}

}  // namespace
}  // namespace palpate::test
