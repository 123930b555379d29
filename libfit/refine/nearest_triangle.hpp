#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "libfit/core/surface.hpp"

namespace palpate {

/// The point of a triangle nearest to a query: area coordinates (>= 0, sum 1) and distance [m].
struct TrianglePoint {
  Vec3 weight;
  double distance_m = 0;
};

/// Nearest point of triangle a, b, c to p; flat and point-like triangles are fine.
/// Source: Ericson, Real-Time Collision Detection (2005), 5.1.5.
TrianglePoint nearest_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c);

/// Answers nearest-point queries on a surface, which must outlive it: a tree of bounding boxes,
/// built in O(F log F).
class TriangleTree {
 public:
  struct Hit {
    std::int32_t triangle = 0;
    TrianglePoint point;
  };
  using Accept = std::function<bool(std::int32_t triangle, const TrianglePoint& point)>;

  explicit TriangleTree(const Surface& surface);

  /// Nearest among the triangles whose nearest point `accept` takes, no farther than max_m; the
  /// lowest index among equals. Nothing when there is none.
  std::optional<Hit> nearest(const Vec3& query, double max_m, const Accept& accept) const;

 private:
  struct Node {
    Vec3 low, high;
    std::int32_t begin = 0, end = 0;  // triangles of a leaf
    std::int32_t left = -1;           // children are left and left + 1; -1 in a leaf
  };

  void build(std::int32_t node, std::int32_t begin, std::int32_t end);

  const Surface& surface_;
  std::vector<std::int32_t> order_;
  std::vector<Node> nodes_;
};

}  // namespace palpate
