#pragma once

#include <Eigen/Geometry>
#include <array>

#include "libfit/core/geometry.hpp"

namespace palpate {

/// Corners of a tetrahedron [m], in the order of `Tets`.
using TetCorners = std::array<Vec3, 4>;

TetCorners corners_of(const TetMesh& mesh, Eigen::Index tet);

/// Six times the signed volume [m^3].
inline double six_volumes(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  return (b - a).cross(c - a).dot(d - a);
}

/// Signed volume [m^3]; positive in the order of `Tets`.
double tet_volume_m3(const TetCorners& corner);

/// Smallest of the six angles between faces [deg]; 70.5 in a regular tetrahedron, 0 when flat.
double min_dihedral_deg(const TetCorners& corner);

/// A mesh's worst elements. A tet below kSliverDeg is a sliver.
inline constexpr double kSliverDeg = 5;
struct TetQuality {
  double min_dihedral_deg = 0;
  double min_volume_m3 = 0;
  int slivers = 0;
  double volume_m3 = 0;
};
/// All zero for a mesh without tets.
TetQuality quality_of(const TetMesh& mesh);

}  // namespace palpate
