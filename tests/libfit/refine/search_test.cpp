#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "libfit/refine/points_on_surface.hpp"
#include "tests/libfit/refine/surfaces.hpp"

namespace palpate::testing_refine {
namespace {

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

}  // namespace
}  // namespace palpate::testing_refine
