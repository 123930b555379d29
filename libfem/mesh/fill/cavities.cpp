#include "libfem/mesh/fill/cavities.hpp"

#include <Eigen/Geometry>
#include <map>
#include <numeric>
#include <vector>

#include "libfit/core/closest_point.hpp"

namespace palpate {
namespace {

/// Triangles of each connected piece.
std::vector<std::vector<Eigen::Index>> pieces_of(const Surface& surface) {
  std::vector<std::int32_t> parent(static_cast<std::size_t>(surface.vertices.rows()));
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](std::int32_t v) {
    while (parent[std::size_t(v)] != v)
      v = parent[std::size_t(v)] = parent[std::size_t(parent[std::size_t(v)])];
    return v;
  };
  for (const auto& t : surface.triangles.rowwise())
    for (int k = 1; k < 3; ++k) parent[std::size_t(root(t[k]))] = root(t[0]);
  std::map<std::int32_t, std::vector<Eigen::Index>> by_root;
  for (Eigen::Index f = 0; f < surface.triangles.rows(); ++f)
    by_root[root(surface.triangles(f, 0))].push_back(f);
  std::vector<std::vector<Eigen::Index>> pieces;
  for (auto& [vertex, triangles] : by_root) pieces.push_back(std::move(triangles));
  return pieces;
}

/// Half-way from the piece's largest triangle to what lies across the cavity.
Vec3 point_across(const Surface& piece, const Surface& closed, const BoxTree& boxes) {
  double largest = -1;
  Vec3 start = Vec3::Zero(), direction = Vec3::Zero();
  for (const auto& t : piece.triangles.rowwise()) {
    const Vec3 a = piece.vertices.row(t[0]), b = piece.vertices.row(t[1]),
               c = piece.vertices.row(t[2]);
    const Vec3 normal = (b - a).cross(c - a);
    if (normal.norm() <= largest) continue;
    largest = normal.norm();
    start = (a + b + c) / 3;
    direction = normal.normalized();  // out of the solid, into the cavity
  }
  const double skip = 1e-6 * extent_m(piece.vertices).norm();
  const auto across = ray_distance_m(closed, boxes, start, direction, skip);
  return start + 0.5 * across.value_or(2 * skip) * direction;
}

}  // namespace

Points cavity_points(const Surface& closed) {
  std::vector<Vec3> found;
  const auto pieces = pieces_of(closed);
  if (pieces.size() < 2) return Points(0, 3);
  const BoxTree boxes = triangle_boxes(closed);
  for (const auto& triangles : pieces) {
    Surface piece{closed.vertices, Triangles(static_cast<Eigen::Index>(triangles.size()), 3)};
    for (std::size_t i = 0; i < triangles.size(); ++i)
      piece.triangles.row(static_cast<Eigen::Index>(i)) = closed.triangles.row(triangles[i]);
    if (volume_m3(piece) < 0) found.push_back(point_across(piece, closed, boxes));
  }
  Points points(static_cast<Eigen::Index>(found.size()), 3);
  for (std::size_t i = 0; i < found.size(); ++i)
    points.row(static_cast<Eigen::Index>(i)) = found[i];
  return points;
}

}  // namespace palpate
