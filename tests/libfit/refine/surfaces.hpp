#pragma once

#include <cmath>
#include <functional>
#include <map>
#include <vector>

#include "libfit/core/curves.hpp"
#include "libfit/core/geometry.hpp"

// Surfaces with closed-form normals, and curves that are linear in depth with a given stiffness.
namespace palpate::testing_refine {

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

/// Closed around its axis z (last column of cells joins the first), open at both ends, outward.
inline Surface cylinder(int around, int along, double radius_m, double length_m) {
  Surface s;
  s.vertices.resize(around * (along + 1), 3);
  s.triangles.resize(2 * around * along, 3);
  for (int i = 0; i < around; ++i)
    for (int j = 0; j <= along; ++j) {
      const double angle = 2 * M_PI * i / around;
      s.vertices.row(i * (along + 1) + j) << radius_m * std::cos(angle), radius_m * std::sin(angle),
          length_m * j / along;
    }
  int t = 0;
  for (int i = 0; i < around; ++i)
    for (int j = 0; j < along; ++j) {
      const int a = i * (along + 1) + j, b = (i + 1) % around * (along + 1) + j;
      s.triangles.row(t++) << a, b, b + 1;
      s.triangles.row(t++) << a, b + 1, a + 1;
    }
  return s;
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

using Field = std::function<double(const Vec3&)>;

/// Curves at the vertices of a coarse surface: force = field(position) per 10 mm of depth.
inline FittedCurves curves_at(const Surface& coarse, const Field& field) {
  FittedCurves f;
  f.position = coarse.vertices;
  f.normal = -vertex_normals(coarse);
  const auto points = static_cast<std::size_t>(coarse.vertices.rows());
  f.name.assign(points, "p");
  f.status.assign(points, FitStatus::good);
  f.message.assign(points, "");
  f.rms_residual_N = f.max_residual_N = f.depth_range_m =
      Eigen::VectorXd::Zero(coarse.vertices.rows());
  for (std::size_t k = 0; k < 3; ++k) {
    f.curves.basis[k] = {1, {0, 0.01}};
    f.curves.control[k] = Controls::Zero(coarse.vertices.rows(), 2);
    for (Eigen::Index i = 0; i < coarse.vertices.rows(); ++i)
      f.curves.control[k](i, 1) = static_cast<float>(field(coarse.vertices.row(i)));
  }
  return f;
}

inline std::vector<char> all(const Surface& surface) {
  return std::vector<char>(static_cast<std::size_t>(surface.vertices.rows()), 1);
}

}  // namespace palpate::testing_refine
