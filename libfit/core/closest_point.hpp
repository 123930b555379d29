#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "libfit/core/box_tree.hpp"
#include "libfit/core/geometry.hpp"

namespace palpate {

/// Parameter in [0, 1] of the point of segment a-b nearest to p; 0 where the segment is a point.
inline double nearest_on_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const double squared_length = (b - a).squaredNorm();
  return squared_length > 0 ? std::clamp((p - a).dot(b - a) / squared_length, 0.0, 1.0) : 0.0;
}

/// Barycentric weights of the point of triangle (a, b, c) nearest to p: >= 0, sum 1; exactly 0 for
/// corners that the point has no part of, so that a point on an edge or corner can be told from one
/// inside. Flat and point-like triangles count as their edges.
/// Source: Ericson, Real-Time Collision Detection (2005), 5.1.5.
Vec3 nearest_weights(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c);

/// The point of a surface (or of one triangle) nearest to a query. weight: barycentric, sum 1.
struct SurfacePoint {
  std::int32_t triangle = -1;
  Vec3 weight = Vec3::Zero();
  Vec3 position = Vec3::Zero();  ///< [m]
  double distance_m = std::numeric_limits<double>::infinity();
};

/// Nearest point of one triangle, whose number is left at -1.
inline SurfacePoint nearest_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b,
                                        const Vec3& c) {
  const Vec3 w = nearest_weights(p, a, b, c);
  const Vec3 position = w[0] * a + w[1] * b + w[2] * c;
  return {-1, w, position, (position - p).norm()};
}

/// Boxes of the triangles of a surface, for the queries below.
BoxTree triangle_boxes(const Surface& surface);

/// Nearest point among the triangles whose nearest point `accept(SurfacePoint)` takes, no farther
/// than max_m; of two as near, that of the lower triangle. Empty when there is none.
/// boxes: triangle_boxes(surface). Thread-safe, allocates nothing.
template <class Accept>
std::optional<SurfacePoint> closest_point(const Surface& surface, const BoxTree& boxes,
                                          const Vec3& query, double max_m, Accept&& accept) {
  std::optional<SurfacePoint> hit;
  double squared_best = max_m * max_m;
  boxes.visit_nearest(query, squared_best, [&](std::int32_t f, double& best) {
    const auto corner = surface.triangles.row(f);
    const Vec3 a = surface.vertices.row(corner[0]), b = surface.vertices.row(corner[1]),
               c = surface.vertices.row(corner[2]);
    SurfacePoint point;
    point.triangle = f;
    point.weight = nearest_weights(query, a, b, c);
    point.position = point.weight[0] * a + point.weight[1] * b + point.weight[2] * c;
    const double squared = (point.position - query).squaredNorm();
    const bool is_better = squared < best || (squared == best && (!hit || f < hit->triangle));
    if (!is_better) return;
    point.distance_m = std::sqrt(squared);
    if (!accept(static_cast<const SurfacePoint&>(point))) return;
    best = squared;
    hit = point;
  });
  return hit;
}

/// The same over all triangles.
inline std::optional<SurfacePoint> closest_point(
    const Surface& surface, const BoxTree& boxes, const Vec3& query,
    double max_m = std::numeric_limits<double>::infinity()) {
  return closest_point(surface, boxes, query, max_m, [](const SurfacePoint&) { return true; });
}

/// Distance [m] along `direction` (unit) from `origin` to a triangle, < 0 when it lies behind;
/// infinite when missed or edge-on. Source: Moeller and Trumbore 1997,
/// doi:10.1080/10867651.1997.10487468.
double ray_hit_m(const Vec3& origin, const Vec3& direction, const Vec3& a, const Vec3& b,
                 const Vec3& c);

/// Distance [m] along `direction` (unit) from `origin` to the first triangle met at skip_m or
/// beyond; empty when the ray leaves without meeting one.
std::optional<double> ray_distance_m(const Surface& surface, const BoxTree& boxes,
                                     const Vec3& origin, const Vec3& direction, double skip_m);

/// True if a place lies inside a closed surface: a ray crosses it an odd number of times.
bool is_inside(const Surface& closed, const BoxTree& boxes, const Vec3& place);

}  // namespace palpate
