#include "libfem/mesh/topology.hpp"

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

std::vector<std::int32_t> renumber(std::span<std::int32_t> corners, std::size_t count,
                                   Numbering numbering) {
  std::vector<std::int32_t> number(count, -1), used;
  const auto take = [&](std::int32_t v) {
    if (number[v] >= 0) return;
    number[v] = static_cast<std::int32_t>(used.size());
    used.push_back(v);
  };
  if (numbering == Numbering::ascending) {
    used.assign(corners.begin(), corners.end());
    sort_unique(used);
    for (std::size_t i = 0; i < used.size(); ++i) number[used[i]] = static_cast<std::int32_t>(i);
  }
  for (std::int32_t& v : corners) {
    take(v);
    v = number[v];
  }
  return used;
}

std::vector<TriangleSide> sorted_sides(const Eigen::Ref<const Triangles>& triangles) {
  std::vector<TriangleSide> sides;
  sides.reserve(triangles.size());
  for (std::int32_t f = 0; f < triangles.rows(); ++f)
    for (std::int8_t k = 0; k < 3; ++k) {
      const std::int32_t from = triangles(f, k), to = triangles(f, (k + 1) % 3);
      sides.push_back({std::min(from, to), std::max(from, to), f, k, from < to});
    }
  std::ranges::sort(sides, [](const TriangleSide& a, const TriangleSide& b) {
    return std::tie(a.low, a.high, a.face, a.corner) < std::tie(b.low, b.high, b.face, b.corner);
  });
  return sides;
}

Components components(const Eigen::Ref<const Triangles>& triangles) {
  DisjointSets sets(triangles.rows());
  for_each_edge(sorted_sides(triangles), [&](auto begin, auto end) {
    for (auto side = begin + 1; side < end; ++side) sets.join(begin->face, side->face);
  });
  Components result{std::vector<std::size_t>(triangles.rows()), 0};
  for (std::size_t f = 0; f < result.of_face.size(); ++f) {
    const std::size_t first = sets.find(f);
    result.of_face[f] = first == f ? result.number++ : result.of_face[first];
  }
  return result;
}

// The corners are looked up: triangles may have been turned since their sides were listed.
std::vector<char> faces_of_lumens(const Points& vertices,
                                  const Eigen::Ref<const Triangles>& triangles) {
  const Components parts = components(triangles);
  std::vector<double> volume(parts.number, 0.0);
  const Vec3 first = vertices.rows() > 0 ? Vec3(vertices.row(0)) : Vec3::Zero();
  const auto at = [&](std::int32_t v) { return Vec3(vertices.row(v).transpose() - first); };
  for (Eigen::Index f = 0; f < triangles.rows(); ++f)
    volume[parts.of_face[f]] +=
        at(triangles(f, 0)).dot(at(triangles(f, 1)).cross(at(triangles(f, 2))));
  std::vector<char> out(triangles.rows());
  for (std::size_t f = 0; f < out.size(); ++f) out[f] = volume[parts.of_face[f]] < 0;
  return out;
}

void join_fans(const Eigen::Ref<const Triangles>& triangles, const TriangleSide& a,
               const TriangleSide& b, DisjointSets& corners) {
  const auto corner_at = [&](std::int32_t f, std::int32_t vertex) {
    return 3 * f + (triangles(f, 0) == vertex ? 0 : triangles(f, 1) == vertex ? 1 : 2);
  };
  for (const std::int32_t vertex : {a.low, a.high})
    corners.join(corner_at(a.face, vertex), corner_at(b.face, vertex));
}

DisjointSets corner_fans(const Eigen::Ref<const Triangles>& triangles) {
  DisjointSets corners(triangles.size());
  for_each_edge(sorted_sides(triangles), [&](auto begin, auto end) {
    for (auto side = begin + 1; side < end; ++side) join_fans(triangles, *begin, *side, corners);
  });
  return corners;
}

std::vector<std::int32_t> pinched_vertices(const Eigen::Ref<const Triangles>& triangles,
                                           std::size_t count) {
  DisjointSets fan_of = corner_fans(triangles);
  std::vector<int> fans(count, 0);
  for (std::size_t c = 0; c < 3 * std::size_t(triangles.rows()); ++c)
    fans[triangles(c / 3, c % 3)] += fan_of.find(c) == c;
  std::vector<std::int32_t> pinched;
  for (std::size_t v = 0; v < count; ++v)
    if (fans[v] > 1) pinched.push_back(v);
  return pinched;
}

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
