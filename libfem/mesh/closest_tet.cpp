#include "libfem/mesh/closest_tet.hpp"

#include <Eigen/LU>
#include <array>

#include "libfit/core/closest_point.hpp"

namespace palpate {

VolumePoint nearest_in_tet(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c,
                           const Vec3& d) {
  Mat3 edges;
  edges << b - a, c - a, d - a;
  const Vec3 inside = edges.inverse() * (p - a);
  VolumePoint point;
  if (inside.allFinite() && inside.minCoeff() >= 0 && inside.sum() <= 1) {
    point.weight << 1 - inside.sum(), inside;
    point.distance_m = 0;
    return point;
  }
  constexpr int kFaces[4][3] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  const std::array<Vec3, 4> corner{a, b, c, d};
  for (const auto& face : kFaces) {
    const SurfacePoint on_face =
        nearest_on_triangle(p, corner[face[0]], corner[face[1]], corner[face[2]]);
    if (on_face.distance_m >= point.distance_m) continue;
    point.distance_m = on_face.distance_m;
    point.weight.setZero();
    for (int k = 0; k < 3; ++k) point.weight[face[k]] = on_face.weight[k];
  }
  return point;
}

BoxTree tet_boxes(const TetMesh& volume) {
  Points lower(volume.tets.rows(), 3), upper(volume.tets.rows(), 3);
  for (Eigen::Index t = 0; t < volume.tets.rows(); ++t) {
    lower.row(t) = upper.row(t) = volume.nodes.row(volume.tets(t, 0));
    for (int k = 1; k < 4; ++k) {
      lower.row(t) = lower.row(t).cwiseMin(volume.nodes.row(volume.tets(t, k)));
      upper.row(t) = upper.row(t).cwiseMax(volume.nodes.row(volume.tets(t, k)));
    }
  }
  return {lower, upper};
}

}  // namespace palpate
