#include "libfit/refine/blend.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "libfit/core/closest_point.hpp"
#include "libfit/refine/points_on_surface.hpp"

namespace palpate {
namespace {

constexpr double kAtCorner = 1e-9;  // of the longest edge: a vertex this near a test point is at it

/// Of a vertex from its triangle, in longest edges of the triangle. With evenly spread points every
/// reachable vertex is within one spacing of a test point, so 1 covers the rim, too.
constexpr double kLargestDistanceEdges = 1;

/// Along the surface from a test point, in longest edges at that point: what is near through the
/// air only (the next sheet, the other bank of a gap) is farther. 2 leaves room for the detours of
/// paths along mesh edges (at most sqrt 2 on a regular grid).
constexpr double kLargestPathEdges = 2;

using Lists = std::vector<std::vector<std::int32_t>>;

// What projection needs to know of a test-point triangle.
struct BlendTriangle {
  Vec3 corner[3];
  Vec3 outward[3];
  double longest_m = 0;
};

std::vector<BlendTriangle> facets_of(const FittedCurves& curves, const Triangles& triangles) {
  std::vector<BlendTriangle> facets(static_cast<std::size_t>(triangles.rows()));
  for (std::size_t f = 0; f < facets.size(); ++f) {
    for (int k = 0; k < 3; ++k) {
      const std::int32_t point = triangles(static_cast<Eigen::Index>(f), k);
      facets[f].corner[k] = curves.position.row(point);
      facets[f].outward[k] = -curves.normal.row(point);
    }
    for (int k = 0; k < 3; ++k)
      facets[f].longest_m = std::max(facets[f].longest_m,
                                     (facets[f].corner[(k + 1) % 3] - facets[f].corner[k]).norm());
  }
  return facets;
}

// Triangles that hold the test point or a neighbour of it, ascending: one of them is nearest to a
// vertex whose nearest test point this is, unless the triangulation is far from Delaunay.
Lists triangles_around(const Triangles& triangles, std::size_t points) {
  Lists at(points), around(points);
  for (Eigen::Index t = 0; t < triangles.rows(); ++t)
    for (int k = 0; k < 3; ++k)
      at[static_cast<std::size_t>(triangles(t, k))].push_back(static_cast<std::int32_t>(t));
  for (std::size_t p = 0; p < points; ++p) {
    for (const std::int32_t t : at[p])
      for (int k = 0; k < 3; ++k) {
        const auto& more = at[static_cast<std::size_t>(triangles(t, k))];
        around[p].insert(around[p].end(), more.begin(), more.end());
      }
    std::sort(around[p].begin(), around[p].end());
    around[p].erase(std::unique(around[p].begin(), around[p].end()), around[p].end());
  }
  return around;
}

// How far along the surface each test point answers for vertices [m]; negative without triangle.
std::vector<double> ranges_of(const Triangles& triangles, const std::vector<BlendTriangle>& facets,
                              std::size_t points) {
  std::vector<double> ranges(points, -1);
  for (Eigen::Index t = 0; t < triangles.rows(); ++t)
    for (int k = 0; k < 3; ++k) {
      double& range = ranges[static_cast<std::size_t>(triangles(t, k))];
      range = std::max(range, kLargestPathEdges * facets[static_cast<std::size_t>(t)].longest_m);
    }
  return ranges;
}

bool faces_alike(const BlendTriangle& facet, const Vec3& weight, const Vec3& outward,
                 double min_cosine) {
  Vec3 normal = Vec3::Zero();
  for (int k = 0; k < 3; ++k) normal += weight[k] * facet.outward[k];
  return normal.dot(outward) > min_cosine * normal.norm();
}

// Nearest of the candidate triangles that face alike and are near enough; the lowest among equals.
SurfacePoint project(const Vec3& position, const Vec3& outward,
                     const std::vector<std::int32_t>& candidates,
                     const std::vector<BlendTriangle>& facets) {
  const double min_cosine = std::cos(kLargestAngle_rad);
  SurfacePoint best;
  for (const std::int32_t t : candidates) {
    const BlendTriangle& facet = facets[static_cast<std::size_t>(t)];
    SurfacePoint point =
        nearest_on_triangle(position, facet.corner[0], facet.corner[1], facet.corner[2]);
    if (point.distance_m < best.distance_m &&
        point.distance_m <= kLargestDistanceEdges * facet.longest_m &&
        faces_alike(facet, point.weight, outward, min_cosine)) {
      point.triangle = t;
      best = point;
    }
  }
  return best;
}

// Exactly (1,0,0) and the like for a vertex that is a test point.
Vec3 snapped(const BlendTriangle& facet, const Vec3& position, const Vec3& weight) {
  for (int k = 0; k < 3; ++k)
    if ((facet.corner[k] - position).norm() <= kAtCorner * facet.longest_m) return Vec3::Unit(k);
  return weight;
}

// Moves the weight of unusable corners to the others; zero when there is no other. On a corner
// that is itself unusable the others share alike.
Vec3 without_unusable(Vec3 weight, const bool (&is_usable)[3]) {
  if (is_usable[0] && is_usable[1] && is_usable[2]) return weight;
  Vec3 usable = Vec3::Zero();
  for (int k = 0; k < 3; ++k) usable[k] = is_usable[k] ? 1 : 0;
  if (usable.sum() == 0) return usable;
  weight = weight.cwiseProduct(usable);
  if (weight.sum() < kAtCorner) weight = usable;
  return weight / weight.sum();
}

}  // namespace

Blend blend_by_area(const FittedCurves& curves, const Surface& fine, const Points& outward_normal,
                    const std::vector<char>& is_wanted, const Triangles& triangles,
                    const std::vector<char>& is_usable, const std::vector<EdgePathSeeds>& seeds) {
  const auto facets = facets_of(curves, triangles);
  const Lists around = triangles_around(triangles, seeds.size());
  const auto ranges = ranges_of(triangles, facets, seeds.size());
  std::vector<EdgePathSeeds> sources(seeds.size());
  for (std::size_t p = 0; p < seeds.size(); ++p)
    if (!around[p].empty()) sources[p] = seeds[p];
  const NearestSource nearest = nearest_source(fine, sources);

  Blend blend{Triangles::Zero(fine.vertices.rows(), 3), Points::Zero(fine.vertices.rows(), 3), 0};
  for (Eigen::Index v = 0; v < fine.vertices.rows(); ++v) {
    const auto i = static_cast<std::size_t>(v);
    if (is_wanted[i] == 0 || nearest.source[i] < 0) continue;
    const auto point = static_cast<std::size_t>(nearest.source[i]);
    if (nearest.distance_m[i] > ranges[point]) continue;
    const Vec3 position = fine.vertices.row(v);
    const SurfacePoint hit = project(position, outward_normal.row(v), around[point], facets);
    if (hit.triangle < 0) continue;
    const auto corners = triangles.row(hit.triangle);
    const auto usable = [&](int k) { return is_usable[static_cast<std::size_t>(corners[k])] != 0; };
    blend.point.row(v) = corners;
    blend.weight.row(v) = without_unusable(
        snapped(facets[static_cast<std::size_t>(hit.triangle)], position, hit.weight),
        {usable(0), usable(1), usable(2)});
    if (blend.weight.row(v).sum() > 0)
      blend.largest_projection_m = std::max(blend.largest_projection_m, hit.distance_m);
  }
  return blend;
}

Blend blend_by_cell(const std::vector<std::int32_t>& cell, const std::vector<char>& is_wanted) {
  const auto vertices = static_cast<Eigen::Index>(cell.size());
  Blend blend{Triangles::Zero(vertices, 3), Points::Zero(vertices, 3), 0};
  for (Eigen::Index v = 0; v < vertices; ++v) {
    const auto i = static_cast<std::size_t>(v);
    if (is_wanted[i] == 0 || cell[i] < 0) continue;
    blend.point.row(v).setConstant(cell[i]);
    blend.weight(v, 0) = 1;
  }
  return blend;
}

}  // namespace palpate
