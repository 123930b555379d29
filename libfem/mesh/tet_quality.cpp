#include "libfem/mesh/tet_quality.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace palpate {

TetCorners corners_of(const TetMesh& mesh, Eigen::Index tet) {
  TetCorners corner;
  for (int k = 0; k < 4; ++k)
    corner[static_cast<std::size_t>(k)] = mesh.nodes.row(mesh.tets(tet, k));
  return corner;
}

double tet_volume_m3(const TetCorners& c) {
  return (c[1] - c[0]).cross(c[2] - c[0]).dot(c[3] - c[0]) / 6;
}

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

double mean_ratio(const TetCorners& c) {
  double squared_edges = 0;
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t k = i + 1; k < 4; ++k) squared_edges += (c[k] - c[i]).squaredNorm();
  if (!(squared_edges > 0)) return 0;
  const double volume = tet_volume_m3(c), root = std::cbrt(3 * volume);
  return std::copysign(12 * root * root / squared_edges, volume);
}

TetQuality quality_of(const TetMesh& mesh) {
  if (mesh.tets.rows() == 0) return {};
  TetQuality quality{180, 1, 0, 0};
  for (Eigen::Index t = 0; t < mesh.tets.rows(); ++t) {
    const TetCorners corner = corners_of(mesh, t);
    const double angle = min_dihedral_deg(corner);
    quality.min_dihedral_deg = std::min(quality.min_dihedral_deg, angle);
    quality.worst_mean_ratio = std::min(quality.worst_mean_ratio, mean_ratio(corner));
    quality.slivers += angle < kSliverDeg;
    quality.volume_m3 += tet_volume_m3(corner);
  }
  return quality;
}

}  // namespace palpate
