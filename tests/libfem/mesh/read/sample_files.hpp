#pragma once

#include <filesystem>
#include <ostream>
#include <string>
#include <vector>

#include "libfem/mesh/read/read.hpp"
#include "libfit/core/error.hpp"
#include "libfit/core/geometry.hpp"

namespace palpate::mesh_read_test {

/// The bytes of a small mesh file. extension with its dot; sibling: bytes of TetGen's other half.
struct SampleFile {
  std::string name;
  std::string extension;
  std::string bytes;
  std::string sibling_extension = {};
  std::string sibling = {};

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

/// The formats that a reader of meshes lists when it is given a file of none.
template <class Read>
std::string known_formats(Read&& read) {
  try {
    read("mesh.unknown");
  } catch (const Error& error) {
    return error.remedy();
  }
  return "";
}
inline std::string surface_formats() {
  return known_formats([](const char* path) { read_surface(path, 1); });
}
inline std::string tet_mesh_formats() {
  return known_formats([](const char* path) { read_tet_mesh(path, 1); });
}

/// An empty folder of its own, removed with the object.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  /// Writes the sample as "mesh" + extension (and its sibling) and returns the path.
  std::filesystem::path write(const SampleFile& sample) const;
  std::filesystem::path write(const std::string& name, const std::string& bytes) const;

 private:
  std::filesystem::path path_;
};

}  // namespace palpate::mesh_read_test
