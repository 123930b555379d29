#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <utility>

#include "libfit/core/geometry.hpp"
#include "tests/support/surfaces.hpp"

// Surfaces of known shape, for the tests of points and fill.

namespace palpate::testing {

using testing_support::inside_out;
using testing_support::together;

/// Unit cube [0, 1]^3, scaled.
inline Surface cube(double side_m) {
  Surface surface{Points(8, 3), Triangles(12, 3)};
  for (int v = 0; v < 8; ++v) surface.vertices.row(v) << v % 2, v / 2 % 2, v / 4;
  surface.vertices *= side_m;
  surface.triangles << 0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4, 2, 6, 3, 3, 6, 7, 0, 4,
      2, 2, 4, 6, 1, 3, 5, 3, 7, 5;
  return surface;
}

/// Each triangle in four, new vertices at edge midpoints.
inline Surface subdivided(const Surface& coarse) {
  std::map<std::pair<int, int>, int> middle;
  std::vector<Vec3> points;
  for (const auto& p : coarse.vertices.rowwise()) points.emplace_back(p.transpose());
  const auto between = [&](int a, int b) {
    const auto [at, is_new] = middle.emplace(std::minmax(a, b), static_cast<int>(points.size()));
    if (is_new) points.push_back((coarse.vertices.row(a) + coarse.vertices.row(b)).transpose() / 2);
    return at->second;
  };
  Surface fine;
  fine.triangles.resize(4 * coarse.triangles.rows(), 3);
  for (Eigen::Index f = 0; f < coarse.triangles.rows(); ++f) {
    const int a = coarse.triangles(f, 0), b = coarse.triangles(f, 1), c = coarse.triangles(f, 2);
    const int ab = between(a, b), bc = between(b, c), ca = between(c, a);
    fine.triangles.row(4 * f) << a, ab, ca;
    fine.triangles.row(4 * f + 1) << ab, b, bc;
    fine.triangles.row(4 * f + 2) << ca, bc, c;
    fine.triangles.row(4 * f + 3) << ab, bc, ca;
  }
  fine.vertices.resize(static_cast<Eigen::Index>(points.size()), 3);
  for (std::size_t v = 0; v < points.size(); ++v)
    fine.vertices.row(static_cast<Eigen::Index>(v)) = points[v];
  return fine;
}

/// Sphere about the origin from an octahedron, 8 * 4^levels triangles.
inline Surface sphere(double radius_m, int levels) {
  Surface surface{Points(6, 3), Triangles(8, 3)};
  surface.vertices << 1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1;
  surface.triangles << 0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4, 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5;
  for (int level = 0; level < levels; ++level) {
    surface = subdivided(surface);
    surface.vertices.rowwise().normalize();
  }
  surface.vertices *= radius_m;
  return surface;
}

inline Surface moved(Surface surface, const Vec3& by) {
  surface.vertices.rowwise() += by.transpose();
  return surface;
}

}  // namespace palpate::testing
