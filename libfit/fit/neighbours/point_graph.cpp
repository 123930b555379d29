#include "libfit/fit/neighbours/point_graph.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "libfit/core/box_tree.hpp"
#include "libfit/fit/spline/monotone_least_squares.hpp"

namespace palpate::fit {
namespace {

constexpr double kMinCosine = 0.5;       // of the normals of neighbours
constexpr double kMaxClimb = 0.2;        // out of the common tangent plane, per distance
constexpr std::size_t kCandidates = 16;  // nearest points looked at: Delaunay degrees are about 6
constexpr double kLongest = 4;           // median distances: farther ones are another cluster
constexpr double kShortest = 0.1;        // median distances: nearer ones weigh as this
constexpr double kOnBall = 1 + 1e-9;     // corners of a square count as within: no diagonals

using Pair = std::pair<std::int32_t, std::int32_t>;

bool face_alike(const Points& normal, std::int32_t p, std::int32_t q) {
  return normal.row(p).dot(normal.row(q)) >= kMinCosine;
}

// Along a smooth surface the way from p to q leaves p's tangent plane as far as it enters q's, so
// that it is at right angles to the sum of normals to third order. Between sheets it is not.
bool share_sheet(const Points& position, const Points& normal, std::int32_t p, std::int32_t q) {
  const auto way = position.row(q) - position.row(p);
  const double climb = 0.5 * std::abs(way.dot(normal.row(p) + normal.row(q)));
  return face_alike(normal, p, q) && climb <= kMaxClimb * way.norm();
}

// Nearest points of the same sheet, nearest first, the lowest index among equals.
std::vector<std::int32_t> nearest_points(const BoxTree& tree, const Points& position,
                                         const Points& normal, const std::vector<char>& takes_part,
                                         std::int32_t p) {
  std::vector<std::pair<double, std::int32_t>> found;
  double squared_best = std::numeric_limits<double>::infinity();
  tree.visit_nearest(position.row(p), squared_best, [&](std::int32_t q, double& squared_max) {
    if (q == p || !takes_part[static_cast<std::size_t>(q)]) return;
    const double squared = (position.row(q) - position.row(p)).squaredNorm();
    if (squared > squared_max || !share_sheet(position, normal, p, q)) return;
    found.insert(std::upper_bound(found.begin(), found.end(), std::pair(squared, q)),
                 std::pair(squared, q));
    if (found.size() > kCandidates) found.pop_back();
    if (found.size() == kCandidates) squared_max = found.back().first;
  });
  std::vector<std::int32_t> points;
  for (const auto& [squared, q] : found) points.push_back(q);
  return points;
}

std::set<Pair> gabriel_pairs(const Points& position, const Points& normal,
                             const std::vector<char>& takes_part) {
  const BoxTree tree(position, position);
  std::set<Pair> pairs;
  for (std::int32_t p = 0; p < position.rows(); ++p) {
    if (!takes_part[static_cast<std::size_t>(p)]) continue;
    const auto near = nearest_points(tree, position, normal, takes_part, p);
    for (std::size_t k = 0; k < near.size(); ++k) {
      const Vec3 a = position.row(p), b = position.row(near[k]);
      const double squared = 0.25 * (b - a).squaredNorm() * kOnBall;
      const auto is_between = [&](std::int32_t q) {
        return (Vec3(position.row(q)) - 0.5 * (a + b)).squaredNorm() <= squared;
      };
      const auto end = near.begin() + static_cast<std::ptrdiff_t>(k);
      if (std::none_of(near.begin(), end, is_between)) pairs.insert(std::minmax(p, near[k]));
    }
  }
  return pairs;
}

std::set<Pair> triangle_pairs(const Points& normal, const std::vector<char>& takes_part,
                              const Triangles& triangles) {
  std::set<Pair> pairs;
  for (const auto& t : triangles.rowwise())
    for (int k = 0; k < 3; ++k) {
      const std::int32_t p = t[k], q = t[(k + 1) % 3];
      if (takes_part[static_cast<std::size_t>(p)] && takes_part[static_cast<std::size_t>(q)] &&
          p != q && face_alike(normal, p, q))
        pairs.insert(std::minmax(p, q));
    }
  return pairs;
}

}  // namespace

std::vector<PointEdge> point_graph(const Points& position, const Points& normal,
                                   const std::vector<char>& takes_part,
                                   const Triangles& triangles) {
  const bool is_scattered = triangles.rows() == 0;
  const auto pairs = is_scattered ? gabriel_pairs(position, normal, takes_part)
                                  : triangle_pairs(normal, takes_part, triangles);
  std::vector<double> distance;
  for (const auto& [p, q] : pairs) distance.push_back((position.row(p) - position.row(q)).norm());
  const double typical = median(distance);
  std::vector<PointEdge> edges;
  std::size_t at = 0;
  for (const auto& [p, q] : pairs) {
    const double d = distance[at++];
    if (is_scattered && d > kLongest * typical) continue;
    const double share = typical > 0 ? std::max(d / typical, kShortest) : 1;
    edges.push_back({p, q, 1 / (share * share)});
  }
  return edges;
}

}  // namespace palpate::fit
