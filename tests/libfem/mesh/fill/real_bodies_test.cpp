#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "libfem/mesh/fill/fill_volume.hpp"
#include "libfem/mesh/read/read.hpp"
#include "libfem/mesh/repair/facts.hpp"
#include "libfem/mesh/repair/mend.hpp"
#include "libfem/mesh/surface/surface.hpp"
#include "libfem/mesh/topology.hpp"
#include "tests/support/shared_data.hpp"

namespace palpate {
namespace {

struct BodyFile {
  const char* file;
  double length_unit_m, target_edge_m;
  int max_tets;
};

void PrintTo(const BodyFile& param, std::ostream* out) { *out << param.file; }

class RealBodies : public ::testing::TestWithParam<BodyFile> {};

TEST_P(RealBodies, go_from_file_to_sound_coarse_tets) {
  const auto [file, length_unit_m, target_edge_m, max_tets] = GetParam();
  PALPATE_NEEDS_DATA("data/surfaces");
  const auto path = testing_support::shared_data("data/surfaces") / file;
  const Surface fine = mend_surface(read_surface(path, length_unit_m), {}, file).surface;
  const SimulationSurface coarse =
      simulation_surface(fine, target_edge_m, {.volume_tolerance = 0.02});
  const TetMesh mesh = fill_volume(coarse.surface, mean_edge_m(coarse.surface));
  const TetQuality quality = quality_of(mesh);
  EXPECT_NEAR(volume_m3(coarse.surface) / volume_m3(fine), 1, 0.02);
  EXPECT_LT(coarse.deviation_m, 0.3 * target_edge_m);
  EXPECT_NEAR(quality.volume_m3 / volume_m3(coarse.surface), 1, 1e-6);
  EXPECT_EQ(quality.slivers, 0);
  EXPECT_LT(mesh.tets.rows(), max_tets);
}

INSTANTIATE_TEST_SUITE_P(
    Shared, RealBodies,
    ::testing::Values(BodyFile{"sofa_liver2.obj", 0.110, 0.016, 4000},
                      BodyFile{"sofa_liver.vtk", 0.001, 0.016, 8000},
                      BodyFile{"odedstein_hand_closed.obj", 0.2, 0.012, 15000}),
    [](const auto& body) { return testing_support::file_as_name(body.param.file); });

// As `prepare` fills it. With a coarse surface that may lose 2 % of the volume, in place of 8, one
// flat tet of 3521 is still left. Edges of the boundary give way.
TEST(SmoothLiver, slivers_of_tetgen_are_mended) {
  PALPATE_NEEDS_DATA("data/surfaces");
  const std::string file = "sofa_liver-smooth.obj";
  const auto path = testing_support::shared_data("data/surfaces") / file;
  const Surface fine = mend_surface(read_surface(path, 0.033), {}, file).surface;
  const double edge_m = 0.28 * std::cbrt(volume_m3(fine));
  const SimulationSurface coarse = simulation_surface(fine, edge_m);
  const TetMesh mesh = fill_volume(coarse.surface, edge_m);
  EXPECT_EQ(quality_of(mesh).slivers, 0);
  EXPECT_LT(mesh.tets.rows(), 1500);
  EXPECT_NEAR(quality_of(mesh).volume_m3 / volume_m3(coarse.surface), 1, 1e-3);
}

}  // namespace
}  // namespace palpate
