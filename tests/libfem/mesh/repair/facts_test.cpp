#include "libfem/mesh/repair/facts.hpp"

#include <gtest/gtest.h>

#include "libfit/core/error.hpp"
#include "tests/libfem/mesh/repair/shapes.hpp"

namespace palpate {
namespace {

using namespace mesh_repair_test;

TEST(SurfaceFacts, a_box_is_closed_manifold_and_oriented_with_its_volume_and_area) {
  const SurfaceFacts facts = surface_facts(box(0.1));
  EXPECT_TRUE(facts.is_closed && facts.is_manifold && facts.is_oriented);
  EXPECT_EQ(facts.triangles, 6 * 9 * 2);
  EXPECT_EQ(facts.vertices, facts.triangles / 2 + 2);  // Euler
  EXPECT_EQ(facts.components, 1);
  EXPECT_NEAR(facts.volume_m3, 1e-3, 1e-15);
  EXPECT_NEAR(facts.area_m2, 0.06, 1e-15);
  EXPECT_NEAR(facts.extent_m.x(), 0.1, 1e-15);
}

TEST(SurfaceFacts, each_defect_is_counted) {
  const Surface cube = box(0.1, Vec3::Zero(), 1);
  EXPECT_EQ(surface_facts(without(cube, {0})).border_edges, 3);
  EXPECT_EQ(surface_facts(together(cube, cube)).components, 2);
  Surface one_turned = cube;
  std::swap(one_turned.triangles(4, 0), one_turned.triangles(4, 1));
  EXPECT_EQ(surface_facts(one_turned).unlike_edges, 3);
  EXPECT_FALSE(surface_facts(one_turned).is_oriented);
  Surface twice = together(cube, cube);
  twice.triangles.bottomRows(12) = cube.triangles;  // each edge now has four triangles
  EXPECT_EQ(surface_facts(twice).non_manifold_edges, 18);
}

TEST(SurfaceFacts, a_bow_tie_is_a_pinched_vertex) {
  Surface tie{Points(5, 3), Triangles(2, 3)};
  tie.vertices << 0, 0, 0, 1, 0, 0, 0, 1, 0, -1, 0, 0, 0, -1, 0;
  tie.triangles << 0, 1, 2, 0, 3, 4;
  EXPECT_EQ(surface_facts(tie).pinched_vertices, 1);
  EXPECT_FALSE(surface_facts(tie).is_manifold);
}

TEST(SurfaceFacts, an_empty_surface_is_not_closed) {
  EXPECT_FALSE(surface_facts({Points(0, 3), Triangles(0, 3)}).is_closed);
}

}  // namespace
}  // namespace palpate
