#include "libfem/mesh/tet_quality.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace palpate {

TetCorners corners_of(const TetMesh& mesh, Eigen::Index tet) {
  TetCorners corner;
  for (int k = 0; k < 4; ++k) corner[k] = mesh.nodes.row(mesh.tets(tet, k));
  return corner;
}

double tet_volume_m3(const TetCorners& c) { return six_volumes(c[0], c[1], c[2], c[3]) / 6; }

double min_dihedral_deg(const TetCorners& c) {
  // Outward normals of the faces opposite each corner; the angle is pi minus that between normals.
  const Vec3 normal[4] = {
      (c[3] - c[1]).cross(c[2] - c[1]).normalized(), (c[2] - c[0]).cross(c[3] - c[0]).normalized(),
      (c[3] - c[0]).cross(c[1] - c[0]).normalized(), (c[1] - c[0]).cross(c[2] - c[0]).normalized()};
  double largest_cosine = -1;
  for (int i = 0; i < 4; ++i)
    for (int k = i + 1; k < 4; ++k)
      largest_cosine = std::max(largest_cosine, -normal[i].dot(normal[k]));
  return std::acos(std::min(largest_cosine, 1.0)) * 180 / std::numbers::pi;
}

TetQuality quality_of(const TetMesh& mesh) {
  if (mesh.tets.rows() == 0) return {};
  TetQuality quality{180, std::numeric_limits<double>::infinity(), 0, 0};
  for (Eigen::Index t = 0; t < mesh.tets.rows(); ++t) {
    const TetCorners corner = corners_of(mesh, t);
    const double angle = min_dihedral_deg(corner), volume_m3 = tet_volume_m3(corner);
    quality.min_dihedral_deg = std::min(quality.min_dihedral_deg, angle);
    quality.min_volume_m3 = std::min(quality.min_volume_m3, volume_m3);
    quality.slivers += angle < kSliverDeg;
    quality.volume_m3 += volume_m3;
  }
  return quality;
}

}  // namespace palpate
