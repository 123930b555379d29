#include "libfem/mesh/fill/fill_volume.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "libfem/mesh/fill/child_process.hpp"
#include "libfem/mesh/fill/mend_slivers.hpp"
#include "libfem/mesh/fill/meshers.hpp"
#include "libfem/mesh/surface/simulation_surface.hpp"
#include "libfem/mesh/tet_quality.hpp"
#include "libfit/core/error.hpp"
#include "tests/libfem/mesh/surface/surfaces.hpp"

namespace palpate {
namespace {

using testing::cube, testing::inside_out, testing::together, testing::moved, testing::sphere,
    testing::subdivided;

void expect_true_report(const TetMesh& mesh, const FillReport& report) {
  const TetQuality quality = quality_of(mesh);
  EXPECT_EQ(report.nodes, mesh.nodes.rows());
  EXPECT_EQ(report.tets, mesh.tets.rows());
  EXPECT_EQ(report.min_dihedral_deg, quality.min_dihedral_deg);
  EXPECT_GT(report.worst_mean_ratio, 0);
  EXPECT_EQ(report.slivers, quality.slivers);
}

TEST(FillVolume, a_cube_is_filled_exactly_and_keeps_its_surface_vertices) {
  Surface surface = cube(0.1);
  for (int level = 0; level < 3; ++level) surface = subdivided(surface);
  FillReport report;
  const TetMesh mesh = fill_volume(surface, {.mesher = Mesher::tetgen}, &report);
  expect_true_report(mesh, report);
  EXPECT_EQ(report.mesher, Mesher::tetgen);
  EXPECT_NEAR(report.volume_ratio, 1, 1e-9);
  EXPECT_GT(report.min_dihedral_deg, 12);
  for (const auto& p : surface.vertices.rowwise())
    EXPECT_EQ((mesh.nodes.rowwise() - p).rowwise().squaredNorm().minCoeff(), 0);
}

TEST(FillVolume, a_sphere_is_filled_well_by_both_meshers) {
  const Surface coarse = simulation_surface(sphere(0.05, 4), 0.012).surface;
  for (const Mesher mesher : {Mesher::tetgen, Mesher::mesh_3}) {
    SCOPED_TRACE(kMeshers[static_cast<std::size_t>(mesher)].name);
    FillReport report;
    const TetMesh mesh = fill_volume(coarse, {.mesher = mesher}, &report);
    expect_true_report(mesh, report);
    EXPECT_EQ(report.mesher, mesher);
    EXPECT_NEAR(report.volume_ratio, 1, mesher == Mesher::tetgen ? 1e-9 : 0.03);
    EXPECT_GT(report.min_dihedral_deg, 10);
    EXPECT_LT(report.tets, 5000);
  }
}

TEST(FillVolume, a_cavity_stays_empty) {
  const Surface shell = together(sphere(0.05, 3), inside_out(sphere(0.02, 2)));
  FillReport report;
  const TetMesh mesh = fill_volume(shell, {.mesher = Mesher::tetgen}, &report);
  EXPECT_NEAR(report.volume_ratio, 1, 1e-9);
  for (Eigen::Index t = 0; t < mesh.tets.rows(); ++t) {
    Vec3 centre = Vec3::Zero();
    for (int k = 0; k < 4; ++k) centre += mesh.nodes.row(mesh.tets(t, k)).transpose() / 4;
    EXPECT_GT(centre.norm(), 0.015);
  }
}

TEST(FillVolume, a_surface_that_crosses_itself_goes_to_mesh_3_or_is_refused) {
  const Surface crossing =
      together(sphere(0.05, 2), moved(sphere(0.05, 2), Vec3(0.0801, 0.0102, 0.0053)));
  try {
    fill_volume(crossing, {.mesher = Mesher::tetgen});
    FAIL() << "TetGen ran on a surface that crosses itself";
  } catch (const Error& error) {
    EXPECT_EQ(error.fact(), "TetGen is not run on a surface that crosses itself");
  }
  FillReport report;
  try {
    const TetMesh mesh = fill_volume(crossing, {.max_nodes = 20000}, &report);
    EXPECT_EQ(report.mesher, Mesher::mesh_3);
    EXPECT_GT(report.worst_mean_ratio, 0);
    EXPECT_NEAR(report.volume_ratio, 1, 0.1);
  } catch (const Error& error) {
    EXPECT_NE(error.fact().find("Mesh_3"), std::string::npos) << error.fact();
  }
  EXPECT_EQ(report.notes.front(), "TetGen is not run on a surface that crosses itself");
}

TEST(FillVolume, tetgen_on_a_crossing_surface_ends_in_a_reason_and_not_in_our_death) {
  const Surface crossing = together(cube(0.1), moved(cube(0.1), Vec3(0.05, 0.03, 0.04)));
  const auto result = run_in_child(
      [&] {
        return fill_with_tetgen(crossing, Points(0, 3), {1.4, 12, 1e-5});
      },
      tetgen_failure, 20);
  ASSERT_TRUE(std::holds_alternative<std::string>(result));
  EXPECT_FALSE(std::get<std::string>(result).empty());
}

TEST(FillVolume, open_surfaces_and_silly_options_are_refused_before_meshing) {
  Surface open = cube(0.1);
  open.triangles.conservativeResize(11, 3);
  try {
    fill_volume(open);
    FAIL() << "an open surface went through";
  } catch (const Error& error) {
    EXPECT_EQ(error.fact(), "it cannot be filled: 3 edges lie on a border");
  }
  EXPECT_THROW(fill_volume(cube(0.1), {.target_edge_m = -1}), Error);
  EXPECT_THROW(fill_volume(cube(0.1), {.interior_growth = 0.5}), Error);
  EXPECT_THROW(fill_volume(cube(0.1), {.safety_limit_s = 0}), Error);
}

TEST(FillVolume, the_same_input_gives_the_same_bits) {
  const Surface coarse = sphere(0.05, 3);
  for (const Mesher mesher : {Mesher::tetgen, Mesher::mesh_3}) {
    const TetMesh a = fill_volume(coarse, {.mesher = mesher});
    const TetMesh b = fill_volume(coarse, {.mesher = mesher});
    EXPECT_EQ(a.nodes, b.nodes);
    EXPECT_EQ(a.tets, b.tets);
  }
}

// TetGen was handed its largest volume with 15 decimals: 0 for this body, which it filled for ever.
TEST(FillVolume, a_body_of_micrometres_is_filled_as_one_of_decimetres_is) {
  const Surface large = sphere(0.1, 3);
  Surface small = large;
  small.vertices *= 0x1p-14;  // 6 um
  const TetMesh coarse = fill_volume(large, {.target_edge_m = 0.03});
  const TetMesh tiny = fill_volume(small, {.target_edge_m = 0.03 * 0x1p-14});
  EXPECT_EQ(coarse.tets, tiny.tets);
  EXPECT_EQ(Points(coarse.nodes * 0x1p-14), tiny.nodes);
}

// Its CPU limit once made a mesher's result depend on the machine; what bounds it now is counted.
TEST(FillVolume, a_mesher_that_wants_more_nodes_than_it_may_have_says_so) {
  const Surface coarse = sphere(0.05, 3);
  for (const Mesher mesher : {Mesher::tetgen, Mesher::mesh_3}) try {
      fill_volume(coarse, {.mesher = mesher, .target_edge_m = 0.002, .max_nodes = 500});
      FAIL() << "filled";
    } catch (const Error& error) {
      EXPECT_NE(error.fact().find("wanted more than 500"), std::string::npos) << error.fact();
    }
}

// The volume of a box is the same after its flattest tets were made flatter and mended.
TEST(MendSlivers, mends_what_a_moved_node_flattens_and_leaves_the_rest) {
  Surface surface = cube(0.1);
  for (int level = 0; level < 2; ++level) surface = subdivided(surface);
  TetMesh mesh = fill_volume(surface, {.mesher = Mesher::tetgen, .target_edge_m = 0.02});
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
      if (!(bad.worst_mean_ratio > 0) || bad.slivers == 0) continue;
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
