#pragma once

#include <cmath>
#include <map>
#include <sstream>
#include <string>
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

/// An icosahedron split `level` times: 10 * 4^level + 2 vertices on the sphere.
inline Surface icosphere(int level, double radius_m) {
  const double g = (1 + std::sqrt(5.0)) / 2;
  std::vector<Vec3> vertices{{-1, g, 0}, {1, g, 0}, {-1, -g, 0}, {1, -g, 0},
                             {0, -1, g}, {0, 1, g}, {0, -1, -g}, {0, 1, -g},
                             {g, 0, -1}, {g, 0, 1}, {-g, 0, -1}, {-g, 0, 1}};
  for (Vec3& v : vertices) v.normalize();
  std::vector<Eigen::Vector3i> faces{{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                                     {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                                     {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                                     {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
  for (int l = 0; l < level; ++l) {
    std::map<std::pair<int, int>, int> middle;
    const auto split = [&](int a, int b) {
      const auto [at, is_new] = middle.try_emplace(std::minmax(a, b), int(vertices.size()));
      if (is_new) vertices.push_back((vertices[size_t(a)] + vertices[size_t(b)]).normalized());
      return at->second;
    };
    std::vector<Eigen::Vector3i> finer;
    for (const auto& f : faces) {
      const int a = split(f[0], f[1]), b = split(f[1], f[2]), c = split(f[2], f[0]);
      finer.insert(finer.end(), {{f[0], a, c}, {f[1], b, a}, {f[2], c, b}, {a, b, c}});
    }
    faces = finer;
  }
  Surface s;
  s.vertices.resize(Eigen::Index(vertices.size()), 3);
  for (size_t i = 0; i < vertices.size(); ++i)
    s.vertices.row(Eigen::Index(i)) = radius_m * vertices[i].transpose();
  s.triangles.resize(Eigen::Index(faces.size()), 3);
  for (size_t i = 0; i < faces.size(); ++i) s.triangles.row(Eigen::Index(i)) = faces[i].transpose();
  return s;
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
