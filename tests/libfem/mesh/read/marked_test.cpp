// Groups, colours and fields of mesh files as parts of space.

#include "libfem/mesh/read/read.hpp"

#include <gtest/gtest.h>

#include <random>

#include "libfit/core/error.hpp"
#include "tests/libfem/mesh/read/sample_files.hpp"

namespace palpate {
namespace {

using namespace mesh_read_test;

const Vec3 kTop(0.3, 0.4, 1), kBottom(0.3, 0.4, 0), kRim(0.3, 0, 1);

MeshMark group(const std::string& name) { return {MeshMark::By::group, name, 0}; }
MeshMark colour(const std::string& name) { return {MeshMark::By::colour, name, 0}; }
MeshMark field(const std::string& name, double equals) {
  return {MeshMark::By::field, name, equals};
}

class MarkedPart : public MeshFiles {
 protected:
  PaintedPart part(const std::string& extension, const std::string& bytes, const MeshMark& mark,
                   bool is_tets = false) {
    return read_marked_part(write("mesh" + extension, bytes), 1, is_tets, mark);
  }
  std::string remedy(const std::string& extension, const std::string& bytes, const MeshMark& mark,
                     bool is_tets = false) {
    try {
      part(extension, bytes, mark, is_tets);
    } catch (const Error& e) {
      return e.fact() + " | " + e.remedy();
    }
    return "read";
  }
  static void is_the_top(const PaintedPart& part) {
    EXPECT_TRUE(part.is_on_faces());
    EXPECT_TRUE(part.contains(kTop));
    EXPECT_TRUE(part.contains(kTop + Vec3(0, 0, 0.1)));  // off the mesh the nearest face decides
    EXPECT_TRUE(part.contains(kRim));                    // borders belong to it
    EXPECT_FALSE(part.contains(kRim - Vec3(0, 0, 0.01)));
    EXPECT_FALSE(part.contains(kBottom));
  }
};

const Surface kCube = cube_surface();

bool is_top(Eigen::Index f) {
  for (int k = 0; k < 3; ++k)
    if (kCube.vertices(kCube.triangles(f, k), 2) < 1) return false;
  return true;
}

std::string row_of(const auto& row, int base = 0) {
  std::string text;
  for (Eigen::Index k = 0; k < row.size(); ++k) {
    if constexpr (std::is_integral_v<std::decay_t<decltype(row[k])>>)
      text += std::to_string(row[k] + base) + " ";
    else
      text += std::to_string(row[k]) + " ";
  }
  return text;
}

TEST_F(MarkedPart, of_an_obj_is_a_group_an_object_or_a_material) {
  std::string text;
  for (const auto& p : kCube.vertices.rowwise()) text += "v " + row_of(p) + "\n";
  text += "o cube\nusemtl skin\n";
  for (Eigen::Index f = 0; f < 12; ++f) {
    text += is_top(f) ? "g upper flat\nusemtl red\n" : "g rest\nusemtl skin\n";
    text += "f " + row_of(kCube.triangles.row(f), 1) + "\n";
  }
  is_the_top(part(".obj", text, group("upper")));
  is_the_top(part(".obj", text, group("flat")));
  is_the_top(part(".obj", text, group("red")));
  EXPECT_TRUE(part(".obj", text, group("cube")).contains(kBottom));
  const std::string fact = remedy(".obj", text, group("uper"));
  EXPECT_TRUE(fact.starts_with("has no group \"uper\" | Its groups: ")) << fact;
  EXPECT_NE(fact.find("\"upper\" (2 faces)"), std::string::npos) << fact;
}

std::string ply(const std::string& vertex_properties, const std::string& face_properties,
                const auto& of_vertex, const auto& of_face) {
  std::string text =
      "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\n"
      "property float y\nproperty float z\n" +
      vertex_properties + "element face 12\nproperty list uchar int vertex_indices\n" +
      face_properties + "end_header\n";
  for (Eigen::Index v = 0; v < 8; ++v) text += row_of(kCube.vertices.row(v)) + of_vertex(v) + "\n";
  for (Eigen::Index f = 0; f < 12; ++f)
    text += "3 " + row_of(kCube.triangles.row(f)) + of_face(f) + "\n";
  return text;
}

TEST_F(MarkedPart, of_a_ply_has_the_colour_of_faces_or_of_vertices) {
  const std::string rgb = "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  const auto nothing = [](Eigen::Index) { return std::string(); };
  const std::string faces = ply("", rgb, nothing, [](Eigen::Index f) {
    return std::string(is_top(f) ? "255 0 16" : "9 9 9");
  });
  is_the_top(part(".ply", faces, colour("#ff0010")));
  EXPECT_EQ(remedy(".ply", faces, colour("#ff0000")),
            "has nothing of colour #ff0000 | Its colours: #090909 (10 faces), #ff0010 (2 faces).");
  const std::string shares = ply(
      "property float red\nproperty float green\nproperty float blue\n", "",
      [](Eigen::Index v) { return std::string(kCube.vertices(v, 2) > 0 ? "1 0 0.0627" : "0 0 0"); },
      nothing);
  const PaintedPart half = part(".ply", shares, colour("#ff0010"));
  EXPECT_TRUE(half.contains(kTop));
  EXPECT_TRUE(half.contains({0, 0.2, 0.6}));  // half of the way to vertices without
  EXPECT_FALSE(half.contains({0, 0.2, 0.4}));
  const std::string labels = ply("", "property int label\n", nothing,
                                 [](Eigen::Index f) { return std::string(is_top(f) ? "2" : "1"); });
  is_the_top(part(".ply", labels, field("label", 2)));
  EXPECT_EQ(remedy(".ply", labels, field("label", 3)),
            "field \"label\" equals 3 nowhere | Its values: 1, 2.");
  EXPECT_EQ(
      remedy(".ply", labels, field("lable", 2)),
      "has no field \"lable\" | Name a field of one number. Its fields: \"label\" (of cells).");
  EXPECT_EQ(remedy(".ply", labels, colour("#ff0000")),
            "has no colours | Save it as PLY with colours of its faces or vertices.");
}

TEST_F(MarkedPart, of_a_vtk_surface_is_where_a_field_of_cells_or_points_has_a_value) {
  std::string text = "# vtk DataFile Version 3.0\ncube\nASCII\nDATASET POLYDATA\nPOINTS 8 float\n";
  for (const auto& p : kCube.vertices.rowwise()) text += row_of(p) + "\n";
  text += "VERTICES 1 2\n1 0\nPOLYGONS 12 48\n";
  std::string cells, points;
  for (Eigen::Index f = 0; f < 12; ++f) {
    text += "3 " + row_of(kCube.triangles.row(f)) + "\n";
    cells += is_top(f) ? "7\n" : "0\n";
  }
  for (Eigen::Index v = 0; v < 8; ++v) points += kCube.vertices(v, 2) > 0 ? "1 " : "0 ";
  text +=
      "CELL_DATA 13\nSCALARS label int 1\nLOOKUP_TABLE default\n0\n" + cells + "NORMALS n float\n";
  for (int k = 0; k < 13; ++k) text += "0 0 1\n";
  text += "POINT_DATA 8\nFIELD FieldData 1\nheight 1 8 float\n" + points + "\n";
  is_the_top(part(".vtk", text, field("label", 7)));
  EXPECT_TRUE(part(".vtk", text, field("height", 1)).contains(kTop));
  const std::string vector = remedy(".vtk", text, field("n", 1));
  EXPECT_TRUE(vector.starts_with("field \"n\" has 39 numbers for 13 cells")) << vector;
}

// Tets that hold a place decide within the volume, the nearest ones outside it.
TEST_F(MarkedPart, of_tets_is_where_one_of_the_nearest_tets_is_marked) {
  const PaintedPart lump = part(".msh", marked_msh(2.2, false), group("lump"), true);
  const TetMesh& cube = lump.volume();
  std::mt19937 random(3);
  std::uniform_int_distribution<int> eighths(-2, 10);
  std::uniform_real_distribution<double> anywhere(-0.25, 1.25);
  for (int i = 0; i < 4000; ++i) {
    const auto along = [&] { return i % 2 == 0 ? eighths(random) / 8.0 : anywhere(random); };
    const Vec3 place(along(), along(), along());
    double nearest[2] = {1, 1};
    for (Eigen::Index t = 0; t < cube.tets.rows(); ++t) {
      const auto corner = [&](int k) -> Vec3 { return cube.nodes.row(cube.tets(t, k)); };
      double& least = nearest[lump.is_painted()[static_cast<std::size_t>(4 * t)] != 0];
      least = std::min(
          least, nearest_in_tet(place, corner(0), corner(1), corner(2), corner(3)).distance_m);
    }
    EXPECT_EQ(lump.contains(place), nearest[1] <= nearest[0] + 1e-9) << place.transpose();
  }
}

TEST_F(MarkedPart, of_an_msh_is_a_physical_group_of_faces_or_of_tets) {
  const TetMesh cube = cube_tets();
  const auto middle_of = [&](Eigen::Index t) {
    Vec3 sum = Vec3::Zero();
    for (int k = 0; k < 4; ++k) sum += cube.nodes.row(cube.tets(t, k)).transpose() / 4;
    return sum;
  };
  for (const double version : {2.2, 4.1})
    for (const bool is_binary : {false, true}) {
      SCOPED_TRACE(std::to_string(version) + (is_binary ? " binary" : " text"));
      const std::string bytes = marked_msh(version, is_binary);
      is_the_top(part(".msh", bytes, group("upper side"), true));
      const PaintedPart lump = part(".msh", bytes, group("lump"), true);
      EXPECT_FALSE(lump.is_on_faces());
      for (Eigen::Index t = 0; t < 6; ++t) EXPECT_EQ(lump.contains(middle_of(t)), t < 3) << t;
      const Vec3 outside = 3 * middle_of(1) - 2 * Vec3::Constant(0.5);
      EXPECT_EQ(lump.contains(outside),
                !part(".msh", bytes, group("body"), true).contains(outside));
      EXPECT_EQ(remedy(".msh", bytes, group("tumour"), true),
                "has no group \"tumour\" | Its groups: \"upper side\" (2 faces), \"lump\" (3 "
                "tetrahedra), \"body\" (3 tetrahedra).");
    }
}

TEST_F(MarkedPart, of_a_vtk_grid_is_tets_or_the_faces_among_them) {
  const TetMesh cube = cube_tets();
  std::string points, cells, types, label, level;
  int offset = 0;
  std::string offsets;
  for (const auto& p : cube.nodes.rowwise()) {
    points += row_of(p);
    level += p[2] > 0.5 ? "1 " : "0 ";
  }
  const Triangles faces = top_faces();
  for (const auto& face : faces.rowwise()) {
    cells += row_of(face);
    types += "5 ";
    offsets += std::to_string(offset += 3) + " ";
    label += "4 ";
  }
  for (Eigen::Index t = 0; t < 6; ++t) {
    cells += row_of(cube.tets.row(t));
    types += "10 ";
    offsets += std::to_string(offset += 4) + " ";
    label += t < 2 ? "2 " : "1 ";
  }
  const auto array = [](const char* name, const char* type, const std::string& numbers) {
    return std::string("<DataArray type=\"") + type + "\" Name=\"" + name + "\" format=\"ascii\">" +
           numbers + "</DataArray>";
  };
  const std::string text =
      "<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid><Piece NumberOfPoints=\"8\" "
      "NumberOfCells=\"8\"><PointData>" +
      array("level", "Float64", level) +
      "<DataArray type=\"String\" Name=\"words\" "
      "format=\"odd\"></DataArray></PointData><CellData>" +
      array("label", "Int32", label) + "</CellData><Points>" + array("p", "Float64", points) +
      "</Points><Cells>" + array("connectivity", "Int64", cells) +
      array("offsets", "Int64", offsets) + array("types", "UInt8", types) +
      "</Cells></Piece></UnstructuredGrid></VTKFile>";
  is_the_top(part(".vtu", text, field("label", 4), true));
  EXPECT_FALSE(part(".vtu", text, field("label", 2), true).is_on_faces());
  // No tet has all its points there: of the faces those that have are meant.
  EXPECT_TRUE(part(".vtu", text, field("level", 1), true).is_on_faces());
  EXPECT_TRUE(part(".vtu", text, field("level", 1), true).contains(kTop));
  EXPECT_FALSE(part(".vtu", text, field("level", 1), true).contains(kBottom));
}

// Labels are asked for only where a region names them, but are read as safely.
TEST_F(MarkedPart, of_damaged_files_is_refused_or_read) {
  const std::string whole = marked_msh(4.1, true), text = marked_msh(2.2, false);
  for (const std::string& bytes : {whole, text})
    for (std::size_t at = 0; at < bytes.size(); at += 7) {
      std::string cut = bytes.substr(0, at), flipped = bytes;
      flipped[at] = static_cast<char>(flipped[at] ^ 0x41);
      for (const std::string& bad : {cut, flipped}) {
        try {
          part(".msh", bad, group("lump"), true);
        } catch (const Error&) {
        }
      }
    }
}

}  // namespace
}  // namespace palpate
