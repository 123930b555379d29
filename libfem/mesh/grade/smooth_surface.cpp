#include "libfem/mesh/grade/smooth_surface.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "libfem/mesh/topology.hpp"
#include "libfit/core/error.hpp"

namespace palpate::fem {
namespace {

void check(const Surface& surface) {
  const auto& t = surface.triangles;
  if (t.rows() == 0)
    throw Error("surface", "it has no triangle", "Give a surface with at least one triangle.");
  if (t.minCoeff() < 0 || t.maxCoeff() >= surface.vertices.rows())
    throw Error("surface", "a triangle names a vertex that is not there",
                "Repair the indices of the triangles.");
}

}  // namespace

SmoothSurface::SmoothSurface(Surface surface) : surface_(std::move(surface)) {
  check(surface_);
  const Eigen::Index count = surface_.triangles.rows();
  facet_normal_.resize(count, 3);
  for (std::int32_t f = 0; f < count; ++f) {
    const Vec3 a = corner(f, 0), b = corner(f, 1), c = corner(f, 2);
    const Vec3 normal = (b - a).cross(c - a);
    const double length = normal.norm();
    facet_normal_.row(f) = length > 0 ? Vec3(normal / length) : Vec3::Zero();
  }
  if (facet_normal_.isZero(0))
    throw Error("surface", "no triangle has an area", "Give a surface, not lines or points.");
  triangle_boxes_ = triangle_boxes(surface_);
  find_neighbours();
  average_corner_normals();
}

void SmoothSurface::find_neighbours() {
  const double crease_cosine = std::cos(kCreaseAngle_rad);
  smooth_neighbour_ = Triangles::Constant(surface_.triangles.rows(), 3, -1);
  for_each_edge(sorted_sides(surface_.triangles), [&](auto begin, auto end) {
    const TriangleSide &f = *begin, &g = *(end - 1);
    const Vec3 normal_f = facet_normal_.row(f.face), normal_g = facet_normal_.row(g.face);
    // A triangle without area has no say: it joins what it touches.
    const bool is_smooth = end - begin == 2 && (normal_f.isZero(0) || normal_g.isZero(0) ||
                                                normal_f.dot(normal_g) >= crease_cosine);
    if (is_smooth) {
      smooth_neighbour_(f.face, f.corner) = g.face;
      smooth_neighbour_(g.face, g.corner) = f.face;
    } else {
      crease_.push_back({f.low, f.high});
    }
  });

  Points lower(crease_.size(), 3), upper = lower;
  for (std::size_t e = 0; e < crease_.size(); ++e) {
    const auto a = surface_.vertices.row(crease_[e].a), b = surface_.vertices.row(crease_[e].b);
    lower.row(e) = a.cwiseMin(b);
    upper.row(e) = a.cwiseMax(b);
  }
  crease_boxes_ = BoxTree(lower, upper);
}

void SmoothSurface::average_corner_normals() {
  const auto& triangles = surface_.triangles;
  DisjointSets fans(triangles.size());
  const auto corner_at = [&](std::int32_t f, std::int32_t vertex) {
    const int k = triangles(f, 0) == vertex ? 0 : triangles(f, 1) == vertex ? 1 : 2;
    return 3 * f + k;
  };
  for (std::int32_t f = 0; f < triangles.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      const std::int32_t g = smooth_neighbour_(f, k);
      if (g < f) continue;
      for (const std::int32_t vertex : {triangles(f, k), triangles(f, (k + 1) % 3)})
        fans.join(corner_at(f, vertex), corner_at(g, vertex));
    }

  Points sum = Points::Zero(triangles.size(), 3);
  for (std::int32_t f = 0; f < triangles.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      const Vec3 e1 = corner(f, (k + 1) % 3) - corner(f, k);
      const Vec3 e2 = corner(f, (k + 2) % 3) - corner(f, k);
      const double angle = std::atan2(e1.cross(e2).norm(), e1.dot(e2));
      sum.row(fans.find(3 * f + k)) += angle * facet_normal_.row(f);
    }
  corner_normal_.resize(triangles.size(), 3);
  for (std::int32_t c = 0; c < triangles.size(); ++c) {
    const Vec3 total = sum.row(fans.find(c));
    const double length = total.norm();
    corner_normal_.row(c) = length > 0 ? Vec3(total / length) : Vec3(facet_normal_.row(c / 3));
  }
}

template <class Accept>
std::optional<SurfaceHit> SmoothSurface::closest_where(const Vec3& point, Accept&& accept) const {
  const auto found = closest_point(surface_, triangle_boxes_, point,
                                   std::numeric_limits<double>::infinity(), accept);
  if (!found) return std::nullopt;
  SurfaceHit hit;
  hit.triangle = found->triangle;
  hit.weights = found->weight;
  hit.on_facet = found->position;
  hit.position = lifted(hit.triangle, hit.weights);
  hit.normal = normal(hit.triangle, hit.weights);
  hit.distance_m = found->distance_m;
  return hit;
}

SurfaceHit SmoothSurface::closest(const Vec3& point) const {
  // Some triangle has an area (checked on construction), so there is always a hit for finite
  // points.
  const auto has_area = [&](const SurfacePoint& at) {
    return !facet_normal_.row(at.triangle).isZero(0);
  };
  return closest_where(point, has_area).value_or(SurfaceHit{});
}

std::optional<SurfaceHit> SmoothSurface::closest(const Vec3& point, const Vec3& direction,
                                                 double min_cosine) const {
  const Vec3 unit = direction.stableNormalized();
  return closest_where(point, [&](const SurfacePoint& at) {
    const auto facet = facet_normal_.row(at.triangle);
    return !facet.isZero(0) && facet.dot(unit) >= min_cosine;
  });
}

std::optional<Vec3> SmoothSurface::closest_crease(const Vec3& point, double within_m) const {
  std::optional<Vec3> hit;
  double squared_best = within_m * within_m;
  crease_boxes_.visit_nearest(point, squared_best, [&](std::int32_t e, double& best) {
    const Vec3 a = surface_.vertices.row(crease_[e].a), b = surface_.vertices.row(crease_[e].b);
    const Vec3 nearest = a + nearest_on_segment(point, a, b) * (b - a);
    const double squared = (nearest - point).squaredNorm();
    if (squared > best || (hit && squared == best)) return;
    best = squared;
    hit = nearest;
  });
  return hit;
}

Vec3 SmoothSurface::lifted(std::int32_t triangle, const Vec3& weights) const {
  const Vec3 p = weights[0] * corner(triangle, 0) + weights[1] * corner(triangle, 1) +
                 weights[2] * corner(triangle, 2);
  Vec3 out = p;
  for (int k = 0; k < 3; ++k) {
    const Vec3 normal_k = corner_normal_.row(3 * triangle + k);
    out -= 0.5 * weights[k] * (p - corner(triangle, k)).dot(normal_k) * normal_k;
  }
  return out;
}

Vec3 SmoothSurface::normal(std::int32_t triangle, const Vec3& weights) const {
  Vec3 sum = Vec3::Zero();
  for (int k = 0; k < 3; ++k) sum += weights[k] * corner_normal_.row(3 * triangle + k).transpose();
  const double length = sum.norm();
  return length > 0 ? Vec3(sum / length) : Vec3(facet_normal_.row(triangle));
}

}  // namespace palpate::fem
