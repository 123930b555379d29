#include "libfit/core/geometry.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace palpate {

Points vertex_normals(const Surface& surface) {
  Points normals = Points::Zero(surface.vertices.rows(), 3);
  for (Eigen::Index f = 0; f < surface.triangles.rows(); ++f) {
    const auto triangle = surface.triangles.row(f);
    Vec3 corner[3];
    for (int k = 0; k < 3; ++k) corner[k] = surface.vertices.row(triangle[k]);
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
    const Vec3 a = surface.vertices.row(surface.triangles(f, 0));
    const Vec3 b = surface.vertices.row(surface.triangles(f, 1));
    const Vec3 c = surface.vertices.row(surface.triangles(f, 2));
    sum += 0.5 * (b - a).cross(c - a).norm();
  }
  return sum;
}

double volume_m3(const Surface& surface) {
  if (surface.vertices.rows() == 0) return 0;
  const Vec3 origin = surface.vertices.row(0);
  double sum = 0;
  for (Eigen::Index f = 0; f < surface.triangles.rows(); ++f) {
    const Vec3 a = surface.vertices.row(surface.triangles(f, 0)).transpose() - origin;
    const Vec3 b = surface.vertices.row(surface.triangles(f, 1)).transpose() - origin;
    const Vec3 c = surface.vertices.row(surface.triangles(f, 2)).transpose() - origin;
    sum += a.dot(b.cross(c));
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

}  // namespace palpate
