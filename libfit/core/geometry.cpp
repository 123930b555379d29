#include "libfit/core/geometry.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "libfit/core/closest_point.hpp"

namespace palpate {
namespace {

Vec3 nearest_weights_on_border(const Vec3& p, const Vec3 (&corner)[3]) {
  Vec3 best = Vec3::UnitX();
  double squared_best = kInfinity;
  for (int k = 0; k < 3; ++k) {
    const int next = (k + 1) % 3;
    const double t = nearest_on_segment(p, corner[k], corner[next]);
    const double squared = (p - (corner[k] + t * (corner[next] - corner[k]))).squaredNorm();
    if (!(squared < squared_best)) continue;
    squared_best = squared;
    best.setZero();
    best[k] = 1 - t;
    best[next] = t;
  }
  return best;
}

}  // namespace

Points vertex_normals(const Surface& surface) {
  Points normals = Points::Zero(surface.vertices.rows(), 3);
  for (Eigen::Index f = 0; f < surface.triangles.rows(); ++f) {
    const auto triangle = surface.triangles.row(f);
    const std::array<Vec3, 3> corner = corners_of(surface, f);
    const Vec3 normal = (corner[1] - corner[0]).cross(corner[2] - corner[0]);
    const double length = normal.norm();
    if (!(length > 0)) continue;
    for (int k = 0; k < 3; ++k) {
      const Vec3 e1 = corner[(k + 1) % 3] - corner[k], e2 = corner[(k + 2) % 3] - corner[k];
      const double angle = std::atan2(length, e1.dot(e2));
      normals.row(triangle[k]) += (angle / length) * normal.transpose();
    }
  }
  for (Eigen::Index v = 0; v < normals.rows(); ++v) {
    const double length = normals.row(v).norm();
    if (length > 0) normals.row(v) /= length;
  }
  return normals;
}

double area_m2(const Surface& surface) {
  double sum = 0;
  for (Eigen::Index f = 0; f < surface.triangles.rows(); ++f) {
    const auto [a, b, c] = corners_of(surface, f);
    sum += 0.5 * (b - a).cross(c - a).norm();
  }
  return sum;
}

double volume_m3(const Surface& surface) {
  if (surface.vertices.rows() == 0) return 0;
  const Vec3 origin = surface.vertices.row(0);
  double sum = 0;
  for (Eigen::Index f = 0; f < surface.triangles.rows(); ++f) {
    const auto [a, b, c] = corners_of(surface, f);
    sum += (a - origin).dot((b - origin).cross(c - origin));
  }
  return sum / 6;
}

Vec3 extent_m(const Points& points) {
  if (points.rows() == 0) return Vec3::Zero();
  return (points.colwise().maxCoeff() - points.colwise().minCoeff()).transpose();
}

bool begin_alike(const Points& a, const Points& b) {
  // The bound is eight times the rounding of a float; at half, bodies far off their origin would
  // seem others, at twice nothing changes.
  const Eigen::Index both = std::min(a.rows(), b.rows());
  return both == 0 || (a.topRows(both) - b.topRows(both)).rowwise().norm().maxCoeff() <=
                          1e-6 * extent_m(b).norm();
}

std::vector<std::vector<std::int32_t>> patches_of(const Surface& surface,
                                                  const std::vector<char>& is_in) {
  DisjointSets sets(is_in.size());
  for (const auto& t : surface.triangles.rowwise())
    for (int k = 0; k < 3; ++k)
      if (const std::int32_t a = t[k], b = t[(k + 1) % 3]; is_in[a] && is_in[b]) sets.join(a, b);
  std::vector<std::vector<std::int32_t>> patches;
  std::vector<std::int32_t> number(is_in.size(), -1);
  for (std::size_t v = 0; v < is_in.size(); ++v) {
    if (!is_in[v]) continue;
    std::int32_t& patch = number[sets.find(v)];
    if (patch < 0) {
      patch = static_cast<std::int32_t>(patches.size());
      patches.emplace_back();
    }
    patches[patch].push_back(static_cast<std::int32_t>(v));
  }
  return patches;
}

Vec3 nearest_weights(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a, ac = c - a, ap = p - a;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return {1, 0, 0};
  const Vec3 bp = p - b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return {0, 1, 0};
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return {1 - d1 / (d1 - d3), d1 / (d1 - d3), 0};
  const Vec3 cp = p - c;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return {0, 0, 1};
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return {1 - d2 / (d2 - d6), 0, d2 / (d2 - d6)};
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    const double w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return {0, 1 - w, w};
  }
  const double sum = va + vb + vc;  // (twice the area)^2
  const double squared_length = std::max(ab.squaredNorm(), ac.squaredNorm());
  // A flat triangle, whose regions drown in rounding, counts as its edges, from which no place
  // inside is farther than a millionth of the triangle's length.
  if (!(sum > 1e-12 * squared_length * squared_length))
    return nearest_weights_on_border(p, {a, b, c});
  return {va / sum, vb / sum, vc / sum};
}

double ray_hit_m(const Vec3& origin, const Vec3& direction, const Vec3& a, const Vec3& b,
                 const Vec3& c) {
  constexpr double kRim = 1e-12;  // of weights: a ray through a shared edge must not slip through
  const Vec3 ab = b - a, ac = c - a, across = direction.cross(ac);
  const double det = ab.dot(across);
  if (det == 0) return kInfinity;
  const Vec3 from_a = origin - a, over = from_a.cross(ab);
  const double v = from_a.dot(across) / det, w = direction.dot(over) / det;
  return v >= -kRim && w >= -kRim && v + w <= 1 + kRim ? ac.dot(over) / det : kInfinity;
}

std::optional<double> ray_distance_m(const Surface& surface, const BoxTree& boxes,
                                     const Vec3& origin, const Vec3& direction, double skip_m) {
  const Vec3 start = origin + skip_m * direction;
  double first = std::numeric_limits<double>::max();  // boxes that the ray misses are at infinity
  boxes.visit_along(start, direction, first, [&](std::int32_t f, double& nearest) {
    const auto [a, b, c] = corners_of(surface, f);
    const double hit = ray_hit_m(start, direction, a, b, c);
    if (hit >= 0) nearest = std::min(nearest, hit);
  });
  if (first == std::numeric_limits<double>::max()) return std::nullopt;
  return skip_m + first;
}

bool is_inside(const Surface& closed, const BoxTree& boxes, const Vec3& place) {
  // Not along an axis, where meshes have edges.
  static const Vec3 kDirection = Vec3(0.1237, 0.0719, 1).normalized();
  int crossings = 0;
  double farthest = std::numeric_limits<double>::max();
  boxes.visit_along(place, kDirection, farthest, [&](std::int32_t f, double&) {
    const auto [a, b, c] = corners_of(closed, f);
    const double hit = ray_hit_m(place, kDirection, a, b, c);
    if (hit >= 0 && std::isfinite(hit)) ++crossings;
  });
  return crossings % 2 == 1;
}

}  // namespace palpate
