#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "libfit/refine/edge_paths.hpp"
#include "libfit/refine/nearest_triangle.hpp"
#include "tests/libfit/refine/surfaces.hpp"

namespace palpate::testing_refine {
namespace {

Vec3 random_point(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return {normal(random), normal(random), normal(random)};
}

TEST(NearestOnTriangle, no_sample_of_the_triangle_is_nearer) {
  for (unsigned seed = 1; seed <= 200; ++seed) {
    std::mt19937 random(seed);
    const Vec3 a = random_point(random), b = random_point(random);
    Vec3 c = random_point(random);
    if (seed % 4 == 0) c = a + 1.7 * (b - a);  // flat
    if (seed % 10 == 0) c = a;
    const Vec3 p = 2 * random_point(random);
    const TrianglePoint hit = nearest_on_triangle(p, a, b, c);
    EXPECT_NEAR(hit.weight.sum(), 1, 1e-15);
    EXPECT_GE(hit.weight.minCoeff(), 0);
    const Vec3 foot = hit.weight[0] * a + hit.weight[1] * b + hit.weight[2] * c;
    EXPECT_NEAR((foot - p).norm(), hit.distance_m, 1e-12) << "seed " << seed;
    for (int i = 0; i <= 40; ++i)
      for (int j = 0; i + j <= 40; ++j)
        EXPECT_LE(hit.distance_m, (a + (b - a) * i / 40 + (c - a) * j / 40 - p).norm() + 1e-12)
            << "seed " << seed;
  }
}

TEST(TriangleTree, finds_what_trying_all_triangles_finds) {
  const Surface sphere = icosphere(3, 1);
  const TriangleTree tree(sphere);
  std::mt19937 random(11);
  for (int i = 0; i < 300; ++i) {
    const Vec3 p = i == 0 ? Vec3::Zero() : Vec3(random_point(random));
    const auto upper = [&](std::int32_t t, const TrianglePoint&) {
      return i % 2 == 0 || sphere.vertices(sphere.triangles(t, 0), 2) > 0;
    };
    TriangleTree::Hit best{-1, {Vec3::Zero(), std::numeric_limits<double>::infinity()}};
    for (std::int32_t t = 0; t < sphere.triangles.rows(); ++t) {
      const auto point = nearest_on_triangle(p, sphere.vertices.row(sphere.triangles(t, 0)),
                                             sphere.vertices.row(sphere.triangles(t, 1)),
                                             sphere.vertices.row(sphere.triangles(t, 2)));
      if (point.distance_m < best.point.distance_m && upper(t, point)) best = {t, point};
    }
    const auto hit = tree.nearest(p, 100, upper);
    ASSERT_TRUE(hit);
    EXPECT_EQ(hit->triangle, best.triangle) << "seed 11, query " << i;
    EXPECT_EQ(hit->point.distance_m, best.point.distance_m);
    EXPECT_FALSE(tree.nearest(p, best.point.distance_m * 0.999, upper));
  }
}

TEST(TriangleTree, an_empty_surface_has_no_nearest_triangle) {
  const Surface empty;
  EXPECT_FALSE(TriangleTree(empty).nearest(Vec3::Zero(), 1, [](auto, auto&) { return true; }));
}

TEST(EdgePaths, cells_split_a_strip_halfway_and_ties_go_to_the_lower_index) {
  const Surface strip = plate(10, 1, 1, 0.1);  // vertex 2 i at x = i / 10
  const NearestSource found = nearest_source(strip, {{}, {{20, 0}}, {{0, 0}}});
  for (int i = 0; i <= 10; ++i) {
    const auto v = static_cast<std::size_t>(2 * i);
    EXPECT_EQ(found.source[v], i < 5 ? 2 : 1);
    EXPECT_NEAR(found.distance_m[v], std::min(i, 10 - i) / 10.0, 1e-15);
  }
}

TEST(EdgePaths, agree_with_relaxing_every_edge_until_nothing_changes) {
  const Surface sphere = icosphere(3, 1);
  std::mt19937 random(4);
  std::vector<EdgePathSeeds> sources(6);
  for (auto& seeds : sources)
    for (int k = 0; k < 3; ++k)
      seeds.push_back(
          {int(random() % unsigned(sphere.vertices.rows())), double(random() % 100) / 300});
  std::vector<double> expected(static_cast<std::size_t>(sphere.vertices.rows()), 1e9);
  for (const auto& seeds : sources)
    for (const auto& seed : seeds)
      expected[std::size_t(seed.vertex)] =
          std::min(expected[std::size_t(seed.vertex)], seed.distance_m);
  for (bool is_changed = true; is_changed;) {
    is_changed = false;
    for (Eigen::Index i = 0; i < sphere.triangles.size(); ++i) {
      const int a = sphere.triangles.data()[i], b = sphere.triangles(i / 3, (i + 1) % 3);
      const double length = (sphere.vertices.row(a) - sphere.vertices.row(b)).norm();
      for (const auto& [from, to] : {std::pair(a, b), std::pair(b, a)})
        if (expected[std::size_t(from)] + length < expected[std::size_t(to)] - 1e-12) {
          expected[std::size_t(to)] = expected[std::size_t(from)] + length;
          is_changed = true;
        }
    }
  }
  const NearestSource found = nearest_source(sphere, sources);
  for (std::size_t v = 0; v < expected.size(); ++v)
    EXPECT_NEAR(found.distance_m[v], expected[v], 1e-11) << "seed 4, vertex " << v;
}

TEST(EdgePaths, do_not_jump_gaps) {
  const Surface both = together(plate(10, 1, 1, 0.1), plate(10, 1, 1, 0.1, 1e-6));
  const NearestSource found = nearest_source(both, {{{0, 0}}});
  EXPECT_EQ(found.source.front(), 0);
  EXPECT_EQ(found.source.back(), -1);
  EXPECT_EQ(found.distance_m.back(), std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace palpate::testing_refine
