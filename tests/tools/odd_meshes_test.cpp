// Meshes as strangers have them: each is read, or refused with its reason. A row that names a
// repository repeats an input of its issue.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <string>
#include <vector>

#include "tests/tools/odd_inputs.hpp"

namespace palpate::tools {
namespace {

using Corner = std::array<double, 3>;
using Face = std::array<int, 3>;

// The block with one vertex where sides meet.
const BlockMesh& block() {
  static const BlockMesh made = [] {
    BlockMesh welded;
    std::map<Corner, int> known;
    const BlockMesh sides = block_mesh(8);
    for (Face face : sides.faces) {
      for (int& corner : face) {
        const Corner& at = sides.vertices[static_cast<std::size_t>(corner)];
        const auto [found, is_new] = known.emplace(at, static_cast<int>(welded.vertices.size()));
        if (is_new) welded.vertices.push_back(at);
        corner = found->second;
      }
      welded.faces.push_back(face);
    }
    return welded;
  }();
  return made;
}

// These write a line for each vertex (x, y, z) and for each face, whose corners count from `first`.
std::string vertices(const std::string& format) {
  std::string text;
  for (const auto& [x, y, z] : block().vertices)
    text += fmt::format(fmt::runtime(format), x, y, z) + "\n";
  return text;
}
std::string faces(const std::string& format, int first = 0) {
  std::string text;
  for (const auto& [a, b, c] : block().faces)
    text += fmt::format(fmt::runtime(format), a + first, b + first, c + first) + "\n";
  return text;
}

template <class T>
std::string bytes(T value, bool is_big_endian = false) {
  std::string text(sizeof value, '\0');
  std::memcpy(text.data(), &value, sizeof value);
  if (is_big_endian) std::reverse(text.begin(), text.end());
  return text;
}

std::string binary_stl(std::string head, std::uint16_t colour = 0, int more = 0) {
  head.resize(80);
  std::string text = head + bytes(static_cast<std::uint32_t>(block().faces.size() + more));
  for (const Face& face : block().faces) {
    text += std::string(12, '\0');
    for (const int corner : face)
      for (const double x : block().vertices[static_cast<std::size_t>(corner)])
        text += bytes(static_cast<float>(x));
    text += bytes(colour);
  }
  return text;
}

std::string text_stl(const std::string& number) {
  std::string text = "solid b\n";
  for (const Face& face : block().faces) {
    text += " facet normal 0 0 0\n  outer loop\n";
    for (const int corner : face) {
      const auto& [x, y, z] = block().vertices[static_cast<std::size_t>(corner)];
      text += fmt::format(fmt::runtime("   vertex " + number + "\n"), x, y, z);
    }
    text += "  endloop\n endfacet\n";
  }
  return text + "endsolid b\n";
}

std::string ply_head(const std::string& format, const std::string& after_vertices,
                     const std::string& list, const std::string& axes = "xyz") {
  std::string text = "ply\nformat " + format + " 1.0\nelement vertex 386\n";
  for (const char axis : axes) text += std::string("property float ") + axis + "\n";
  return text + after_vertices + (list.empty() ? "" : "element face 768\nproperty list " + list) +
         "end_header\n";
}

// Appends vertices and faces to the head; Count and Index are the types of the list of corners.
template <class Count, class Index>
std::string binary_ply(const std::string& head, bool is_big_endian,
                       const std::string& between = "") {
  std::string text = head;
  for (const Corner& vertex : block().vertices)
    for (const double x : vertex) text += bytes(static_cast<float>(x), is_big_endian);
  text += between;
  for (const Face& face : block().faces) {
    text += bytes(static_cast<Count>(3), is_big_endian);
    for (const int corner : face) text += bytes(static_cast<Index>(corner), is_big_endian);
  }
  return text;
}

std::string vtk(const std::string& version, const std::string& rest) {
  return "# vtk DataFile Version " + version +
         "\nmade\nASCII\nDATASET POLYDATA\nPOINTS 386 float\n" + vertices("{} {} {}") + rest;
}

std::string vtk_offsets() {
  std::string text = "POLYGONS 769 2304\nOFFSETS vtktypeint64\n";
  for (int i = 0; i <= 768; ++i) text += std::to_string(3 * i) + " ";
  return text + "\nCONNECTIVITY vtktypeint64\n" + faces("{} {} {}");
}

std::string off(const std::string& head, const std::string& vertex, const std::string& face,
                int first = 0) {
  return head + "386 768 0\n" + vertices(vertex) + faces(face, first);
}

// Divides 4 x 4 x 2 bricks into six tetrahedra each, whose volumes are negative where it flips.
std::string msh(const std::string& tags, bool flips = false) {
  std::string nodes, elements;
  const auto node = [](int i, int j, int k) { return (k * 5 + j) * 5 + i; };
  for (int k = 0; k <= 2; ++k)
    for (int j = 0; j <= 4; ++j)
      for (int i = 0; i <= 4; ++i)
        nodes += fmt::format("{} {} {} {}\n", node(i, j, k) + 1, 20 * i, 20 * j, 15 * k);
  int count = 0;
  constexpr int kSplit[6][4] = {{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7},
                                {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}};
  for (int brick = 0; brick < 32; ++brick)
    for (const auto& tet : kSplit) {
      elements += fmt::format("{} 4 {}", ++count, tags);
      for (int c = 0; c < 4; ++c) {
        const int q = tet[flips && c < 2 ? 1 - c : c];
        elements += fmt::format(" {}", 1 + node(brick % 4 + (q & 1), brick / 4 % 4 + (q >> 1 & 1),
                                                brick / 16 + (q >> 2)));
      }
      elements += "\n";
    }
  return "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n75\n" + nodes +
         "$EndNodes\n$Elements\n192\n" + elements + "$EndElements\n";
}

constexpr const char* kBlock = "surface: 80 x 80 x 30 mm, 0\\.192 l, 386 vertices, 768 triangles";
constexpr const char* kTets = "surface: 80 x 80 x 30 mm, 0\\.192 l, 66 vertices, 128 triangles";

std::vector<OddInput> odd_meshes() {
  const std::string v = "v {} {} {}", f = "f {} {} {}", plain = "{} {} {}", three = "3 {} {} {}",
                    uchar_int = "uchar int vertex_indices\n";
  std::string interleaved;
  for (const Face& face : block().faces) {
    for (const int corner : face) {
      const auto& [x, y, z] = block().vertices[static_cast<std::size_t>(corner)];
      interleaved += fmt::format("v {} {} {}\n", x, y, z);
    }
    interleaved += "f -3 -2 -1\n";
  }
  std::string not_a_number = binary_stl("made");
  not_a_number.replace(84 + 12, 4, bytes(NAN));
  const std::string camera = "element camera 1\nproperty float q\nproperty list uchar float p\n",
                    obj = vertices(v) + faces(f, 1);
  return {
      {"v and f interleaved, mikedh/trimesh#2364", "a.obj", interleaved, kRead, kBlock},
      {"colours behind v", "a.obj", vertices(v + " 0.5 0.1 0.1") + faces(f, 1), kRead, kBlock},
      {"indices from 0, tinyobjloader#140", "a.obj", vertices(v) + faces(f), kRefused,
       "a.obj:387: a face corner is not a vertex number \\(from 1"},
      {"w behind v", "a.obj", vertices(v + " 2") + faces(f, 1), kRead, kBlock},
      {"CR line ends", "a.obj", all_replaced(obj, "\n", "\r"), kRead, kBlock},
      {"decimal commas", "a.obj",
       all_replaced(vertices("v {:.1f} {:.1f} {:.1f}"), ".", ",") + faces(f, 1), kRefused,
       "a.obj:1: a vertex needs three numbers, with decimal points"},
      {"Latin-1", "a.obj", "o G\xe4lle\n" + obj, kRead, kBlock},
      {"solid before a binary STL, sreiter/stl_reader#3", "a.stl", binary_stl("solid exported"),
       kRead, kBlock},
      {"colours of a binary STL", "a.stl", binary_stl("made", 0x7fff), kRead, kBlock},
      {"fewer announced", "a.stl", binary_stl("made", 0, -200), kRefused,
       "a binary STL of 568 facets has 28484 bytes, this file has 38484"},
      {"none announced", "a.stl", binary_stl("made", 0, -768), kRefused, "STL of 0 facets"},
      {"more announced", "a.stl", binary_stl("made", 0, 5), kRefused, "STL of 773 facets"},
      {"upper case", "a.stl",
       all_replaced(all_replaced(text_stl("{} {} {}"), "vertex", "VERTEX"), "solid", "SOLID"),
       kRead, kBlock},
      {"decimal commas", "a.stl", all_replaced(text_stl("{:.2f} {:.2f} {:.2f}"), ".", ","),
       kRefused, "a.stl:4: '[0-9]+,00' is not a number"},
      {"NaN", "a.stl", not_a_number, kRefused, "byte 96: a coordinate is not a number"},
      {"an STL called OBJ", "a.obj", binary_stl("made"), kRefused, "the mesh has no faces"},
      {"an OBJ called STL", "a.stl", obj, kRefused, "a binary STL of \\d+ facets"},
      {"big endian, google/draco#1133", "a.ply",
       binary_ply<std::uint8_t, std::int32_t>(ply_head("binary_big_endian", "", uchar_int), true),
       kRead, kBlock},
      {"ushort and uint, cnr-isti-vclab/meshlab#290", "a.ply",
       binary_ply<std::uint16_t, std::uint32_t>(
           ply_head("binary_little_endian", "", "ushort uint vertex_indices\n"), false),
       kRead, kBlock},
      {"an element between, aras-p/UnityGaussianSplatting#212", "a.ply",
       binary_ply<std::uint8_t, std::int32_t>(ply_head("binary_little_endian", camera, uchar_int),
                                              false, bytes(1.f) + '\2' + bytes(3.f) + bytes(4.f)),
       kRead, kBlock},
      {"300 texture numbers, cnr-isti-vclab/meshlab#1126", "a.ply",
       ply_head("ascii", "", uchar_int + "property list ushort float t\n") + vertices(plain) +
           faces(three + " 300" + all_replaced(std::string(300, 'x'), "x", " 0")),
       kRead, kBlock},
      {"points alone", "a.ply", ply_head("ascii", "", "") + vertices(plain), kRefused,
       "the mesh has no faces \\(386 vertices\\)"},
      {"strips", "a.ply",
       ply_head("ascii", "element tristrips 1\nproperty list int int vertex_indices\n", "") +
           vertices(plain) + "5 0 1 2 3 -1\n",
       kRefused, "triangle strips are not supported"},
      {"axes z y x", "a.ply",
       ply_head("ascii", "", uchar_int, "zyx") + vertices("{2} {1} {0}") + faces(three), kRead,
       kBlock},
      {"OFFSETS, Kitware/vtk-js#2076", "a.vtk", vtk("5.1", vtk_offsets()), kRead, kBlock},
      {"METADATA", "a.vtk",
       vtk("4.2",
           "METADATA\nINFORMATION 1\nNAME L2_NORM_RANGE LOCATION vtkDataArray\nDATA 2 0 "
           "100\n\nPOLYGONS 768 3072\n" +
               faces(three)),
       kRead, kBlock},
      {"strips", "a.vtk", vtk("3.0", "TRIANGLE_STRIPS 768 3072\n" + faces(three)), kRead, kBlock},
      {"structured points, nschloe/meshio#1205", "a.vtk",
       "# vtk DataFile Version 5.1\nv\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 3 3 3\n",
       kRefused, "holds a 'STRUCTURED_POINTS', not POLYDATA"},
      {"counts beside the word", "a.off", off("OFF ", plain, three), kRead, kBlock},
      {"COFF", "a.off", off("COFF\n", plain + " 9 9 9 255", three), kRead, kBlock},
      {"comments and colours", "a.off",
       off("OFF # made\n# by\n", plain + " # v", three + " 0.1 0.2 0.3"), kRead, kBlock},
      {"indices from 1", "a.off", off("OFF\n", plain, three, 1), kRefused,
       "an element uses vertex 386 \\(counted from 0\\), but there are 386 vertices"},
      {"4OFF", "a.off", off("4OFF\n", plain + " 2", three), kRefused, "is not in three dimensions"},
      {"all triangles inward", "a.off", off("OFF\n", plain, "3 {0} {2} {1}"), kRead, "turned"},
      {"partitions, evalf/nutils#44", "a.msh", msh("4 1 1 1 -2"), kRead, kTets},
      {"no physical group, mfem/mfem#1061", "a.msh", msh("2 0 1"), kRead, kTets},
      {"negative volumes", "a.msh", msh("2 1 1", true), kRead, kTets},
      {"hexahedra", "a.msh",
       all_replaced(msh("2 1 1"), "1 4 2 1 1 1 2 7 32", "1 5 2 1 1 1 2 7 6 26 27 32 31"), kRefused,
       "volume elements that are not tetrahedra: hexahedron"},
      {"cut in the middle", "a.msh", msh("2 1 1").substr(0, 4000), kRefused,
       "the file ends too early"},
  };
}

TEST(OddInputs, meshes_are_read_or_refused_with_the_reason) {
  const Folder folder;
  expect_answers(folder, odd_meshes(), [&](const OddInput& input) {
    std::string scene = all_replaced(kScene, "block.off", input.file);
    if (input.file == "a.msh") {
      scene = all_replaced(all_replaced(scene, "surface =", "tetmesh ="), "mesh_size = \"20 mm\"\n",
                           "");
      scene = all_replaced(all_replaced(scene, "\"20 mm\"", "\"15 mm\""), "\"60 mm\"", "\"65 mm\"");
    }
    folder.write("scene.toml", scene);
    return "prepare scene.toml -o body.h5";
  });
}

}  // namespace
}  // namespace palpate::tools
