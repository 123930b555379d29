#include "libfit/refine/nearest_triangle.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <numeric>

namespace palpate {
namespace {

constexpr std::int32_t kLeafTriangles = 4;
constexpr double kFlatSquared =
    1e-24;  // (2 area / longest edge squared)^2 of a triangle taken as a line

// Parameter in [0, 1] of the point of segment a-b nearest to p.
double nearest_on_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const double squared_length = (b - a).squaredNorm();
  return squared_length > 0 ? std::clamp((p - a).dot(b - a) / squared_length, 0.0, 1.0) : 0;
}

TrianglePoint nearest_on_border(const Vec3& p, const Vec3 (&corner)[3]) {
  TrianglePoint best{Vec3::Zero(), std::numeric_limits<double>::infinity()};
  for (int k = 0; k < 3; ++k) {
    const int next = (k + 1) % 3;
    const double t = nearest_on_segment(p, corner[k], corner[next]);
    const double distance_m = (p - (corner[k] + t * (corner[next] - corner[k]))).norm();
    if (distance_m < best.distance_m) {
      best.distance_m = distance_m;
      best.weight.setZero();
      best.weight[k] = 1 - t;
      best.weight[next] = t;
    }
  }
  return best;
}

double squared_distance(const Vec3& p, const Vec3& low, const Vec3& high) {
  return (low - p).cwiseMax(p - high).cwiseMax(0).squaredNorm();
}

}  // namespace

TrianglePoint nearest_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a, ac = c - a;
  const Vec3 normal = ab.cross(ac);
  const double longest = std::max({ab.squaredNorm(), ac.squaredNorm(), (c - b).squaredNorm()});
  const double squared_area = normal.squaredNorm();
  if (squared_area > kFlatSquared * longest * longest) {
    const Vec3 ap = p - a;
    const double v = ap.cross(ac).dot(normal) / squared_area;
    const double w = ab.cross(ap).dot(normal) / squared_area;
    if (v >= 0 && w >= 0 && v + w <= 1)
      return {Vec3(std::max(1 - v - w, 0.0), v, w),
              std::abs(ap.dot(normal)) / std::sqrt(squared_area)};
  }
  return nearest_on_border(p, {a, b, c});
}

TriangleTree::TriangleTree(const Surface& surface) : surface_(surface) {
  order_.resize(static_cast<std::size_t>(surface.triangles.rows()));
  std::iota(order_.begin(), order_.end(), 0);
  if (order_.empty()) return;
  nodes_.emplace_back();
  build(0, 0, static_cast<std::int32_t>(order_.size()));
}

void TriangleTree::build(std::int32_t node, std::int32_t begin, std::int32_t end) {
  const auto corner = [&](std::int32_t triangle, int k) {
    return Vec3(surface_.vertices.row(surface_.triangles(triangle, k)));
  };
  const auto center = [&](std::int32_t t) {
    return Vec3(corner(t, 0) + corner(t, 1) + corner(t, 2));
  };
  Vec3 low = corner(order_[static_cast<std::size_t>(begin)], 0), high = low;
  Vec3 low_center = center(order_[static_cast<std::size_t>(begin)]), high_center = low_center;
  for (std::int32_t i = begin; i < end; ++i) {
    const std::int32_t triangle = order_[static_cast<std::size_t>(i)];
    for (int k = 0; k < 3; ++k) {
      low = low.cwiseMin(corner(triangle, k));
      high = high.cwiseMax(corner(triangle, k));
    }
    low_center = low_center.cwiseMin(center(triangle));
    high_center = high_center.cwiseMax(center(triangle));
  }
  nodes_[static_cast<std::size_t>(node)] = {low, high, begin, end, -1};
  if (end - begin <= kLeafTriangles) return;
  Eigen::Index axis = 0;
  (high_center - low_center).maxCoeff(&axis);
  const std::int32_t middle = begin + (end - begin) / 2;
  std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
                   [&](std::int32_t a, std::int32_t b) {
                     return std::pair(center(a)[axis], a) < std::pair(center(b)[axis], b);
                   });
  const auto left = static_cast<std::int32_t>(nodes_.size());
  nodes_[static_cast<std::size_t>(node)].left = left;
  nodes_.resize(nodes_.size() + 2);
  build(left, begin, middle);
  build(left + 1, middle, end);
}

std::optional<TriangleTree::Hit> TriangleTree::nearest(const Vec3& query, double max_m,
                                                       const Accept& accept) const {
  std::optional<Hit> best;
  double bound_m = max_m;
  const auto is_beyond = [&](const Node& node) {
    return squared_distance(query, node.low, node.high) > bound_m * bound_m * (1 + 1e-12);
  };
  const auto try_triangle = [&](std::int32_t triangle) {
    const auto index = surface_.triangles.row(triangle);
    const TrianglePoint point =
        nearest_on_triangle(query, surface_.vertices.row(index[0]), surface_.vertices.row(index[1]),
                            surface_.vertices.row(index[2]));
    const bool is_better = point.distance_m < bound_m ||
                           (point.distance_m == bound_m && (!best || triangle < best->triangle));
    if (!is_better || !accept(triangle, point)) return;
    best = Hit{triangle, point};
    bound_m = point.distance_m;
  };
  std::vector<std::int32_t> stack;
  if (!nodes_.empty()) stack.push_back(0);
  while (!stack.empty()) {
    const Node& node = nodes_[static_cast<std::size_t>(stack.back())];
    stack.pop_back();
    if (is_beyond(node)) continue;
    if (node.left < 0) {
      for (std::int32_t i = node.begin; i < node.end; ++i)
        try_triangle(order_[static_cast<std::size_t>(i)]);
      continue;
    }
    const Node& a = nodes_[static_cast<std::size_t>(node.left)];
    const Node& b = nodes_[static_cast<std::size_t>(node.left) + 1];
    const bool is_left_nearer =
        squared_distance(query, a.low, a.high) <= squared_distance(query, b.low, b.high);
    stack.push_back(node.left + (is_left_nearer ? 1 : 0));
    stack.push_back(node.left + (is_left_nearer ? 0 : 1));
  }
  return best;
}

}  // namespace palpate
