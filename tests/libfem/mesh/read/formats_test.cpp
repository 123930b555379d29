// Every format gives the cube it was written from.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "libfem/mesh/read/read.hpp"
#include "libfit/core/error.hpp"
#include "tests/libfem/mesh/read/sample_files.hpp"
#include "tests/support/shared_data.hpp"

namespace palpate {
namespace {

using namespace mesh_read_test;

double tet_volume_m3(const TetMesh& mesh) {
  double sum = 0;
  for (Eigen::Index t = 0; t < mesh.tets.rows(); ++t) {
    Vec3 p[4];
    for (int k = 0; k < 4; ++k) p[k] = mesh.nodes.row(mesh.tets(t, k));
    sum += (p[1] - p[0]).cross(p[2] - p[0]).dot(p[3] - p[0]) / 6;
  }
  return sum;
}

class EverySurfaceFormat : public OfSamples {};
INSTANTIATE_TEST_SUITE_P(Samples, EverySurfaceFormat, testing::ValuesIn(surface_samples()),
                         sample_name);

TEST_P(EverySurfaceFormat, gives_the_cube_in_metres) {
  const Surface surface = read_surface(write(GetParam()), 1e-3);
  ASSERT_EQ(surface.vertices.rows(), 8);
  ASSERT_EQ(surface.triangles.rows(), 12);
  EXPECT_NEAR(volume_m3(surface), 1e-9, 1e-18);
  EXPECT_NEAR(area_m2(surface), 6e-6, 1e-15);
  const Surface cube = cube_surface();
  const bool keeps_vertices = GetParam().extension != ".stl";
  if (keeps_vertices) {
    EXPECT_TRUE(surface.vertices.isApprox(1e-3 * cube.vertices, 0));
    EXPECT_EQ(surface.triangles, cube.triangles);
  }
}

std::vector<SampleFile> text_samples() {
  std::vector<SampleFile> samples = surface_samples();
  std::erase_if(samples, [](const SampleFile& sample) {
    return sample.bytes.find('\0') != std::string::npos;
  });
  return samples;
}

class EveryTextFormat : public EverySurfaceFormat {};
INSTANTIATE_TEST_SUITE_P(Samples, EveryTextFormat, testing::ValuesIn(text_samples()), sample_name);

TEST_P(EveryTextFormat, reads_line_ends_of_every_system) {
  for (const std::string line_end : {"\r\n", "\r"}) {
    SampleFile sample = GetParam();
    sample.bytes.clear();
    for (const char c : GetParam().bytes) sample.bytes += c == '\n' ? line_end : std::string(1, c);
    EXPECT_EQ(read_surface(write(sample), 1).triangles.rows(), 12);
  }
}

TEST_P(EveryTextFormat, reads_past_a_byte_order_mark) {
  SampleFile sample = GetParam();
  sample.bytes.insert(0, "\xef\xbb\xbf");
  EXPECT_EQ(read_surface(write(sample), 1).triangles.rows(), 12);
}

// Its numbers were refused: "a vertex needs three numbers".
TEST_F(MeshFiles, of_obj_continue_a_line_after_a_backslash_in_every_statement) {
  const std::string text = "v 0 0 30\nv 10 0 30\nv 0 10 30\ng top upper\nf 1 2 3\n";
  for (const std::string blank : {" \\\n ", "\\\n ", " \\\r\n\t"}) {
    std::string broken;
    for (const char c : text) broken += c == ' ' ? blank : std::string(1, c);
    const Surface surface = read_surface(write("a.obj", broken), 1);
    EXPECT_EQ(surface.vertices, read_surface(write("b.obj", text), 1).vertices) << broken;
    EXPECT_EQ(surface.triangles.rows(), 1) << broken;
  }
}

class EveryTetFormat : public OfSamples {};
INSTANTIATE_TEST_SUITE_P(Samples, EveryTetFormat, testing::ValuesIn(tet_samples()), sample_name);

TEST_P(EveryTetFormat, gives_the_cube_in_metres) {
  TetReadNotes notes;
  const TetMesh mesh = read_tet_mesh(write(GetParam()), 1e-3, &notes);
  const TetMesh cube = cube_tets();
  EXPECT_TRUE(mesh.nodes.isApprox(1e-3 * cube.nodes, 0));
  EXPECT_EQ(mesh.tets, cube.tets);
  EXPECT_NEAR(tet_volume_m3(mesh), 1e-9, 1e-18);
  EXPECT_EQ(notes.flipped_tets, 0u);
  EXPECT_EQ(notes.dropped_nodes, 0u);
}

TEST(Formats, each_extension_known_has_a_sample) {
  for (const auto& [known, samples] : {std::pair{surface_formats(), surface_samples()},
                                       std::pair{tet_mesh_formats(), tet_samples()}}) {
    std::size_t rows = 0;
    for (std::size_t at = known.find(" ("); at != std::string::npos;
         at = known.find(" (", at + 1)) {
      const std::size_t dot = known.rfind('.', at);
      const std::string extension = known.substr(dot, at - dot);
      EXPECT_TRUE(std::ranges::any_of(samples, [&](const auto& s) {
        return s.extension == extension;
      })) << extension;
      ++rows;
    }
    EXPECT_GE(rows, 2u) << known;
  }
}

// Real files: counts and volumes as documented with the data.
std::filesystem::path shared(const std::string& name) {
  return testing_support::shared_data("data/" + name);
}

struct RealSurface {
  const char* file;
  Eigen::Index vertices, triangles;
};

TEST(RealFiles, surfaces_have_the_counts_documented) {
  PALPATE_NEEDS_DATA("data/surfaces");
  for (const RealSurface& real :
       {RealSurface{"sofa_liver.vtk", 5008, 10000},
        RealSurface{"sofa_liver-smooth.obj", 2194, 4384},
        RealSurface{"sofa_liver2.obj", 1170, 2336},
        RealSurface{"odedstein_hand_closed.obj", 7993, 15982},
        RealSurface{"cgal_elephant-with-holes.off", 2798, 4463},
        RealSurface{"sofa_c_open.obj", 430, 880}, RealSurface{"sofa_dragon.obj", 1190, 2564}}) {
    const Surface surface = read_surface(shared("surfaces") / real.file, 1e-3);
    EXPECT_EQ(surface.vertices.rows(), real.vertices) << real.file;
    EXPECT_EQ(surface.triangles.rows(), real.triangles) << real.file;
  }
}

// As 3D Slicer writes it.
TEST_F(MeshFiles, say_their_frame_where_a_format_can_state_one) {
  const std::array<std::string, 3> files[] = {
      {".stl", "3D Slicer output. SPACE=RAS" + std::string(53 + 4, '\0'), "RAS"},
      {".stl", "solid 3D Slicer output. SPACE=LPS\nfacet", "LPS"},
      {".obj", "# 3D Slicer output. SPACE=LPS\nv 0 0 0\n", "LPS"},
      {".ply", "ply\nformat ascii 1.0\ncomment 3D Slicer output. SPACE=RAS\n", "RAS"},
      {".vtk", "# vtk DataFile Version 4.2\n3D Slicer output. SPACE=LPS\nASCII\n", "LPS"},
      {".off", "OFF\n0 0 0\n", ""}};
  for (const auto& [extension, bytes, frame] : files)
    EXPECT_EQ(stated_frame(write({"mesh", extension, bytes})), frame) << bytes;
}

TEST(RealFiles, the_liver_of_1477_cubic_centimetres_points_inward) {
  PALPATE_NEEDS_DATA("data/surfaces");
  EXPECT_NEAR(volume_m3(read_surface(shared("surfaces/sofa_liver.vtk"), 1e-3)), -1.477e-3, 1e-6);
}

TEST(RealFiles, tet_meshes_have_the_counts_documented) {
  PALPATE_NEEDS_DATA("data/tets");
  TetReadNotes notes;
  const TetMesh bunny = read_tet_mesh(shared("tets/polyfem_bunny.msh"), 1, &notes);
  EXPECT_EQ(bunny.nodes.rows(), 4670);
  EXPECT_EQ(bunny.tets.rows(), 19379);
  EXPECT_EQ(notes.flipped_tets, 0u);
  const TetMesh liver = read_tet_mesh(shared("tets/sofa_liver2.msh"), 1, &notes);
  EXPECT_EQ(liver.tets.rows(), 1493);
  EXPECT_EQ(liver.nodes.rows() + static_cast<Eigen::Index>(notes.dropped_nodes), 507);
  EXPECT_GT(tet_volume_m3(liver), 0);
}

}  // namespace
}  // namespace palpate
