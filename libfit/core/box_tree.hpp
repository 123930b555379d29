#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <numeric>
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
  static constexpr std::int32_t kLeafSize = 4;

  static double squared_distance(const Node& node, const Vec3& point) {
    return (node.lower - point).cwiseMax(point - node.upper).cwiseMax(0.0).squaredNorm();
  }

  /// Distance at which the ray enters a box, 0 inside; infinite when it does not.
  static double entry(const Node& node, const Vec3& origin, const Vec3& direction) {
    double begin = 0, end = std::numeric_limits<double>::infinity();
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
    constexpr double kRounding = 1 + 1e-12;  // a box may be as flat as its triangle
    return begin <= end * kRounding ? begin : std::numeric_limits<double>::infinity();
  }

  void build(const Points& lower, const Points& upper, std::int32_t begin, std::int32_t end) {
    const std::size_t index = nodes_.size();
    Node node{Vec3::Constant(std::numeric_limits<double>::infinity()),
              Vec3::Constant(-std::numeric_limits<double>::infinity()), begin, end - begin};
    for (std::int32_t k = begin; k < end; ++k) {
      node.lower = node.lower.cwiseMin(lower.row(order_[k]).transpose());
      node.upper = node.upper.cwiseMax(upper.row(order_[k]).transpose());
    }
    nodes_.push_back(node);
    if (node.count <= kLeafSize) return;
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

}  // namespace palpate
