#include "libfit/core/geometry.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/surfaces.hpp"

namespace palpate {
namespace {

using testing_support::coarse_block;

TEST(surface, cube_has_its_area_and_volume) {
  const Surface cube = coarse_block(1, 1, 1);
  EXPECT_NEAR(area_m2(cube), 6, 1e-14);
  EXPECT_NEAR(volume_m3(cube), 1, 1e-14);
  EXPECT_EQ(extent_m(cube.vertices), Vec3(1, 1, 1));
}

TEST(surface, volume_keeps_its_digits_far_from_the_origin) {
  Surface cube = coarse_block(1, 1, 1);
  cube.vertices.array() += 1e6;
  EXPECT_NEAR(volume_m3(cube), 1, 1e-9);
}

TEST(surface, corner_normals_do_not_depend_on_the_triangulation_of_the_faces) {
  const Points normals = vertex_normals(coarse_block(1, 1, 1));
  for (int i = 0; i < 8; ++i) {
    const Vec3 expected = Vec3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1) / std::sqrt(3.0);
    EXPECT_LT((normals.row(i).transpose() - expected).norm(), 1e-14) << "vertex " << i;
  }
}

TEST(surface, vertex_without_area_has_a_zero_normal) {
  Surface sliver;
  sliver.vertices.resize(3, 3);
  sliver.vertices << 0, 0, 0, 1, 0, 0, 2, 0, 0;
  sliver.triangles.resize(1, 3);
  sliver.triangles << 0, 1, 2;
  EXPECT_EQ(vertex_normals(sliver).norm(), 0);
}

}  // namespace
}  // namespace palpate
