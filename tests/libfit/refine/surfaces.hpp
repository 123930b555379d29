#pragma once

#include <cmath>
#include <functional>
#include <vector>

#include "libfit/core/curves.hpp"
#include "libfit/core/geometry.hpp"
#include "tests/support/surfaces.hpp"

// Surfaces with closed-form normals, and curves that are linear in depth with a given stiffness.
namespace palpate::testing_refine {

using testing_support::icosphere;
using testing_support::plate;
using testing_support::sheet;
using testing_support::together;

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
