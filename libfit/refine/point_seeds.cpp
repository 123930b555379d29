#include "libfit/refine/point_seeds.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "libfit/core/closest_point.hpp"

namespace palpate {
namespace {

using Corners = std::array<std::int32_t, 3>;

// The same cyclic order, smallest index first, so that each triangle has one spelling.
Corners canonical(Corners corners) {
  std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
  return corners;
}

bool faces_along(const Corners& c, const Points& position, const Points& inward,
                 double min_cosine) {
  const Vec3 origin = position.row(c[0]);
  const Vec3 normal =
      (position.row(c[1]).transpose() - origin).cross(position.row(c[2]).transpose() - origin);
  return std::all_of(c.begin(), c.end(), [&](std::int32_t point) {
    return -inward.row(point).dot(normal) > min_cosine * normal.norm();
  });
}

}  // namespace

std::vector<EdgePathSeeds> place_on_surface(const Points& position, const Points& inward,
                                            const Surface& surface, const Points& outward_normal,
                                            double largest_angle_rad, double max_m) {
  const BoxTree boxes = triangle_boxes(surface);
  const double min_cosine = std::cos(largest_angle_rad);
  std::vector<EdgePathSeeds> seeds(static_cast<std::size_t>(position.rows()));
  for (Eigen::Index i = 0; i < position.rows(); ++i) {
    const Vec3 outward = -inward.row(i);
    const auto faces_alike = [&](const SurfacePoint& point) {
      Vec3 normal = Vec3::Zero();
      for (int k = 0; k < 3; ++k)
        normal +=
            point.weight[k] * outward_normal.row(surface.triangles(point.triangle, k)).transpose();
      return normal.dot(outward) > min_cosine * normal.norm();
    };
    const auto hit = closest_point(surface, boxes, position.row(i), max_m, faces_alike);
    if (!hit) continue;
    for (int k = 0; k < 3; ++k) {
      const std::int32_t vertex = surface.triangles(hit->triangle, k);
      seeds[static_cast<std::size_t>(i)].push_back(
          {vertex, (surface.vertices.row(vertex) - position.row(i)).norm()});
    }
  }
  return seeds;
}

Triangles triangulate_over(const Surface& surface, const std::vector<std::int32_t>& cell,
                           const Points& position, const Points& inward, double largest_angle_rad) {
  const double min_cosine = std::cos(largest_angle_rad);
  std::set<Corners> found;
  for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t) {
    Corners corners;
    for (std::size_t k = 0; k < 3; ++k)
      corners[k] = cell[static_cast<std::size_t>(surface.triangles(t, static_cast<int>(k)))];
    const bool joins_three = corners[0] >= 0 && corners[1] >= 0 && corners[2] >= 0 &&
                             corners[0] != corners[1] && corners[1] != corners[2] &&
                             corners[2] != corners[0];
    if (joins_three && faces_along(corners, position, inward, min_cosine))
      found.insert(canonical(corners));
  }
  Triangles triangles(static_cast<Eigen::Index>(found.size()), 3);
  Eigen::Index row = 0;
  for (const Corners& corners : found) triangles.row(row++) << corners[0], corners[1], corners[2];
  return triangles;
}

}  // namespace palpate
