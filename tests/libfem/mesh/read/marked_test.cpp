// Groups of mesh files as parts of space.

#include "libfem/mesh/read/read.hpp"

#include <gtest/gtest.h>

#include <random>

#include "libfit/core/error.hpp"
#include "tests/libfem/mesh/read/sample_files.hpp"

namespace palpate {
namespace {

using namespace mesh_read_test;

const Vec3 kTop(0.3, 0.4, 1), kBottom(0.3, 0.4, 0), kRim(0.3, 0, 1);

class MarkedPart : public MeshFiles {
 protected:
  PaintedPart part(const std::string& extension, const std::string& bytes, const std::string& group,
                   bool is_tets = false) {
    return read_group(write("mesh" + extension, bytes), 1, is_tets, group);
  }
  std::string remedy(const std::string& extension, const std::string& bytes,
                     const std::string& group, bool is_tets = false) {
    try {
      part(extension, bytes, group, is_tets);
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
  is_the_top(part(".obj", text, "upper"));
  is_the_top(part(".obj", text, "flat"));
  is_the_top(part(".obj", text, "red"));
  EXPECT_TRUE(part(".obj", text, "cube").contains(kBottom));
  const std::string fact = remedy(".obj", text, "uper");
  EXPECT_TRUE(fact.starts_with("has no group \"uper\" | Its groups: ")) << fact;
  EXPECT_NE(fact.find("\"upper\" (2 faces)"), std::string::npos) << fact;
}

// Tets that hold a place decide within the volume, the nearest ones outside it.
TEST_F(MarkedPart, of_tets_is_where_one_of_the_nearest_tets_is_marked) {
  const PaintedPart lump = part(".msh", marked_msh(2.2, false), "lump", true);
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
      double& least = nearest[lump.is_painted()[static_cast<std::size_t>(t)] != 0];
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
      is_the_top(part(".msh", bytes, "upper side", true));
      const PaintedPart lump = part(".msh", bytes, "lump", true);
      EXPECT_FALSE(lump.is_on_faces());
      for (Eigen::Index t = 0; t < 6; ++t) EXPECT_EQ(lump.contains(middle_of(t)), t < 3) << t;
      const Vec3 outside = 3 * middle_of(1) - 2 * Vec3::Constant(0.5);
      EXPECT_EQ(lump.contains(outside), !part(".msh", bytes, "body", true).contains(outside));
      EXPECT_EQ(remedy(".msh", bytes, "tumour", true),
                "has no group \"tumour\" | Its groups: \"upper side\" (2 faces), \"lump\" (3 "
                "tetrahedra), \"body\" (3 tetrahedra).");
    }
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
          part(".msh", bad, "lump", true);
        } catch (const Error&) {
        }
      }
    }
}

}  // namespace
}  // namespace palpate
