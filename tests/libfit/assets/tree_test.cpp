#include <gtest/gtest.h>

#include <random>

#include "libfit/runtime/surface/sweep.hpp"
#include "tests/libfit/runtime/models.hpp"

namespace palpate::test {
namespace {

TEST(tree, first_entry_equals_the_exhaustive_search) {
  const Loaded sphere = load(sphere_model(0.03, 12, uniform(400, 300, 0.3)));
  std::mt19937 random(9);
  std::normal_distribution<double> gauss(0, 0.03);
  int entries = 0;
  for (int round = 0; round < 3000; ++round) {
    const runtime::Vec3d p{gauss(random), gauss(random), gauss(random)},
        q{gauss(random), gauss(random), gauss(random)};
    runtime::Entry all;
    for (int t = 0; t < sphere.asset.triangles; ++t) runtime::try_entry(sphere.asset, t, p, q, all);
    const runtime::Entry found = runtime::first_entry(sphere.asset, p, q);
    ASSERT_EQ(found.triangle, all.triangle) << "seed 9, round " << round;
    ASSERT_EQ(found.along, all.along) << "seed 9, round " << round;
    entries += found.triangle >= 0;
  }
  EXPECT_GT(entries, 300);
}

TEST(tree, ways_along_an_axis_and_of_no_length_are_handled) {
  const Loaded sphere = load(sphere_model(0.03, 12, uniform(400, 300, 0.3)));
  EXPECT_GE(
      runtime::first_entry(sphere.asset, {0.0011, 0.0013, 0.05}, {0.0011, 0.0013, 0}).triangle, 0);
  EXPECT_EQ(
      runtime::first_entry(sphere.asset, {0.0011, 0.0013, 0.05}, {0.0011, 0.0013, 0.05}).triangle,
      -1);
  EXPECT_EQ(
      runtime::first_entry(sphere.asset, {0.0011, 0.0013, 0}, {0.0011, 0.0013, 0.05}).triangle, -1);
}

}  // namespace
}  // namespace palpate::test
