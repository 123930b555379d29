#include "libfem/mesh/tets.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <tuple>
#include <utility>

#include "libfit/core/closest_point.hpp"
#include "libfit/core/error.hpp"

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

}  // namespace palpate

namespace palpate::fem {

std::vector<TetFace> sorted_faces(const Eigen::Ref<const Tets>& tets) {
  std::vector<TetFace> faces;
  faces.reserve(4 * tets.rows());
  for (std::int32_t t = 0; t < tets.rows(); ++t)
    for (int f = 0; f < 4; ++f) {
      TetFace face{{}, {t, f}, true};
      for (int k = 0; k < 3; ++k) face.sorted[k] = tets(t, kTetFace[f][k]);
      for (const int k : {0, 1, 0}) {
        if (face.sorted[k] <= face.sorted[k + 1]) continue;
        std::swap(face.sorted[k], face.sorted[k + 1]);
        face.is_even = !face.is_even;
      }
      faces.push_back(face);
    }
  std::ranges::sort(faces, {}, [](const TetFace& face) {
    return std::tuple(face.sorted, face.of.tet, face.of.face);
  });
  return faces;
}

std::vector<BoundaryFace> boundary_faces(const Tets& tets) {
  std::vector<BoundaryFace> faces;
  for_each_face(sorted_faces(tets), [&](auto begin, auto end) {
    if (end - begin > 2)
      throw Error("tet mesh",
                  "tet " + std::to_string(begin->of.tet) + " has a face that " +
                      std::to_string(end - begin) + " tets share",
                  "Repair the mesh: a face joins two tets at most.");
    if (end - begin == 1) faces.push_back(begin->of);
  });
  std::ranges::sort(faces, {}, [](const BoundaryFace& f) { return std::pair(f.tet, f.face); });
  return faces;
}

Triangles boundary_triangles(const Tets& tets) {
  const auto faces = boundary_faces(tets);
  Triangles triangles(faces.size(), 3);
  for (std::size_t f = 0; f < faces.size(); ++f)
    for (int k = 0; k < 3; ++k) triangles(f, k) = tets(faces[f].tet, kTetFace[faces[f].face][k]);
  return triangles;
}

}  // namespace palpate::fem
