#pragma once

#include <optional>
#include <vector>

#include "libfem/mesh/closest_tet.hpp"
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

}  // namespace palpate
