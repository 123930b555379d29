// Inputs as strangers have them: each is read, or refused with its reason. A row that names a
// repository repeats an input of its issue.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <random>
#include <regex>
#include <string>
#include <vector>

#include "tests/tools/block_scene.hpp"
#include "tests/tools/odd_presses.hpp"

namespace palpate::tools {
namespace {

using namespace testing_support;

enum Status { kRead = 0, kRefused = 1, kNoVerdict = 3 };

struct OddInput {
  const char* what;
  std::string file, content;
  Status status;
  const char* answer;     ///< pattern in the output
  std::string keys = {};  ///< added to a manifest; of a scene, in place of `content`
};

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
    text.replace(at, from.size(), to);
  return text;
}

// Runs the command of each row in the folder, which then holds the row's file.
template <class Command>
void expect_answers(const Folder& folder, const std::vector<OddInput>& inputs, Command&& command) {
  for (const OddInput& input : inputs) {
    SCOPED_TRACE(input.what);
    folder.write(input.file, input.content);
    const Outcome outcome = palpate(folder, command(input));
    EXPECT_EQ(outcome.status, input.status) << outcome.out << outcome.err;
    EXPECT_TRUE(std::regex_search(outcome.out + outcome.err, std::regex(input.answer)))
        << outcome.out << outcome.err << "is not: " << input.answer;
  }
}

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
      {"CR line ends", "a.obj", replaced(obj, "\n", "\r"), kRead, kBlock},
      {"decimal commas", "a.obj",
       replaced(vertices("v {:.1f} {:.1f} {:.1f}"), ".", ",") + faces(f, 1), kRefused,
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
       replaced(replaced(text_stl("{} {} {}"), "vertex", "VERTEX"), "solid", "SOLID"), kRead,
       kBlock},
      {"decimal commas", "a.stl", replaced(text_stl("{:.2f} {:.2f} {:.2f}"), ".", ","), kRefused,
       "a.stl:4: '[0-9]+,00' is not a number"},
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
           faces(three + " 300" + replaced(std::string(300, 'x'), "x", " 0")),
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
       replaced(msh("2 1 1"), "1 4 2 1 1 1 2 7 32", "1 5 2 1 1 1 2 7 6 26 27 32 31"), kRefused,
       "volume elements that are not tetrahedra: hexahedron"},
      {"cut in the middle", "a.msh", msh("2 1 1").substr(0, 4000), kRefused,
       "the file ends too early"},
  };
}

TEST(OddInputs, meshes_are_read_or_refused_with_the_reason) {
  const Folder folder;
  expect_answers(folder, odd_meshes(), [&](const OddInput& input) {
    std::string scene = replaced(kScene, "block.off", input.file);
    if (input.file == "a.msh") {
      scene = replaced(replaced(scene, "surface =", "tetmesh ="), "mesh_size = \"20 mm\"\n", "");
      scene = replaced(replaced(scene, "\"20 mm\"", "\"15 mm\""), "\"60 mm\"", "\"65 mm\"");
    }
    folder.write("scene.toml", scene);
    return "prepare scene.toml -o body.h5";
  });
}

using Rows = std::vector<std::array<double, 3>>;

// Writes a line for each row: time {0}, depth {1}, force {2}, number {3}.
std::string lines(const std::string& header, const std::string& format,
                  const Rows& rows = press()) {
  std::string text = header + "\n";
  int number = 0;
  for (const auto& [t, d, f] : rows)
    text += fmt::format(fmt::runtime(format), t, d, f, ++number) + "\n";
  return text;
}

template <class Change>
Rows changed(Change&& change) {
  Rows rows = press();
  for (std::size_t i = 0; i < rows.size(); ++i) change(i, rows[i]);
  return rows;
}

std::string utf_16(const std::string& text) {
  std::string wide = "\xff\xfe";
  for (const char c : text) wide += {c, '\0'};
  return wide;
}

// Delays the force by some readings, or takes its mean over them.
Rows late_by(std::size_t readings, bool is_mean = false) {
  const Rows rows = press();
  return changed([&](std::size_t i, std::array<double, 3>& row) {
    if (is_mean) row[2] = 0;
    for (std::size_t k = is_mean ? 0 : readings; k < readings + !is_mean; ++k)
      row[2] = (is_mean ? row[2] : 0) +
               rows[i - std::min(i, k)][2] / static_cast<double>(is_mean ? readings : 1);
  });
}

constexpr const char* kHeader = "t_s,z_mm,F_N";
constexpr const char* kRow = "{0:.3f},{1:.5f},{2:.6f}";
constexpr const char* kPress =
    "press, 0\\.(19|20|21)\\d* N at (2\\.9|3)\\S* mm, contact (1\\.9[4-9]|2|2\\.0[0-5])\\S* \\+-.*"
    "(good|fair)";

std::vector<OddInput> odd_recordings() {
  const Rows pressed = press();
  const std::string plain = lines(kHeader, kRow);
  const auto of = [](const Rows& rows) { return lines(kHeader, kRow, rows); };
  const auto with = [&](auto&& change) { return of(changed(change)); };
  using Row = std::array<double, 3>;
  std::string nul = replaced(plain, "\n", std::string("\0\n", 2));
  return {
      {"sep= of a spreadsheet", "a.csv", "\xef\xbb\xbfsep=;\n" + replaced(plain, ",", ";"), kRead,
       kPress},
      {"UTF-16", "a.csv", utf_16(plain), kRead, kPress},
      {"a ball of 5 um for 5 mm", "a.csv", plain, kRead,
       "radii of its tip deep: is the unit of radius",
       "probe = { shape = \"sphere\", radius = \"5 um\" }\n"},
      {"row names of R without a header field, tidyverse/readr", "a.csv",
       lines("t_s z_mm F_N", "\"{3}\" {0:.3f} {1:.5f} {2:.6f}"), kRefused,
       "a.csv:1: the header names 3 columns, the rows have 4"},
      {"row numbers without a header field", "a.csv", lines("z_mm,F_N", "{3},{1:.5f},{2:.6f}"),
       kRefused, "the header names 2 columns, the rows have 3"},
      {"a comma for two things", "a.csv",
       "z_mm,F_N\n" + replaced(lines("", "{1:.4f},{2:.4f}").substr(1), ".", ","), kRefused,
       "the header names 2 columns, the rows have 4: a comma separates fields and is the decimal"},
      {"an index without a name, of pandas", "a.csv",
       lines(",t_s,z_mm,F_N", "{3},{0:.3f},{1:.5f},{2:.6f}"), kRead, kPress},
      {"commas that end rows", "a.csv", lines(kHeader, std::string(kRow) + ","), kRead, kPress},
      {"commas that begin rows", "a.csv", lines(kHeader, std::string(",") + kRow), kRefused,
       "the header names 3 columns, the rows have 4"},
      {"notes behind some rows", "a.csv", replaced(plain, "\n3.0", ",note\n3.0"), kRead, kPress},
      {"two logs", "a.csv", plain + plain, kRefused,
       "a.csv:503: column `t_s`: `t_s` is not a number"},
      {"two logs, one header", "a.csv", plain + plain.substr(plain.find('\n') + 1), kRefused,
       "a.csv:503: time goes back"},
      {"a clock of 16 bits", "a.csv",
       lines("t_ms,z_mm,F_N", "{:.0f},{:.5f},{:.6f}",
             changed([](std::size_t, Row& r) { r[0] = std::fmod(63000 + 1000 * r[0], 65536); })),
       kRefused, "time goes back"},
      {"a clock of 0.1 s", "a.csv", lines(kHeader, "{:.1f},{:.5f},{:.6f}"), kRefused,
       "the time stamp repeats"},
      {"no force", "a.csv", with([](std::size_t, Row& r) { r[2] = 0; }), kRefused, "no contact"},
      {"a stuck force", "a.csv", with([](std::size_t, Row& r) { r[2] = std::min(r[2], 0.1); }),
       kRead, "fair: \\d+ of 40 rows are saturated"},
      {"the other sign", "a.csv", with([](std::size_t, Row& r) { r[2] *= -1; }), kRefused,
       "the sign of force or depth is reversed"},
      {"a tare left on", "a.csv", with([](std::size_t, Row& r) { r[2] += 1; }), kRead, kPress},
      {"a spike", "a.csv", with([](std::size_t i, Row& r) { r[2] += i == 100 ? 1000 : 0; }), kRead,
       "1 single readings stand out"},
      {"micrometres called mm", "a.csv", with([](std::size_t, Row& r) { r[1] *= 1000; }), kRefused,
       "which no soft body is made of: is a unit wrong\\?"},
      {"the way back alone", "a.csv", of({pressed.begin() + 250, pressed.end()}), kRefused,
       "the tip never goes in"},
      {"a force that copies the depth", "a.csv", with([](std::size_t, Row& r) { r[2] = r[1]; }),
       kRead, "poor: begins in contact"},
      {"a force 0.1 s late", "a.csv", of(late_by(10)), kRead,
       "fair: unloading returns 13\\d % of the work of loading.*force_delay = \"0\\.(1|09\\d*) "
       "s\""},
      {"a force 0.5 s late", "a.csv", of(late_by(50)), kRead,
       "poor: .*force_delay = \"0\\.(5|49) s\""},
      {"a force filtered over 0.5 s", "a.csv", of(late_by(50, true)), kRead,
       "poor: unloading returns.*force_delay"},
      {"units in cells", "a.csv", lines(kHeader, "{:.3f} s,{:.5f} mm,{:.6f} N"), kRefused,
       "column `t_s`: `0.000 s` is not a number"},
      {"exponents of Fortran", "a.csv", replaced(lines(kHeader, "{:.3f},{:.5e},{:.6f}"), "e", "D"),
       kRefused, "`0.00000D\\+00` is not a number"},
      {"hexadecimal", "a.csv", lines(kHeader, "{0:.3f},0x{3:x},{2:.6f}"), kRefused,
       "`0x1` is not a number"},
      {"inf", "a.csv", replaced(plain, lines("", kRow, {pressed[200]}).substr(1), "2.0,4.0,inf\n"),
       kRefused, "column `F_N`: `inf` is not a number"},
      {"a unit of the manifest that is not the header's", "a.csv", plain, kRefused,
       "column `F_N` is in N, the manifest says mN",
       "columns = { time = \"t_s\", depth = \"z_mm\", force = \"F_N\" }\nunits = { force = \"mN\" "
       "}"},
      {"one name twice", "a.csv", lines("t_s,z_mm,F_N,F_N", std::string(kRow) + ",9"), kRefused,
       "columns `F_N` and `F_N` may both be the force"},
      {"a row cut at the end", "a.csv", plain.substr(0, plain.size() - 12), kRefused,
       "a.csv:502: column `F_N` has no value here"},
      {"percent signs", "a.csv", "% made by x\n% " + plain, kRead, kPress, "comment = \"%\""},
      {"a spreadsheet by another name", "a.csv", std::string("PK\3\4", 4) + std::string(200, '\0'),
       kRefused, "is a zip file, which is not read"},
      {"no units", "a.csv", lines("t,z,F", kRow), kRefused, "column `t` has no unit",
       "columns = { time = \"t\", depth = \"z\", force = \"F\" }"},
      {"kN and m of a testing machine", "a.csv",
       lines("Time (s),Extension (m),Load (kN)", "{:.3f},{:.8f},{:.9f}",
             changed([](std::size_t, Row& r) { r[1] /= 1000, r[2] /= 1000; })),
       kRead, kPress, "columns = { time = \"Time\", depth = \"Extension\", force = \"Load\" }"},
      {"a typographic minus", "a.csv", replaced(plain, "-", "\xe2\x88\x92"), kRefused,
       "is not a number"},
      {"semicolons in the header alone", "a.csv", lines("t_s;z_mm;F_N", kRow), kRefused,
       "column `t_s`: `0.000,0.00000,"},
      {"blanks below tabs", "a.csv", lines("t_s\tz_mm\tF_N", "{:.3f}  {:.5f}  {:.6f}"), kRefused,
       "column `t_s`: `0.000  0.00000  "},
      {"blanks in quotes", "a.csv", lines(kHeader, "\" {:.3f} \",\" {:.5f} \",\" {:.6f} \""), kRead,
       kPress},
      {"rows twice", "a.csv", lines(kHeader, std::string(kRow) + "\n" + kRow), kRefused,
       "the time stamp repeats"},
      {"NUL bytes", "a.csv", nul, kRefused, "is binary data, not text"},
  };
}

TEST(OddInputs, recordings_are_read_or_refused_with_the_reason) {
  const Folder folder;
  expect_answers(folder, odd_recordings(), [&](const OddInput& input) {
    folder.write("m.toml", manifest(input.file, "", kPlaced + input.keys));
    return "check m.toml";
  });
}

// Each scene has `keys` in place of `content`.
std::vector<OddInput> odd_scenes() {
  return {
      {"blanks in a quantity", "s", "\"10 kPa\"", kRead, "wrote", "\"  10   kPa  \""},
      {"a unit in lower case", "s", "\"10 kPa\"", kRefused, "\"10 kpa\", which is not a pressure",
       "\"10 kpa\""},
      {"psi", "s", "\"10 kPa\"", kRefused, "\"1.5 psi\", which is not a pressure", "\"1.5 psi\""},
      {"a decimal comma", "s", "\"10 kPa\"", kRefused, "\"5,4 kPa\", which is not a pressure",
       "\"5,4 kPa\""},
      {"a typographic minus", "s", "at = \"1 mm\"", kRefused, "which is not a length",
       "at = \"\xe2\x88\x92"
       "1 mm\""},
      {"a fraction", "s", "\"8 mm\"", kRefused, "\"1/2 mm\", which is not a length", "\"1/2 mm\""},
      {"no blank before a unit", "s", "\"8 mm\"", kRead, "wrote", "\"8mm\""},
      {"more than a number holds", "s", "\"8 mm\"", kRefused, "which is not a length",
       "\"1e400 mm\""},
      {"nan", "s", "\"8 mm\"", kRefused, "which is not a length", "\"nan mm\""},
      {"a friction of 30 %", "s", "friction = 0.3", kRead,
       "a friction of 30 is more than any tool has", "friction = 30"},
      {"a negative friction", "s", "friction = 0.3", kRefused, "friction of \\[probe\\] is -0.3",
       "friction = -0.3"},
      {"a friction as text", "s", "friction = 0.3", kRefused, "is a text, not a number",
       "friction = \"0.3\""},
      {"an angle without a unit", "s", "radius = \"8 mm\"", kRefused,
       "half_angle of \\[probe\\] is 60", "shape = \"cone\"\nhalf_angle = 60"},
      {"a key twice", "s", "poisson = 0.45", kRefused, "cannot redefine",
       "poisson = 0.45\npoisson = 0.3"},
      {"CR and LF", "s", "\n", kRead, "wrote", "\r\n"},
      {"corners swapped", "s",
       "[\"20 mm\", \"20 mm\", \"29 mm\"], [\"60 mm\", \"60 mm\", \"31 mm\"]", kRefused,
       "box of region of \\[experiments\\] is empty",
       "[\"60 mm\", \"60 mm\", \"31 mm\"], [\"20 mm\", \"20 mm\", \"29 mm\"]"},
      {"no held-out points", "s", "points = 2\n", kRefused, "points of \\[validate\\] is 0",
       "points = 0\n"},
      {"a tolerance of 2 %", "s", "tolerance = 0.02", kRefused, "tolerance of \\[fit\\] is 2",
       "tolerance = 2"},
      {"inches", "s", "length_unit = \"mm\"", kRefused, "surface: 2.03 x 2.03 x 0.762 m",
       "length_unit = \"in\""},
  };
}

TEST(OddInputs, scenes_are_read_or_refused_with_the_reason) {
  const Folder folder;
  folder.write("block.off", block_off(8));
  expect_answers(folder, odd_scenes(), [&](const OddInput& input) {
    EXPECT_TRUE(holds(kScene, input.content));
    folder.write("scene.toml", replaced(kScene, input.content, input.keys));
    return "prepare scene.toml -o body.h5";
  });
}

std::vector<OddInput> odd_paths(const std::string& first, const std::string& second) {
  const std::string header = "t_s,x_m,y_m,z_m", turned = header + ",qx,qy,qz,qw\n";
  return {
      {"time that goes back", "p.csv", header + "\n1," + first + "\n0," + second + "\n", kRefused,
       "p.csv:3: column `t_s` does not increase"},
      {"columns in mm", "p.csv", "t_s,x_mm,y_mm,z_mm\n0," + first + "\n", kRefused,
       "column `x_mm` is not `x_m`"},
      {"NaN", "p.csv", header + "\n0,nan,0,0\n", kRefused, "column `x_m`: `nan` is not finite"},
      {"a quaternion of zeros", "p.csv", turned + "0," + first + ",0,0,0,0\n", kRefused,
       "has the length 0"},
      {"a quaternion of length 2", "p.csv", turned + "0," + first + ",0,0,0,2\n", kRefused,
       "has the length 2"},
      {"a quaternion cut short", "p.csv", header + ",qx,qy,qz\n0," + first + ",0,0,0\n", kRefused,
       "has some of qx,qy,qz,qw but not all"},
      {"a path beside the body", "p.csv", header + "\n0,0,0,0.5\n1,0,0,0.4\n", kNoVerdict,
       "the path never touches the body"},
  };
}

TEST(OddInputs, paths_are_read_or_refused_with_the_reason) {
  const Folder folder;
  const std::string golden =
      std::string(PALPATE_SOURCE_DIR) + "/tests/libfit/runtime/golden/rings.palp";
  expect_answers(folder, odd_paths("0,0,0", "0,0,0"),
                 [&](const OddInput&) { return "replay " + golden + " p.csv -o f.csv"; });
}

}  // namespace
}  // namespace palpate::tools
