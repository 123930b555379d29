#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <optional>
#include <vector>

#include "libfit/core/geometry.hpp"

namespace palpate {

/// Bounding boxes of primitives in a binary tree, for nearest-primitive and ray queries.
/// Written here instead of taken from CGAL's AABB_tree because the search must skip primitives (a
/// thin sheet's other side) and go to the nearer child first without a hint; CGAL's traversal takes
/// children in storage order and needs a hint that fits the filter.
/// Const queries are thread-safe. Built from and answered by primitive index only.
/// Source: Ericson, Real-Time Collision Detection (2005), 6.1 and 6.3.
class BoxTree {
 public:
  BoxTree() = default;

  /// lower, upper: # x 3 [m], corners of each primitive's box.
  BoxTree(const Points& lower, const Points& upper) {
    order_.resize(lower.rows());
    std::iota(order_.begin(), order_.end(), 0);
    if (!order_.empty()) build(lower, upper, 0, static_cast<std::int32_t>(order_.size()));
  }

  /// Calls visit(primitive, squared_best) for primitives whose box is no farther from `point` than
  /// squared_best [m^2], nearer boxes first; visit lowers squared_best when it finds something.
  template <class Visit>
  void visit_nearest(const Vec3& point, double& squared_best, Visit&& visit) const {
    if (nodes_.empty()) return;
    std::array<std::pair<double, std::int32_t>, 64> stack;  // depth <= log2(#) + 1, two a level
    int size = 0;
    stack[size++] = {squared_distance(nodes_[0], point), 0};
    while (size > 0) {
      const auto [squared, index] = stack[--size];
      if (squared > squared_best) continue;
      const Node& node = nodes_[index];
      if (node.count > 0) {
        for (std::int32_t k = 0; k < node.count; ++k) visit(order_[node.first + k], squared_best);
        continue;
      }
      std::pair<double, std::int32_t> left{squared_distance(nodes_[index + 1], point), index + 1};
      std::pair<double, std::int32_t> right{squared_distance(nodes_[node.first], point),
                                            node.first};
      if (left.first < right.first) std::swap(left, right);
      stack[size++] = left;
      stack[size++] = right;
    }
  }

  /// Calls visit(primitive, nearest) for primitives whose box the ray origin + t direction enters
  /// at a t in [0, nearest]; visit lowers nearest when it meets something.
  template <class Visit>
  void visit_along(const Vec3& origin, const Vec3& direction, double& nearest,
                   Visit&& visit) const {
    walk([&](const Node& node) { return entry(node, origin, direction) <= nearest; },
         [&](std::int32_t primitive) { visit(primitive, nearest); });
  }

  /// Calls visit(primitive) for primitives in boxes of which may_hold(centre, half_diagonal_m) says
  /// that they are worth a look; what it answers may change from one visit to the next.
  template <class MayHold, class Visit>
  void visit_where(MayHold&& may_hold, Visit&& visit) const {
    walk(
        [&](const Node& node) {
          return may_hold(Vec3((node.lower + node.upper) / 2),
                          (node.upper - node.lower).norm() / 2);
        },
        visit);
  }

  /// Calls visit(lower, upper, first, count) for the nodes in preorder: of a leaf, first and number
  /// of its primitives in order(); of others the number of the right child, and 0.
  template <class Visit>
  void each_node(Visit&& visit) const {
    for (const Node& node : nodes_) visit(node.lower, node.upper, node.first, node.count);
  }
  const std::vector<std::int32_t>& order() const { return order_; }

 private:
  struct Node {
    Vec3 lower, upper;
    std::int32_t first = 0;  // leaf: first in order_; else index of the right child (left is next)
    std::int32_t count = 0;  // leaf: primitives; else 0
  };

  // Primitives of the leaves whose boxes, and all boxes around them, are worth a look.
  template <class IsWorth, class Visit>
  void walk(const IsWorth& is_worth, const Visit& visit) const {
    if (nodes_.empty()) return;
    std::array<std::int32_t, 64> stack;
    int size = 0;
    stack[size++] = 0;
    while (size > 0) {
      const std::int32_t index = stack[--size];
      const Node& node = nodes_[index];
      if (!is_worth(node)) continue;
      for (std::int32_t k = 0; k < node.count; ++k) visit(order_[node.first + k]);
      if (node.count > 0) continue;
      stack[size++] = node.first;
      stack[size++] = index + 1;
    }
  }
  static double squared_distance(const Node& node, const Vec3& point) {
    return (node.lower - point).cwiseMax(point - node.upper).cwiseMax(0.0).squaredNorm();
  }

  /// Distance at which the ray enters a box, 0 inside; infinite when it does not.
  static double entry(const Node& node, const Vec3& origin, const Vec3& direction) {
    double begin = 0, end = kInfinity;
    for (int i = 0; i < 3; ++i) {
      if (direction[i] == 0) {
        if (origin[i] < node.lower[i] || origin[i] > node.upper[i]) end = -1;
        continue;
      }
      const double one = (node.lower[i] - origin[i]) / direction[i];
      const double other = (node.upper[i] - origin[i]) / direction[i];
      begin = std::max(begin, std::min(one, other));
      end = std::min(end, std::max(one, other));
    }
    // A box may be as flat as its triangle.
    return begin <= end * (1 + 1e-12) ? begin : kInfinity;
  }

  void build(const Points& lower, const Points& upper, std::int32_t begin, std::int32_t end) {
    const std::size_t index = nodes_.size();
    Node node{Vec3::Constant(kInfinity), Vec3::Constant(-kInfinity), begin, end - begin};
    for (std::int32_t k = begin; k < end; ++k) {
      node.lower = node.lower.cwiseMin(lower.row(order_[k]).transpose());
      node.upper = node.upper.cwiseMax(upper.row(order_[k]).transpose());
    }
    nodes_.push_back(node);
    if (node.count <= 4) return;
    Eigen::Index axis = 0;
    (node.upper - node.lower).maxCoeff(&axis);
    const std::int32_t middle = begin + (end - begin) / 2;
    const auto before = [&](std::int32_t a, std::int32_t b) {
      const double ca = lower(a, axis) + upper(a, axis), cb = lower(b, axis) + upper(b, axis);
      return ca != cb ? ca < cb : a < b;
    };
    std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end, before);
    build(lower, upper, begin, middle);
    nodes_[index].first = static_cast<std::int32_t>(nodes_.size());
    nodes_[index].count = 0;
    build(lower, upper, middle, end);
  }

  std::vector<Node> nodes_;
  std::vector<std::int32_t> order_;
};

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
  double distance_m = kInfinity;
};

/// Nearest point of one triangle, whose number is left at -1.
inline SurfacePoint nearest_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b,
                                        const Vec3& c) {
  const Vec3 w = nearest_weights(p, a, b, c);
  const Vec3 position = w[0] * a + w[1] * b + w[2] * c;
  return {-1, w, position, (position - p).norm()};
}

/// Boxes of cells with these corners, rows of `points`, for the queries below.
template <class Cells>
BoxTree boxes_of(const Points& points, const Cells& cells) {
  Points lower(cells.rows(), 3), upper = lower;
  for (Eigen::Index c = 0; c < cells.rows(); ++c) {
    lower.row(c) = upper.row(c) = points.row(cells(c, 0));
    for (Eigen::Index k = 1; k < cells.cols(); ++k) {
      lower.row(c) = lower.row(c).cwiseMin(points.row(cells(c, k)));
      upper.row(c) = upper.row(c).cwiseMax(points.row(cells(c, k)));
    }
  }
  return {lower, upper};
}
inline BoxTree triangle_boxes(const Surface& surface) {
  return boxes_of(surface.vertices, surface.triangles);
}

/// Nearest point among the triangles whose nearest point `accept(SurfacePoint)` takes, no farther
/// than max_m; of two as near, that of the lower triangle. Empty when there is none.
/// boxes: triangle_boxes(surface). Thread-safe, allocates nothing.
template <class Accept>
std::optional<SurfacePoint> closest_point(const Surface& surface, const BoxTree& boxes,
                                          const Vec3& query, double max_m, Accept&& accept) {
  std::optional<SurfacePoint> hit;
  double squared_best = max_m * max_m;
  boxes.visit_nearest(query, squared_best, [&](std::int32_t f, double& best) {
    const auto [a, b, c] = corners_of(surface, f);
    SurfacePoint point = nearest_on_triangle(query, a, b, c);
    point.triangle = f;
    const double squared = (point.position - query).squaredNorm();
    const bool is_better = squared < best || (squared == best && (!hit || f < hit->triangle));
    if (!is_better) return;
    if (!accept(static_cast<const SurfacePoint&>(point))) return;
    best = squared;
    hit = point;
  });
  return hit;
}

/// The same over all triangles.
inline std::optional<SurfacePoint> closest_point(const Surface& surface, const BoxTree& boxes,
                                                 const Vec3& query, double max_m = kInfinity) {
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
