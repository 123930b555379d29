#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "libfem/mesh/topology.hpp"
#include "libfit/core/closest_point.hpp"
#include "libfit/core/geometry.hpp"

namespace palpate {

/// The triangles of a surface mesh file, in m.
/// path: OBJ, STL, PLY, OFF or VTK (legacy POLYDATA), by extension; ASCII and binary.
/// length_unit_m: length of the file's unit [m] (meshes carry none), e.g. 1e-3 for millimetres.
/// Vertices and triangles keep the file's order; polygons become fans; STL corners identical to the
/// bit become one vertex. Nothing is mended here (see libfem/mesh/repair).
/// Safe on untrusted bytes: counts are checked against the file's size before memory is taken,
/// indices against the vertices, coordinates for NaN, infinity and absurd magnitude.
/// Throws Error, naming file and line or byte, when the extension is unknown, the file cannot be
/// read or parsed, has no triangle, or exceeds 2^31 - 1 vertices or triangles or 4 GiB.
Surface read_surface(const std::filesystem::path& path, double length_unit_m);

/// Changes that reading a tet mesh made.
struct TetReadNotes {
  std::string duplicate_tets;     ///< the file's numbers of tets that it has twice; empty: none
  std::size_t flipped_tets = 0;   ///< negative volume, two nodes exchanged
  std::size_t dropped_nodes = 0;  ///< used by no tet
};

/// The tetrahedra of a volume mesh file, in m.
/// path: MSH (1, 2.x, 4.1) or VTK (legacy UNSTRUCTURED_GRID), by extension; ASCII and binary.
/// Quadratic tets are read by their corners.
/// Nodes that no tet uses and second copies of a tet are dropped (Gmsh's MSH 2 has a copy for each
/// physical group); tets of negative volume are turned if all neighbours then
/// lie on opposite sides of their shared faces. `region` stays empty: a file's tags name no
/// material. Safe on untrusted bytes, as read_surface. Throws Error as read_surface does, and when
/// tets have no volume (less than 1e-12 of the longest edge cubed), overlap their neighbours, or
/// share the file with volume elements that are not tets.
TetMesh read_tet_mesh(const std::filesystem::path& path, double length_unit_m,
                      TetReadNotes* notes = nullptr);

/// True where the extension is one of tetrahedra alone.
bool is_volume_format(const std::filesystem::path& path);

/// A group of faces (dimension 2) or tetrahedra (3) that a mesh file marks.
struct MeshGroup {
  std::string name;
  int dimension = 2;
  std::size_t cells = 0;
};
/// The groups of a file of tetrahedra, in its order. Limits and errors as read_tet_mesh.
std::vector<MeshGroup> groups_of_tet_mesh(const std::filesystem::path& path);

/// The anatomical frame that a mesh file states for its coordinates, LPS (x to the left, y to the
/// back, z to the head) or RAS (x to the right, y to the front); empty where it states none.
/// 3D Slicer writes `SPACE=LPS` into the header of STL, into the title of legacy VTK and into
/// comments of OBJ and PLY.
/// Throws Error when the file cannot be read.
std::string stated_frame(const std::filesystem::path& mesh_file);

/// A part of a mesh that is painted on it, as a part of space: a place is in it where the nearest
/// place of the mesh is painted. So it means the same on any other mesh of the body. Borders
/// belong to it.
class PaintedPart {
 public:
  /// is_painted: of each triangle.
  PaintedPart(Surface surface, std::vector<char> is_painted);
  /// is_painted: of each tet.
  PaintedPart(TetMesh volume, std::vector<char> is_painted);

  bool contains(const Vec3& place) const;

  /// Painted on triangles: it has places of a boundary only, and what lies below them is not meant.
  bool is_on_faces() const { return surface_.triangles.rows() > 0; }

  const Surface& surface() const { return surface_; }
  const TetMesh& volume() const { return volume_; }
  const std::vector<char>& is_painted() const { return is_painted_; }

 private:
  Surface surface_;  // one of both has cells
  TetMesh volume_;
  std::vector<char> is_painted_;
  BoxTree boxes_;
  double slack_m_ = 0;  // by which a place on a border may miss it
};

/// The mesh of a file in m, and its part in a group (MSH physical group, OBJ `g`, `o` or `usemtl`):
/// triangles of a surface; of a file of tets those that are in it, else the boundary triangles.
/// Formats, limits and safety as read_surface and read_tet_mesh. Throws Error also where the file
/// has no such group, and lists those that it has, or the group has no face or tet.
PaintedPart read_group(const std::filesystem::path& path, double length_unit_m, bool is_tets,
                       const std::string& group);

}  // namespace palpate
