#include "libfit/refine/blend.hpp"

#include <algorithm>
#include <iterator>

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

// A triangle of test points.
struct BlendTriangle {
  Vec3 corner[3];
  double longest_m = 0;

  BlendTriangle(const FittedCurves& curves, const Triangles& triangles, std::int32_t t) {
    for (int k = 0; k < 3; ++k) corner[k] = curves.position.row(triangles(t, k));
    for (int k = 0; k < 3; ++k)
      longest_m = std::max(longest_m, (corner[(k + 1) % 3] - corner[k]).norm());
  }
};

// Triangles that hold the test point or a neighbour of it, ascending: one of them is nearest to a
// vertex whose nearest test point this is, unless the triangulation is far from Delaunay.
Lists triangles_around(const Triangles& triangles, std::size_t points) {
  const TrianglesAt at(triangles, points);
  Lists around(points);
  for (std::size_t p = 0; p < points; ++p) {
    std::vector<std::int32_t>& found = around[p];
    for (const std::int32_t t : at.of(p))
      for (int k = 0; k < 3; ++k)
        std::ranges::copy(at.of(triangles(t, k)), std::back_inserter(found));
    std::ranges::sort(found);
    found.erase(std::unique(found.begin(), found.end()), found.end());
  }
  return around;
}

// Nearest of the candidate triangles that face alike and are near enough; the lowest among equals.
SurfacePoint project(const Vec3& position, const Vec3& outward,
                     const std::vector<std::int32_t>& candidates, const FittedCurves& curves,
                     const Triangles& triangles) {
  SurfacePoint best;
  for (const std::int32_t t : candidates) {
    const auto [corner, longest_m] = BlendTriangle(curves, triangles, t);
    SurfacePoint point = nearest_on_triangle(position, corner[0], corner[1], corner[2]);
    if (point.distance_m < best.distance_m &&
        point.distance_m <= kLargestDistanceEdges * longest_m &&
        faces_alike(blended(curves.normal, triangles.row(t), point.weight), -outward)) {
      point.triangle = t;
      best = point;
    }
  }
  return best;
}

// Exactly (1,0,0) and the like for a vertex that is a test point.
Vec3 snapped(const BlendTriangle& triangle, const Vec3& position, const Vec3& weight) {
  for (int k = 0; k < 3; ++k)
    if ((triangle.corner[k] - position).norm() <= kAtCorner * triangle.longest_m)
      return Vec3::Unit(k);
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
  const Lists around = triangles_around(triangles, seeds.size());
  std::vector<EdgePathSeeds> sources(seeds.size());
  std::vector<double> longest_m(seeds.size());  // edge of a point's triangles
  for (std::int32_t t = 0; t < triangles.rows(); ++t)
    for (int k = 0; k < 3; ++k) {
      double& longest = longest_m[triangles(t, k)];
      longest = std::max(longest, BlendTriangle(curves, triangles, t).longest_m);
    }
  for (std::size_t p = 0; p < seeds.size(); ++p)
    if (!around[p].empty()) sources[p] = seeds[p];
  const NearestSource nearest = nearest_source(fine, sources);

  Blend blend{Triangles::Zero(fine.vertices.rows(), 3), Points::Zero(fine.vertices.rows(), 3), 0};
  for (Eigen::Index v = 0; v < fine.vertices.rows(); ++v) {
    const std::int32_t point = nearest.source[v];
    if (is_wanted[v] == 0 || point < 0 ||
        nearest.distance_m[v] > kLargestPathEdges * longest_m[point])
      continue;
    const Vec3 position = fine.vertices.row(v);
    const SurfacePoint hit =
        project(position, outward_normal.row(v), around[point], curves, triangles);
    if (hit.triangle < 0) continue;
    const auto corners = triangles.row(hit.triangle);
    const auto usable = [&](int k) { return is_usable[corners[k]] != 0; };
    blend.point.row(v) = corners;
    blend.weight.row(v) = without_unusable(
        snapped(BlendTriangle(curves, triangles, hit.triangle), position, hit.weight),
        {usable(0), usable(1), usable(2)});
    if (blend.weight.row(v).sum() > 0)
      blend.largest_projection_m = std::max(blend.largest_projection_m, hit.distance_m);
  }
  return blend;
}

Blend blend_by_cell(const std::vector<std::int32_t>& cell, const std::vector<char>& is_wanted) {
  const Eigen::Index vertices = cell.size();
  Blend blend{Triangles::Zero(vertices, 3), Points::Zero(vertices, 3), 0};
  for (Eigen::Index v = 0; v < vertices; ++v) {
    if (is_wanted[v] == 0 || cell[v] < 0) continue;
    blend.point.row(v).setConstant(cell[v]);
    blend.weight(v, 0) = 1;
  }
  return blend;
}

}  // namespace palpate
