#include "libfem/mesh/topology.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace palpate {
namespace {

TEST(TetQuality, closed_forms_of_regular_corner_and_flat_tets) {
  const TetCorners regular{Vec3(1, 1, 1), Vec3(-1, 1, -1), Vec3(1, -1, -1), Vec3(-1, -1, 1)};
  EXPECT_NEAR(std::abs(tet_volume_m3(regular)), 8.0 / 3, 1e-14);
  EXPECT_NEAR(min_dihedral_deg(regular), std::acos(1.0 / 3) * 180 / std::numbers::pi, 1e-12);

  const TetCorners corner{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)};
  EXPECT_NEAR(tet_volume_m3(corner), 1.0 / 6, 1e-15);
  EXPECT_NEAR(min_dihedral_deg(corner), std::acos(1 / std::sqrt(3.0)) * 180 / std::numbers::pi,
              1e-12);
  EXPECT_NEAR(tet_volume_m3({corner[1], corner[0], corner[2], corner[3]}), -1.0 / 6, 1e-15);

  // Four points of a square, one lifted: angles at the two diagonals go as the lift.
  const double lift = 1e-3;
  const TetCorners flat{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(1, 1, lift), Vec3(0, 1, 0)};
  EXPECT_NEAR(min_dihedral_deg(flat), lift * 180 / std::numbers::pi, 0.01 * lift * 60);
}

TEST(TetQuality, of_a_mesh_is_that_of_its_worst_tet) {
  TetMesh mesh;
  mesh.nodes.resize(5, 3);
  mesh.nodes << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0.3, 0.3, -0.02;
  mesh.tets.resize(2, 4);
  mesh.tets << 0, 1, 2, 3, 0, 2, 1, 4;
  const TetQuality quality = quality_of(mesh);
  EXPECT_EQ(quality.slivers, 1);
  EXPECT_LT(quality.min_dihedral_deg, kSliverDeg);
  EXPECT_NEAR(quality.min_volume_m3, 0.02 / 6, 1e-15);
  EXPECT_NEAR(quality.volume_m3, 1.0 / 6 + 0.02 / 6, 1e-15);
  EXPECT_EQ(quality_of({}).slivers, 0);
}

}  // namespace
}  // namespace palpate
