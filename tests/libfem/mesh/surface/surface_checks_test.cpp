#include <gtest/gtest.h>

#include "libfem/mesh/repair/facts.hpp"
#include "libfem/mesh/repair/repair_steps.hpp"
#include "libfem/mesh/surface/surface.hpp"
#include "tests/libfem/mesh/surface/surfaces.hpp"

namespace palpate {
namespace {

using testing::cube, testing::inside_out, testing::together, testing::moved, testing::sphere;

TEST(SurfaceChecks, closed_surfaces_pass) {
  EXPECT_EQ(why_not_closed(cube(0.1)), std::nullopt);
  EXPECT_EQ(why_not_closed(sphere(0.1, 2)), std::nullopt);
  EXPECT_EQ(why_not_closed(together(sphere(0.1, 2), inside_out(sphere(0.05, 1)))), std::nullopt);
}

TEST(SurfaceChecks, each_defect_is_named) {
  EXPECT_EQ(why_not_closed({}), "it has no triangle");
  EXPECT_EQ(why_not_closed(inside_out(cube(1))), "it points inward: its volume is not positive");

  Surface open = cube(1);
  open.triangles.conservativeResize(11, 3);
  EXPECT_EQ(why_not_closed(open), "3 edges lie on a border");

  Surface turned = cube(1);
  std::swap(turned.triangles(0, 0), turned.triangles(0, 1));
  EXPECT_EQ(why_not_closed(turned)->find("3 edges join triangles"), 0U);

  // Two cubes that share a corner vertex only.
  Surface pinched = together(cube(1), moved(cube(1), Vec3(1, 1, 1)));
  for (auto& v : pinched.triangles.reshaped())
    if (v == 8) v = 7;
  EXPECT_EQ(why_not_closed(pinched), "1 vertex joins two sheets that otherwise do not touch");
}

TEST(SurfaceChecks, overlapping_cubes_cross_and_disjoint_ones_do_not) {
  const auto crossings = [](const Vec3& by) {
    return repair::self_intersections(together(cube(1), moved(cube(1), by)));
  };
  EXPECT_FALSE(crossings(Vec3(0.5, 0.3, 0.4)).empty());
  EXPECT_TRUE(crossings(Vec3(1.5, 0.3, 0.4)).empty());
}

TEST(SurfaceChecks, deviation_of_concentric_spheres_is_their_gap) {
  const Surface inner = sphere(0.050, 4), outer = sphere(0.053, 4);
  EXPECT_NEAR(deviation_m(inner, triangle_boxes(inner), outer), 0.003, 1e-4);
}

}  // namespace
}  // namespace palpate
