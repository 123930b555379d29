#include "libfit/refine/points_on_surface.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <numeric>
#include <set>
#include <vector>

#include "libfit/core/closest_point.hpp"

namespace palpate {
namespace {

using Corners = std::array<std::int32_t, 3>;

// The same cyclic order, smallest index first, so that each triangle has one spelling.
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

constexpr double kPositionTolerance = 1e-6;  // of the body: far above rounding, far below spacing

}  // namespace

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
  const double tolerance_m = kPositionTolerance * size_m;
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

}  // namespace palpate
