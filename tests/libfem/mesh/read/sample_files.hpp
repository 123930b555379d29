#pragma once

#include <filesystem>
#include <ostream>
#include <string>
#include <vector>

#include "libfem/mesh/read/read.hpp"
#include "libfit/core/geometry.hpp"
#include "tests/libfit/io/scratch.hpp"
#include "tests/support/error_of.hpp"

namespace palpate::mesh_read_test {

/// The bytes of a small mesh file. extension with its dot.
struct SampleFile {
  std::string name;
  std::string extension;
  std::string bytes;

  /// How googletest shows it.
  friend std::ostream& operator<<(std::ostream& out, const SampleFile& sample) {
    return out << sample.name;
  }
};

/// The unit cube [0,1]^3 as 12 outward triangles, or 6 positive tets around a diagonal.
Surface cube_surface();
TetMesh cube_tets();

/// The cube in every format, version and encoding the readers know.
std::vector<SampleFile> surface_samples();
std::vector<SampleFile> tet_samples();

/// Faces of the cube's tets on its top, whose diagonals need not be those of cube_surface().
Triangles top_faces();

/// Of MSH: the six tets, the first three "lump" and the rest "body", and the top, "upper side".
std::string marked_msh(double version, bool is_binary);

/// The formats that a reader of meshes lists when it is given a file of none.
inline std::string surface_formats() {
  return testing_support::error_of([] { read_surface("mesh.unknown", 1); });
}
inline std::string tet_mesh_formats() {
  return testing_support::error_of([] { read_tet_mesh("mesh.unknown", 1); });
}

/// Has a folder of its own.
class MeshFiles : public testing_io::ScratchTest {
 protected:
  /// Writes the sample as "mesh" + extension and returns the path.
  std::filesystem::path write(const SampleFile& sample) const;
  std::filesystem::path write(const std::string& name, const std::string& bytes) const;
};

class OfSamples : public MeshFiles, public testing::WithParamInterface<SampleFile> {};
inline std::string sample_name(const testing::TestParamInfo<SampleFile>& info) {
  return info.param.name;
}

}  // namespace palpate::mesh_read_test
