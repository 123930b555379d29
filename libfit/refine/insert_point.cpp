#include "libfit/refine/next_points.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <set>
#include <vector>

#include "libfit/core/closest_point.hpp"
#include "libfit/refine/points_on_surface.hpp"

namespace palpate {
namespace {

constexpr double kSamePlace = 1e-6;  // of the triangle's longest edge

using Corners = std::array<std::int32_t, 3>;
using DirectedEdge = std::pair<std::int32_t, std::int32_t>;

/// A triangulation that can be changed: which triangle lies left of each directed edge.
class Mesh {
 public:
  explicit Mesh(TestPoints& points) : points_(points) {
    for (Eigen::Index t = 0; t < points.triangles.rows(); ++t) {
      triangle_.push_back({points.triangles(t, 0), points.triangles(t, 1), points.triangles(t, 2)});
      index(t);
    }
  }

  const std::vector<Corners>& triangles() const { return triangle_; }
  Vec3 at(std::int32_t point) const { return points_.position.row(point); }

  std::optional<std::size_t> left_of(std::int32_t from, std::int32_t to) const {
    const auto found = left_.find({from, to});
    if (found == left_.end()) return std::nullopt;
    return found->second;
  }
  std::int32_t apex(std::size_t t, std::int32_t from, std::int32_t to) const {
    for (const std::int32_t corner : triangle_[t])
      if (corner != from && corner != to) return corner;
    return -1;
  }

  /// Replaces triangle t by the corners (a, b, c).
  void put(std::size_t t, const Corners& corners) {
    if (t < triangle_.size())
      forget(t);
    else
      triangle_.push_back({});
    triangle_[t] = corners;
  }
  void index(std::size_t t) {
    for (std::size_t k = 0; k < 3; ++k) left_[{triangle_[t][k], triangle_[t][(k + 1) % 3]}] = t;
  }
  void forget(std::size_t t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto found = left_.find({triangle_[t][k], triangle_[t][(k + 1) % 3]});
      if (found != left_.end() && found->second == t) left_.erase(found);
    }
  }

  /// The edge's two triangles get the other diagonal where that is rounder, manifold and faces out.
  /// Returns its ends.
  std::optional<DirectedEdge> flip_if_better(const DirectedEdge& edge) {
    const auto [a, b] = edge;
    const auto one = left_of(a, b), other = left_of(b, a);
    if (!one || !other) return std::nullopt;
    const std::int32_t c = apex(*one, a, b), d = apex(*other, a, b);
    if (c == d || left_of(c, d) || left_of(d, c) ||
        angle(a, c, b) + angle(a, d, b) <= std::numbers::pi + 1e-9 || !faces_out({c, a, d}) ||
        !faces_out({d, b, c}))
      return std::nullopt;
    forget(*one), forget(*other);
    triangle_[*one] = {c, a, d};
    triangle_[*other] = {d, b, c};
    index(*one), index(*other);
    return DirectedEdge(c, d);
  }

  void store() const {
    points_.triangles.resize(triangle_.size(), 3);
    for (std::size_t t = 0; t < triangle_.size(); ++t)
      for (int k = 0; k < 3; ++k) points_.triangles(t, k) = triangle_[t][k];
  }

 private:
  double angle(std::int32_t a, std::int32_t at_point, std::int32_t b) const {
    const Vec3 p = at(a) - at(at_point), q = at(b) - at(at_point);
    return std::atan2(p.cross(q).norm(), p.dot(q));
  }
  bool faces_out(const Corners& c) const {
    const Vec3 normal = (at(c[1]) - at(c[0])).cross(at(c[2]) - at(c[0]));
    Vec3 inward = Vec3::Zero();
    for (const std::int32_t corner : c) inward += points_.normal.row(corner).transpose();
    return -inward.dot(normal) > kMinCosine * inward.norm() * normal.norm();
  }

  TestPoints& points_;
  std::vector<Corners> triangle_;
  std::map<DirectedEdge, std::size_t> left_;
};

// Triangles within three rings of a point, ascending.
std::vector<std::size_t> triangles_near(const Mesh& mesh, std::int32_t point) {
  std::set<std::int32_t> known{point};
  std::set<std::size_t> found;
  for (int ring = 0; ring < 3; ++ring) {
    std::set<std::int32_t> more;
    for (std::size_t t = 0; t < mesh.triangles().size(); ++t) {
      const Corners& corners = mesh.triangles()[t];
      const bool touches = std::any_of(corners.begin(), corners.end(),
                                       [&](std::int32_t c) { return known.count(c) != 0; });
      if (!touches) continue;
      found.insert(t);
      more.insert(corners.begin(), corners.end());
    }
    known.merge(more);
  }
  return {found.begin(), found.end()};
}

struct InsertionPlace {
  std::size_t triangle = 0;
  SurfacePoint point;
};

std::optional<InsertionPlace> find_place(const Mesh& mesh, const TestPoints& points,
                                         const NewTestPoint& added) {
  std::optional<InsertionPlace> best;
  for (const std::size_t t : triangles_near(mesh, added.near)) {
    const Corners& c = mesh.triangles()[t];
    const SurfacePoint hit =
        nearest_on_triangle(added.position, mesh.at(c[0]), mesh.at(c[1]), mesh.at(c[2]));
    if (best && !(hit.distance_m < best->point.distance_m)) continue;
    if (faces_alike(blended(points.normal, c, hit.weight), added.normal))
      best = InsertionPlace{t, hit};
  }
  return best;
}

// At a corner, or off it: then no split of the triangle holds the point.
bool is_taken(const Mesh& mesh, const Corners& corners, const Vec3& position, const Vec3& weight) {
  if (weight.maxCoeff() > 1 - kSamePlace) return true;
  double longest_m = 0, nearest_m = (mesh.at(corners[0]) - position).norm();
  for (std::size_t k = 0; k < 3; ++k) {
    longest_m = std::max(longest_m, (mesh.at(corners[(k + 1) % 3]) - mesh.at(corners[k])).norm());
    nearest_m = std::min(nearest_m, (mesh.at(corners[k]) - position).norm());
  }
  return nearest_m <= kSamePlace * longest_m;
}

// Splits triangle t = (a, b, c) along the edge (a, b), with its neighbour there, at the new point.
// Returns the edges that may have to flip.
std::vector<DirectedEdge> split_edge(Mesh& mesh, std::size_t t, std::int32_t a, std::int32_t b,
                                     std::int32_t point) {
  const std::int32_t c = mesh.apex(t, a, b);
  const auto other = mesh.left_of(b, a);
  std::vector<std::size_t> changed{t, mesh.triangles().size()};
  std::vector<DirectedEdge> outer{{b, c}, {c, a}};
  const std::int32_t d = other ? mesh.apex(*other, a, b) : -1;
  mesh.put(t, {a, point, c});
  mesh.put(changed[1], {point, b, c});
  if (other) {
    changed.insert(changed.end(), {*other, mesh.triangles().size()});
    mesh.put(*other, {b, point, d});
    mesh.put(changed[3], {point, a, d});
    // Beside the edge near its ends, the point need not see the far corner.
    outer.insert(outer.end(), {{a, d}, {d, b}, {point, d}, {point, c}});
  }
  for (const std::size_t triangle : changed) mesh.index(triangle);
  return outer;
}

std::vector<DirectedEdge> split_triangle(Mesh& mesh, std::size_t t, std::int32_t point) {
  const Corners c = mesh.triangles()[t];
  const std::size_t next = mesh.triangles().size();
  mesh.put(t, {c[0], c[1], point});
  mesh.put(next, {c[1], c[2], point});
  mesh.put(next + 1, {c[2], c[0], point});
  for (const std::size_t triangle : {t, next, next + 1}) mesh.index(triangle);
  return {{c[0], c[1]}, {c[1], c[2]}, {c[2], c[0]}};
}

std::vector<DirectedEdge> split_at(Mesh& mesh, const InsertionPlace& place, std::int32_t point) {
  const Corners corners = mesh.triangles()[place.triangle];
  int least = 0;
  place.point.weight.minCoeff(&least);
  const std::int32_t a = corners[(least + 1) % 3];
  const std::int32_t b = corners[(least + 2) % 3];
  // A sliver along the border could not be flipped away.
  if (place.point.weight[least] < (mesh.left_of(b, a) ? 0.02 : 0.15))
    return split_edge(mesh, place.triangle, a, b, point);
  return split_triangle(mesh, place.triangle, point);
}

void legalise(Mesh& mesh, std::vector<DirectedEdge> edges) {
  // In the plane flips end by themselves; on a curved surface nothing proves it.
  std::size_t most = 16 + 4 * mesh.triangles().size();
  while (!edges.empty() && most-- > 0) {
    const DirectedEdge edge = edges.back();
    edges.pop_back();
    const auto diagonal = mesh.flip_if_better(edge);
    if (!diagonal) continue;
    const auto [c, d] = *diagonal;
    edges.insert(edges.end(),
                 {{c, edge.first}, {edge.first, d}, {d, edge.second}, {edge.second, c}});
  }
}

}  // namespace

bool insert_point(TestPoints& points, const NewTestPoint& added) {
  Mesh mesh(points);
  const auto place = find_place(mesh, points, added);
  if (!place ||
      is_taken(mesh, mesh.triangles()[place->triangle], added.position, place->point.weight))
    return false;
  const std::int32_t point = points.position.rows();
  points.add(added.position, added.normal, added.name);
  legalise(mesh, split_at(mesh, *place, point));
  mesh.store();
  return true;
}

}  // namespace palpate
