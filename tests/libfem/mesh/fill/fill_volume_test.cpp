#include "libfem/mesh/fill/fill_volume.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <variant>

#include "libfem/mesh/fill/fill_steps.hpp"
#include "libfem/mesh/repair/facts.hpp"
#include "libfem/mesh/surface/surface.hpp"
#include "libfem/mesh/topology.hpp"
#include "tests/libfem/mesh/surface/surfaces.hpp"
#include "tests/support/error_of.hpp"

namespace palpate {
namespace {

using testing::cube, testing::inside_out, testing::together, testing::moved, testing::sphere,
    testing::subdivided;

TEST(FillVolume, a_cube_is_filled_exactly_and_keeps_its_surface_vertices) {
  Surface surface = cube(0.1);
  for (int level = 0; level < 3; ++level) surface = subdivided(surface);
  const TetMesh mesh = fill_volume(surface, mean_edge_m(surface));
  const TetQuality quality = quality_of(mesh);
  EXPECT_NEAR(quality.volume_m3, 1e-3, 1e-12);
  EXPECT_GT(quality.min_volume_m3, 0);
  EXPECT_GT(quality.min_dihedral_deg, 12);
  for (const auto& p : surface.vertices.rowwise())
    EXPECT_EQ((mesh.nodes.rowwise() - p).rowwise().squaredNorm().minCoeff(), 0);
}

TEST(FillVolume, a_sphere_is_filled_well) {
  const Surface coarse = simulation_surface(sphere(0.05, 4), 0.012).surface;
  const TetMesh mesh = fill_volume(coarse, mean_edge_m(coarse));
  const TetQuality quality = quality_of(mesh);
  EXPECT_NEAR(quality.volume_m3 / volume_m3(coarse), 1, 1e-9);
  EXPECT_GT(quality.min_dihedral_deg, 10);
  EXPECT_LT(mesh.tets.rows(), 5000);
}

TEST(FillVolume, cavities_stay_empty) {
  const Vec3 aside(0.02, 0, 0);
  Surface shell = sphere(0.05, 3);
  for (const Vec3& centre : {aside, Vec3(-aside)})
    shell = together(shell, moved(inside_out(sphere(0.01, 2)), centre));
  const TetMesh mesh = fill_volume(shell, mean_edge_m(shell));
  EXPECT_NEAR(quality_of(mesh).volume_m3 / volume_m3(shell), 1, 1e-9);
}

TEST(FillVolume, tetgen_on_a_crossing_surface_ends_in_a_reason_and_not_in_our_death) {
  const Surface crossing = together(cube(0.1), moved(cube(0.1), Vec3(0.05, 0.03, 0.04)));
  const auto result = run_in_child(
      [&] {
        return fill_with_tetgen(crossing, Points(0, 3), {1.4, 12, 1e-5, 1000});
      },
      tetgen_failure, 20);
  ASSERT_TRUE(std::holds_alternative<std::string>(result));
  EXPECT_FALSE(std::get<std::string>(result).empty());
}

TEST(FillVolume, the_same_input_gives_the_same_bits) {
  const Surface coarse = sphere(0.05, 3);
  const TetMesh a = fill_volume(coarse, 0.01), b = fill_volume(coarse, 0.01);
  EXPECT_EQ(a.nodes, b.nodes);
  EXPECT_EQ(a.tets, b.tets);
}

// TetGen was handed its largest volume with 15 decimals: 0 for this body, which it filled for ever.
TEST(FillVolume, a_body_of_micrometres_is_filled_as_one_of_decimetres_is) {
  const Surface large = sphere(0.1, 3);
  Surface small = large;
  small.vertices *= 0x1p-14;  // 6 um
  const TetMesh coarse = fill_volume(large, 0.03);
  const TetMesh tiny = fill_volume(small, 0.03 * 0x1p-14);
  EXPECT_EQ(coarse.tets, tiny.tets);
  EXPECT_EQ(Points(coarse.nodes * 0x1p-14), tiny.nodes);
}

// Its CPU limit once made a mesher's result depend on the machine; what bounds it now is counted.
TEST(FillVolume, a_mesher_that_wants_more_points_than_it_may_have_says_so) {
  const auto result = run_in_child(
      [] {
        return fill_with_tetgen(sphere(0.5, 3), Points(0, 3), {1.4, 12, 1e-6, 500});
      },
      tetgen_failure, 20);
  EXPECT_EQ(std::get<std::string>(result), "wanted more than 500 points inside");
}

// The volume of a box is the same after its flattest tets were made flatter and mended.
TEST(MendSlivers, mends_what_a_moved_node_flattens_and_leaves_the_rest) {
  Surface surface = cube(0.1);
  for (int level = 0; level < 2; ++level) surface = subdivided(surface);
  TetMesh mesh = fill_volume(surface, 0.02);
  TetMesh same = mesh;
  EXPECT_EQ(mend_slivers(same, kSliverDeg), 0);
  EXPECT_EQ(same.nodes, mesh.nodes);
  const double volume = quality_of(mesh).volume_m3;
  // An inner node goes nearly onto the face opposite it in one of its tets.
  int mended = 0;
  for (Eigen::Index t = 0; t < mesh.tets.rows(); ++t)
    for (int k = 0; k < 4; ++k) {
      TetMesh flat = mesh;
      const auto face = [&](int i) { return Vec3(mesh.nodes.row(mesh.tets(t, (k + i) % 4))); };
      const Vec3 middle = (face(1) + face(2) + face(3)) / 3;
      if ((Vec3(face(0)).array() < 1e-9).any() || (Vec3(face(0)).array() > 0.1 - 1e-9).any())
        continue;
      flat.nodes.row(mesh.tets(t, k)) += 0.98 * (middle - face(0)).transpose();
      const TetQuality bad = quality_of(flat);
      if (!(bad.min_volume_m3 > 0) || bad.slivers == 0) continue;
      EXPECT_GT(mend_slivers(flat, kSliverDeg), 0);
      EXPECT_EQ(quality_of(flat).slivers, 0) << "tet " << t << " corner " << k;
      EXPECT_NEAR(quality_of(flat).volume_m3 / volume, 1, 1e-12);
      EXPECT_LE(flat.tets.rows(), mesh.tets.rows() + 10);
      ++mended;
    }
  EXPECT_GT(mended, 3);
}

}  // namespace
}  // namespace palpate
