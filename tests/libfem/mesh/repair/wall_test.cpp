// Walls against the shapes that they hollow out.

#include <gtest/gtest.h>

#include <numbers>

#include "libfem/mesh/repair/facts.hpp"
#include "libfem/mesh/repair/wall.hpp"
#include "libfit/core/error.hpp"
#include "tests/support/surfaces.hpp"

namespace palpate {
namespace {

using testing_support::octasphere;

TEST(Wall, of_a_ball_leaves_a_smaller_ball) {
  const double radius_m = 0.03, wall_m = 0.006;
  const Walled out = with_wall(octasphere(4, radius_m), wall_m);
  EXPECT_EQ(out.lumens, 1);
  EXPECT_NEAR(out.thickness_m, wall_m, 0.03 * wall_m);
  EXPECT_NEAR(out.lumen_m3 / (4.0 / 3 * std::numbers::pi * std::pow(radius_m - wall_m, 3)), 1,
              0.03);
  EXPECT_EQ(out.solid_share, 0);
  const SurfaceFacts facts = surface_facts(out.surface);
  EXPECT_EQ(facts.cavities, 1);
  EXPECT_TRUE(facts.is_closed && facts.is_manifold && facts.is_oriented);
}

// A neck of 8 mm is solid under walls of 5 mm, and the two bulbs have a lumen each.
TEST(Wall, is_solid_where_the_body_is_thinner_than_two) {
  Surface peanut = octasphere(5, 1);
  for (auto vertex : peanut.vertices.rowwise()) {
    const double along = vertex[0];
    const double across = 0.008 / 2 + 0.016 * along * along;
    vertex *= across / std::max(1e-9, std::hypot(vertex[1], vertex[2]));
    vertex[0] = 0.05 * along;
    if (std::abs(along) > 0.999) vertex[1] = vertex[2] = 0;
  }
  const Walled out = with_wall(peanut, 0.005);
  EXPECT_EQ(out.lumens, 2);
  EXPECT_GT(out.solid_share, 0.02);
}

TEST(Wall, that_fills_the_body_leaves_it_as_it_is) {
  const Surface ball = octasphere(3, 0.01);
  const Walled out = with_wall(ball, 0.011);
  EXPECT_EQ(out.lumens, 0);
  EXPECT_EQ(out.surface.triangles, ball.triangles);
}

TEST(Wall, takes_a_lumen_of_either_orientation_and_refuses_one_that_sticks_out) {
  const Surface outer = octasphere(3, 0.03);
  const Walled out = with_lumen(outer, octasphere(3, 0.02), "lumen.stl"),
               turned = with_lumen(outer, testing_support::inside_out(octasphere(3, 0.02)), "");
  EXPECT_EQ(out.lumens, 1);
  EXPECT_NEAR(out.thickness_m, 0.01, 2e-4);
  EXPECT_NEAR(volume_m3(out.surface), volume_m3(turned.surface), 1e-12);
  EXPECT_LT(volume_m3(out.surface), volume_m3(outer));
  EXPECT_THROW(with_lumen(outer, octasphere(3, 0.04), "lumen.stl"), Error);
}

}  // namespace
}  // namespace palpate
