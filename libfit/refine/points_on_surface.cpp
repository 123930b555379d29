#include "libfit/refine/points_on_surface.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <functional>
#include <iterator>
#include <limits>
#include <numeric>
#include <queue>
#include <set>
#include <tuple>
#include <utility>

#include "libfit/core/closest_point.hpp"

namespace palpate {
namespace {

using Corners = std::array<std::int32_t, 3>;

// Corners in the same cyclic order, smallest index first, so that each triangle has one spelling.
Corners canonical(Corners corners) {
  std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
  return corners;
}

bool faces_along(const Corners& c, const Points& position, const Points& inward) {
  const Vec3 origin = position.row(c[0]);
  const Vec3 normal =
      (position.row(c[1]).transpose() - origin).cross(position.row(c[2]).transpose() - origin);
  return std::ranges::all_of(
      c, [&](std::int32_t point) { return faces_alike(normal, -inward.row(point)); });
}

constexpr double kAtCorner = 1e-9;  // of the longest edge: a vertex this near a test point is at it

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
// With evenly spread points every reachable vertex is within one spacing of a test point, so the
// longest edge of the triangle covers the rim, too.
SurfacePoint project(const Vec3& position, const Vec3& outward,
                     const std::vector<std::int32_t>& candidates, const FittedCurves& curves,
                     const Triangles& triangles) {
  SurfacePoint best;
  for (const std::int32_t t : candidates) {
    const auto [corner, longest_m] = BlendTriangle(curves, triangles, t);
    SurfacePoint point = nearest_on_triangle(position, corner[0], corner[1], corner[2]);
    if (point.distance_m < best.distance_m && point.distance_m <= longest_m &&
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

Neighbours::Neighbours(const Triangles& triangles, Eigen::Index vertices)
    : NumberLists(triangles, vertices, 2,
                  [&](int t, int k, int i) { return triangles(t, (k + 1 + i) % 3); }) {
  auto kept = number_.begin();  // an edge of two triangles is there twice
  for (std::size_t v = 0; v + 1 < first_.size(); ++v) {
    const auto begin = number_.begin() + first_[v], end = number_.begin() + first_[v + 1];
    std::sort(begin, end);
    first_[v] = kept - number_.begin();
    kept = std::copy(begin, std::unique(begin, end), kept);
  }
  first_.back() = kept - number_.begin();
  number_.erase(kept, number_.end());
}

NearestSource nearest_source(const Surface& surface, const std::vector<EdgePathSeeds>& sources) {
  using Item = std::tuple<double, std::int32_t, std::int32_t>;  // distance, source, vertex
  const Neighbours neighbours(surface.triangles, surface.vertices.rows());
  const std::size_t vertices = surface.vertices.rows();
  NearestSource found{std::vector<std::int32_t>(vertices, -1),
                      std::vector<double>(vertices, std::numeric_limits<double>::infinity())};
  std::priority_queue<Item, std::vector<Item>, std::greater<>> front;
  const auto reach = [&](double distance_m, std::int32_t source, std::int32_t vertex) {
    if (std::pair(distance_m, source) >= std::pair(found.distance_m[vertex], found.source[vertex]))
      return;
    found.distance_m[vertex] = distance_m;
    found.source[vertex] = source;
    front.emplace(distance_m, source, vertex);
  };
  for (std::size_t s = 0; s < sources.size(); ++s)
    for (const auto& seed : sources[s]) reach(seed.distance_m, s, seed.vertex);
  while (!front.empty()) {
    const auto [distance_m, source, vertex] = front.top();
    front.pop();
    if (std::pair(distance_m, source) != std::pair(found.distance_m[vertex], found.source[vertex]))
      continue;
    for (const std::int32_t to : neighbours.of(vertex)) {
      const double length_m = (surface.vertices.row(to) - surface.vertices.row(vertex)).norm();
      reach(distance_m + length_m, source, to);
    }
  }
  return found;
}

std::vector<EdgePathSeeds> place_on_surface(const Points& position, const Points& inward,
                                            const Surface& surface, const Points& outward_normal,
                                            double min_cosine, double max_m) {
  const BoxTree boxes = triangle_boxes(surface);
  std::vector<EdgePathSeeds> seeds(position.rows());
  for (Eigen::Index i = 0; i < position.rows(); ++i) {
    const Vec3 outward = -inward.row(i);
    const auto is_alike = [&](const SurfacePoint& point) {
      return faces_alike(
          blended(outward_normal, surface.triangles.row(point.triangle), point.weight), outward,
          min_cosine);
    };
    const auto hit = closest_point(surface, boxes, position.row(i), max_m, is_alike);
    if (!hit) continue;
    for (int k = 0; k < 3; ++k) {
      const std::int32_t vertex = surface.triangles(hit->triangle, k);
      seeds[i].push_back({vertex, (surface.vertices.row(vertex) - position.row(i)).norm()});
    }
  }
  return seeds;
}

Triangles triangulate_over(const Surface& surface, const std::vector<std::int32_t>& cell,
                           const Points& position, const Points& inward) {
  std::set<Corners> found;
  for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t) {
    Corners corners;
    for (int k = 0; k < 3; ++k) corners[k] = cell[surface.triangles(t, k)];
    const bool joins_three = corners[0] >= 0 && corners[1] >= 0 && corners[2] >= 0 &&
                             corners[0] != corners[1] && corners[1] != corners[2] &&
                             corners[2] != corners[0];
    if (joins_three && faces_along(corners, position, inward)) found.insert(canonical(corners));
  }
  Triangles triangles(found.size(), 3);
  Eigen::Index row = 0;
  for (const Corners& corners : found) triangles.row(row++) << corners[0], corners[1], corners[2];
  return triangles;
}

Triangles match_triangles(const Points& position, const TestPoints& points, double size_m) {
  const Triangles none(0, 3);
  if (position.rows() != points.position.rows()) return none;
  const double tolerance_m = 1e-6 * size_m;  // far above rounding, far below spacing
  std::vector<std::int32_t> by_x(position.rows());
  std::iota(by_x.begin(), by_x.end(), 0);
  std::sort(by_x.begin(), by_x.end(),
            [&](auto a, auto b) { return position(a, 0) < position(b, 0); });
  std::vector<std::int32_t> row_of(by_x.size());
  std::vector<char> is_taken(by_x.size(), 0);
  for (Eigen::Index i = 0; i < points.position.rows(); ++i) {
    const auto wanted = points.position.row(i);
    auto at = std::lower_bound(by_x.begin(), by_x.end(), wanted[0] - tolerance_m,
                               [&](auto row, double x) { return position(row, 0) < x; });
    while (at != by_x.end() && position(*at, 0) <= wanted[0] + tolerance_m &&
           (is_taken[*at] != 0 || (position.row(*at) - wanted).norm() > tolerance_m))
      ++at;
    if (at == by_x.end() || position(*at, 0) > wanted[0] + tolerance_m) return none;
    is_taken[*at] = 1;
    row_of[i] = *at;
  }
  return points.triangles.unaryExpr([&](std::int32_t point) { return row_of[point]; });
}

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
    // A place that is near through the air only (the next sheet, a bank of a gap) is farther along
    // the surface. Two edges leave room for detours along mesh edges (sqrt 2 on a regular grid).
    if (is_wanted[v] == 0 || point < 0 || nearest.distance_m[v] > 2 * longest_m[point]) continue;
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
