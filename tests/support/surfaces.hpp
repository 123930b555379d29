#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "libfit/core/geometry.hpp"

// Closed surfaces for tests of both libraries, and how two become one.
namespace palpate::testing_support {

/// A block [m] of 12 triangles.
inline Surface coarse_block(double x, double y, double z) {
  Surface block;
  block.vertices.resize(8, 3);
  for (int v = 0; v < 8; ++v)
    block.vertices.row(v) << (v & 1 ? x : 0), (v & 2 ? y : 0), (v & 4 ? z : 0);
  block.triangles.resize(12, 3);
  block.triangles << 0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3, 0, 4,
      6, 0, 6, 2, 1, 3, 7, 1, 7, 5;
  return block;
}

/// A cube [0, side]^3, whose triangles meet in other diagonals.
inline Surface cube(double side_m) {
  Surface surface{Points(8, 3), Triangles(12, 3)};
  for (int v = 0; v < 8; ++v) surface.vertices.row(v) << v % 2, v / 2 % 2, v / 4;
  surface.vertices *= side_m;
  surface.triangles << 0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4, 2, 6, 3, 3, 6, 7, 0, 4,
      2, 2, 4, 6, 1, 3, 5, 3, 7, 5;
  return surface;
}

/// A sheet over (u, v) in a grid of nu x nv cells, triangles counter-clockwise in (u, v).
inline Surface sheet(int nu, int nv, const std::function<Vec3(double u, double v)>& at) {
  Surface s;
  s.vertices.resize((nu + 1) * (nv + 1), 3);
  s.triangles.resize(2 * nu * nv, 3);
  for (int i = 0; i <= nu; ++i)
    for (int j = 0; j <= nv; ++j)
      s.vertices.row(i * (nv + 1) + j) = at(double(i) / nu, double(j) / nv).transpose();
  int t = 0;
  for (int i = 0; i < nu; ++i)
    for (int j = 0; j < nv; ++j) {
      const int a = i * (nv + 1) + j, b = a + nv + 1;
      if ((i + j) % 2 == 0) {
        s.triangles.row(t++) << a, b, b + 1;
        s.triangles.row(t++) << a, b + 1, a + 1;
      } else {
        s.triangles.row(t++) << a, b, a + 1;
        s.triangles.row(t++) << b, b + 1, a + 1;
      }
    }
  return s;
}

/// Flat, facing +z at height z.
inline Surface plate(int nu, int nv, double width_m, double height_m, double z_m = 0) {
  return sheet(nu, nv, [=](double u, double v) { return Vec3(u * width_m, v * height_m, z_m); });
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

/// Split `levels` times, new vertices going out to the unit sphere, and then scaled.
inline Surface blown_up(Surface surface, int levels, double radius_m) {
  for (int level = 0; level < levels; ++level) {
    const Eigen::Index before = surface.vertices.rows();
    surface = subdivided(surface);
    surface.vertices.bottomRows(surface.vertices.rows() - before).rowwise().normalize();
  }
  surface.vertices *= radius_m;
  return surface;
}

/// A sphere from an icosahedron: 10 * 4^levels + 2 vertices.
inline Surface icosphere(int levels, double radius_m) {
  const double g = (1 + std::sqrt(5.0)) / 2;
  Surface s{Points(12, 3), Triangles(20, 3)};
  s.vertices << -1, g, 0, 1, g, 0, -1, -g, 0, 1, -g, 0, 0, -1, g, 0, 1, g, 0, -1, -g, 0, 1, -g, g,
      0, -1, g, 0, 1, -g, 0, -1, -g, 0, 1;
  s.vertices.rowwise().normalize();
  s.triangles << 0, 11, 5, 0, 5, 1, 0, 1, 7, 0, 7, 10, 0, 10, 11, 1, 5, 9, 5, 11, 4, 11, 10, 2, 10,
      7, 6, 7, 1, 8, 3, 9, 4, 3, 4, 2, 3, 2, 6, 3, 6, 8, 3, 8, 9, 4, 9, 5, 2, 4, 11, 6, 2, 10, 8, 6,
      7, 9, 8, 1;
  return blown_up(s, levels, radius_m);
}

/// A sphere from an octahedron: 8 * 4^levels triangles.
inline Surface octasphere(int levels, double radius_m) {
  Surface s{Points(6, 3), Triangles(8, 3)};
  s.vertices << 1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1;
  s.triangles << 0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4, 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5;
  return blown_up(s, levels, radius_m);
}

/// Two surfaces as one, not joined.
inline Surface together(const Surface& a, const Surface& b) {
  Surface s;
  s.vertices.resize(a.vertices.rows() + b.vertices.rows(), 3);
  s.vertices << a.vertices, b.vertices;
  s.triangles.resize(a.triangles.rows() + b.triangles.rows(), 3);
  s.triangles << a.triangles, (b.triangles.array() + int(a.vertices.rows())).matrix();
  return s;
}

inline Surface moved(Surface surface, const Vec3& by) {
  surface.vertices.rowwise() += by.transpose();
  return surface;
}

inline Surface inside_out(Surface surface) {
  surface.triangles.col(1).swap(surface.triangles.col(2));
  return surface;
}

/// As OFF, in `scale` parts of a metre.
inline std::string off_of(const Surface& surface, double scale = 1) {
  std::ostringstream off;
  off.precision(9);
  off << "OFF\n" << surface.vertices.rows() << ' ' << surface.triangles.rows() << " 0\n";
  for (const auto& p : surface.vertices.rowwise()) off << scale * p << '\n';
  for (const auto& t : surface.triangles.rowwise()) off << "3 " << t << '\n';
  return off.str();
}

}  // namespace palpate::testing_support
