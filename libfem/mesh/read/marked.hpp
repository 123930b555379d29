#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "libfem/mesh/tets.hpp"
#include "libfit/core/box_tree.hpp"
#include "libfit/core/closest_point.hpp"
#include "libfit/core/geometry.hpp"

namespace palpate {

/// A part of a mesh that is painted on it, as a part of space: a place is in it where the nearest
/// place of the mesh is painted. So it means the same on any other mesh of the body. Borders
/// belong to it.
class PaintedPart {
 public:
  /// Painted triangles. is_painted: 3 to a triangle, of its corners; a place of a triangle is
  /// painted where painted corners weigh half of it or more.
  PaintedPart(Surface surface, std::vector<char> is_painted);
  /// Painted tets, 4 flags to a tet.
  PaintedPart(TetMesh volume, std::vector<char> is_painted);

  bool contains(const Vec3& place) const;

  /// Painted on triangles: it has places of a boundary only, and what lies below them is not meant.
  bool is_on_faces() const { return surface_.triangles.rows() > 0; }

  const Surface& surface() const { return surface_; }
  const TetMesh& volume() const { return volume_; }
  const std::vector<char>& is_painted() const { return is_painted_; }

 private:
  std::optional<bool> decided_by_holders(const Vec3& place) const;

  Surface surface_;  // one of both has cells
  TetMesh volume_;
  std::vector<char> is_painted_;
  BoxTree boxes_;
  double slack_m_ = 0;  // by which a place on a border may miss it
  // Only tets whose corners are painted alike have one; x . normal - offset is the depth below
  // each face [m].
  struct Interior {
    Eigen::Matrix<double, 4, 3> normal = Eigen::Matrix<double, 4, 3>::Zero();
    Eigen::Vector4d offset_m = Eigen::Vector4d::Zero();
  };
  std::vector<Interior> interiors_;
};

/// A part of a mesh by what its file says of it: a group (MSH physical group, OBJ `g`, `o` or
/// `usemtl`), a colour ("#ff0000", of the faces or vertices of a PLY), or the points or cells whose
/// field (VTK, VTU, VTP, PLY property) equals a number.
struct MeshMark {
  enum class By { group, colour, field };
  By by = By::group;
  std::string name;
  double equals = 0;  ///< of a field
};

/// The mesh of a file in m, and which part of it has the mark: triangles of a surface; of a file of
/// tets the tets that have it, else the boundary triangles.
/// Formats, limits and safety as read_surface and read_tet_mesh. Throws Error also where the file
/// has no such group, colour or field, and lists those that it has, or nothing has the mark.
PaintedPart read_marked_part(const std::filesystem::path& path, double length_unit_m, bool is_tets,
                             const MeshMark& mark);

}  // namespace palpate
