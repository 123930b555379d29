// What is refused, by name, and what the error says; what is settled without a word to the user.
#include <gtest/gtest.h>

#include <algorithm>

#include "libfem/mesh/read/read.hpp"
#include "tests/libfem/mesh/read/sample_files.hpp"
#include "tests/support/error_of.hpp"
#include "tests/support/text.hpp"

namespace palpate {
namespace {

using namespace mesh_read_test;
using testing_support::error_of;
using testing_support::holds;

class Refusal : public MeshFiles {
 protected:
  std::string surface_error(const std::string& name, const std::string& bytes, double unit_m = 1) {
    return error_of([&] { read_surface(write(name, bytes), unit_m); });
  }
  std::string tet_error(const std::string& name, const std::string& bytes) {
    return error_of([&] { read_tet_mesh(write(name, bytes), 1); });
  }
};

const std::string kTriangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

TEST_F(Refusal, unknown_extension_lists_the_known_ones) {
  const std::string text = surface_error("mesh.step", "ISO-10303-21;");
  for (const char* known : {".obj", ".stl", ".ply", ".off", ".vtk"})
    EXPECT_TRUE(holds(text, known));
  const std::string tets = tet_error("mesh.obj", kTriangle);
  for (const char* known : {".msh", ".vtk"}) EXPECT_TRUE(holds(tets, known));
}

// It was "no mesh format that is known here", with a list that lacks it.
TEST_F(Refusal, a_format_of_the_other_kind_of_mesh_says_the_key_that_reads_it) {
  EXPECT_TRUE(
      holds(surface_error("mesh.msh", "$NOD\n"), "tetrahedra, which are read as body.tetmesh"));
  EXPECT_TRUE(holds(tet_error("mesh.stl", "solid\n"), "surfaces, which are read as body.surface"));
}

TEST_F(Refusal, a_compressed_file_is_named_by_its_format_whatever_its_name) {
  const std::pair<std::string, const char*> kFiles[] = {{"\x1f\x8b\x08", "gzip"},
                                                        {"PK\x03\x04", "zip"},
                                                        {"BZh91AY", "bzip2"},
                                                        {"\xfd"
                                                         "7zXZ",
                                                         "xz"},
                                                        {"\x28\xb5\x2f\xfd", "zstd"}};
  for (const auto& [bytes, format] : kFiles)
    EXPECT_TRUE(holds(surface_error("mesh.off", bytes), "is compressed (" + std::string(format)));
}

TEST_F(Refusal, missing_file_folder_and_empty_file_are_told_apart) {
  EXPECT_TRUE(holds(error_of([] { read_surface("/nowhere/mesh.obj", 1); }), "no such file"));
  const auto path = write("empty.obj", "");
  EXPECT_TRUE(holds(error_of([&] { read_surface(path, 1); }), "empty"));
  std::filesystem::create_directory(path.parent_path() / "folder.obj");
  EXPECT_TRUE(holds(error_of([&] { read_surface(path.parent_path() / "folder.obj", 1); }),
                    "is not a file"));
}

TEST_F(Refusal, binary_errors_name_the_byte) {
  for (SampleFile sample : surface_samples())
    if (sample.name == "stl_binary" || sample.name == "ply_binary_big_endian") {
      sample.bytes.pop_back();
      EXPECT_TRUE(holds(surface_error("mesh" + sample.extension, sample.bytes),
                        sample.name == "stl_binary" ? "mesh.stl" : ": byte "));
    }
}

// Of MSH 1.
std::string msh(const std::string& nodes, const std::string& elements) {
  const auto section = [](const std::string& name, const std::string& lines) {
    const auto count = std::to_string(std::ranges::count(lines, '\n'));
    return "$" + name + "\n" + count + "\n" + lines + "$END" + name + "\n";
  };
  return section("NOD", nodes) + section("ELM", elements);
}

struct BadFile {
  const char *claim, *name;
  std::string bytes;
  const char* says;
};

const std::string kCommaOff = "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1,5 0\n3 0 1 2\n";
const BadFile kBadFiles[] = {
    {"no faces", "mesh.obj", kTriangle, "no faces (3 vertices)"},
    {"no tets", "mesh.msh", msh("1 0 0 0\n", "1 15 0 0 1 1\n"), "no tetrahedra (1 points"},
    {"its line", "mesh.obj", kTriangle + "f 1 2 x\n", "mesh.obj:4: "},
    {"its line", "mesh.obj", "v 0 0 0\r\nv 1,5 0 0\r\n", "mesh.obj:2: "},
    {"its line", "mesh.off", kCommaOff, "mesh.off:5: "},
    {"a comma", "mesh.off", kCommaOff, "point, not a comma"},
    {"vertex 4 of 3", "mesh.obj", kTriangle + "f 1 2 4\nf 1 2 3\n",
     "mesh.obj:4: a face uses vertex 4"},
    {"too far back", "mesh.obj", kTriangle + "f 1 2 -4\n", "counts back past"},
    {"vertex 0", "mesh.obj", kTriangle + "f 0 1 2\n", "not a vertex number"},
    {"vertex 3 of 0 to 2", "mesh.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n",
     "uses vertex 3"},
    {"node 2 of 1", "mesh.msh", msh("1 0 0 0\n", "7 4 0 0 4 1 2 3 4\n"), "element 7 uses node 2"},
    {"no number", "mesh.obj", "v 0 0 nan\n", "NaN"},
    {"infinite", "mesh.obj", "v 0 -inf 0\n", "infinite"},
    {"too small", "mesh.obj", "v 0 1e-300 0\n", "absurdly small"},
    {"too large", "mesh.obj", "v 0 1e300 0\n", "absurdly large"},
    {"more than its bytes", "mesh.off", "OFF\n2000000000 1 0\n0 0 0\n",
     "announces 2000000000 vertices"},
    {"more than an index", "mesh.off", "OFF\n99999999999999 1 0\n0 0 0\n", "2^31"},
    {"more than its bytes", "mesh.vtk",
     "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\nPOINTS 900000000 float\n0 0 0\n",
     "announces 900000000 points"},
    {"a flat tet", "mesh.msh", msh("1 0 0 0\n2 1 0 0\n3 0 1 0\n4 1 1 0\n", "42 4 0 0 4 1 2 3 4\n"),
     "without volume: 42"},
    {"a node twice", "mesh.msh", msh("1 0 0 0\n2 1 0 0\n3 0 1 0\n", "5 4 0 0 4 1 2 3 3\n"),
     "without volume: 5"},
    {"two tets over one face, the second one's tip pushed through it", "mesh.msh",
     msh("1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 .1 .1 .5\n",
         "8 4 0 0 4 1 2 3 4\n9 4 0 0 4 1 3 2 5\n"),
     "overlap their neighbours: 8, 9"},
    {"MSH 4.0", "mesh.msh", "$MeshFormat\n4 0 8\n$EndMeshFormat\n", "Save it as MSH 4.1 or 2.2"},
};

TEST_F(Refusal, of_a_bad_file_says_what_is_wrong_and_where) {
  for (const BadFile& bad : kBadFiles) {
    const std::string name = bad.name;
    const bool is_tets = name.ends_with(".msh");
    const std::string text = is_tets ? tet_error(name, bad.bytes) : surface_error(name, bad.bytes);
    EXPECT_TRUE(holds(text, bad.says)) << bad.claim;
  }
}

TEST_F(Refusal, of_a_length_unit_that_cannot_be_meant) {
  for (const auto& [unit_m, says] :
       {std::pair{1e7, "1000 km"}, {1e-12, "1 nm"}, {0., "length unit"}})
    EXPECT_TRUE(holds(surface_error("mesh.obj", kTriangle + "f 1 2 3\n", unit_m), says));
}

TEST_F(Refusal, surface_given_as_volume_and_volume_as_surface_say_where_they_belong) {
  for (const SampleFile& sample : tet_samples())
    if (sample.name == "vtk_text") {
      EXPECT_TRUE(holds(surface_error("mesh.vtk", sample.bytes), "body.tetmesh"));
    }
  for (const SampleFile& sample : surface_samples())
    if (sample.name == "vtk_text") {
      EXPECT_TRUE(holds(tet_error("mesh.vtk", sample.bytes), "body.surface"));
    }
}

class Settled : public MeshFiles {};
const std::string kFiveNodes = "1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 0 0 -1\n";

TEST_F(Settled, obj_polygons_are_fans_and_corners_may_count_back) {
  const auto path = write(
      "mesh.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1/1/1 2/2/1 \\\n 3//1 4\nf -4 -3 -2\n");
  const Surface surface = read_surface(path, 1);
  Triangles expected(3, 3);
  expected << 0, 1, 2, 0, 2, 3, 0, 1, 2;
  EXPECT_EQ(surface.triangles, expected);
}

TEST_F(Settled, obj_faces_may_come_before_their_vertices) {
  EXPECT_EQ(read_surface(write("mesh.obj", "f 1 2 3\n" + kTriangle), 1).triangles.rows(), 1);
}

TEST_F(Settled, stl_merges_zero_and_minus_zero_and_nothing_else) {
  const auto path = write("mesh.stl",
                          "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 "
                          "0\nvertex 0 1 0\nendloop\nendfacet\n"
                          "facet normal 0 0 1\nouter loop\nvertex -0 0 0\nvertex 0 1 "
                          "0\nvertex -1e-9 0 1\nendloop\nendfacet\n"
                          "facet normal 0 0 1\nouter loop\nvertex 1e-9 0 0\nvertex 0 1 "
                          "0\nvertex 0 0 1\nendloop\nendfacet\nendsolid\n");
  EXPECT_EQ(read_surface(path, 1).vertices.rows(), 6);
}

TEST_F(Settled, negative_tets_are_turned_and_unused_nodes_dropped_and_both_counted) {
  const auto path =
      write("mesh.msh", msh("9 5 5 5\n" + kFiveNodes, "1 4 0 0 4 1 3 2 4\n2 4 0 0 4 1 3 2 5\n"));
  TetReadNotes notes;
  const TetMesh mesh = read_tet_mesh(path, 1, &notes);
  EXPECT_EQ(notes.flipped_tets, 1u);
  EXPECT_EQ(notes.dropped_nodes, 1u);
  EXPECT_EQ(mesh.nodes.rows(), 5);
  EXPECT_EQ(mesh.tets.maxCoeff(), 4);
}

// It was refused as tangled: "tetrahedra overlap their neighbours: 1, 2, 7, 8".
TEST_F(Settled, a_tet_that_the_file_has_twice_is_dropped_and_named) {
  const auto path = write("mesh.msh", msh(kFiveNodes,
                                          "1 4 0 0 4 1 2 3 4\n2 4 0 0 4 1 3 2 5\n"
                                          "7 4 0 0 4 1 2 3 4\n8 4 0 0 4 2 1 3 5\n"));
  TetReadNotes notes;
  const TetMesh mesh = read_tet_mesh(path, 1, &notes);
  EXPECT_EQ(notes.duplicate_tets, "7, 8");
  EXPECT_EQ(notes.flipped_tets, 0u);
  EXPECT_EQ(mesh.tets.rows(), 2);
}

TEST_F(Settled, quadratic_tets_are_read_by_their_corners) {
  std::string nodes =
      "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n10\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n";
  for (int n = 5; n <= 10; ++n) nodes += std::to_string(n) + " 0.5 0.5 " + std::to_string(n) + "\n";
  const auto path =
      write("mesh.msh",
            nodes + "$EndNodes\n$Elements\n1\n1 11 2 1 1 1 2 3 4 5 6 7 8 9 10\n$EndElements\n");
  TetReadNotes notes;
  EXPECT_EQ(read_tet_mesh(path, 1, &notes).nodes.rows(), 4);
  EXPECT_EQ(notes.dropped_nodes, 6u);
}

}  // namespace
}  // namespace palpate
