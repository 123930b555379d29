#pragma once

// Bodies in closed form with the curves of the separable law.

#include <Eigen/Geometry>

#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <vector>

#include "libfit/core/curves.hpp"
#include "libfit/core/samples.hpp"

namespace palpate::test {

/// Curves at a point of the body: f^z, f^r and L as functions of depth or offset [m] -> [N].
struct PointCurves {
  std::function<double(double)> normal, lateral, limit;
};

/// Piecewise linear through the functions' values on `pieces` equal pieces up to range_m.
inline void set_curves(Model& model, const std::function<PointCurves(const Vec3&)>& curves,
                       double range_m, int pieces) {
  const Eigen::Index vertices = model.surface.vertices.rows();
  CurveBasis basis{1, {}};
  for (int i = 0; i <= pieces; ++i) basis.knots_m.push_back(range_m * i / pieces);
  for (std::size_t kind = 0; kind < kCurveKinds; ++kind) {
    model.curves.basis[kind] = basis;
    model.curves.control[kind] = Controls::Zero(vertices, basis.size());
  }
  for (Eigen::Index v = 0; v < vertices; ++v) {
    const PointCurves f = curves(model.surface.vertices.row(v));
    for (int j = 1; j <= pieces; ++j) {
      const double x = basis.knots_m[static_cast<std::size_t>(j)];
      model.curves.control[0](v, j) = f.normal(x);
      model.curves.control[1](v, j) = f.lateral(x);
      model.curves.control[2](v, j) = f.limit(x);
    }
  }
  model.is_covered.assign(static_cast<std::size_t>(vertices), 1);
}

/// k d, k_r d and mu k d: the same everywhere.
inline std::function<PointCurves(const Vec3&)> uniform(double k_N_m, double lateral_N_m,
                                                       double mu) {
  return [=](const Vec3&) {
    return PointCurves{[=](double x) { return k_N_m * x; },
                       [=](double x) { return lateral_N_m * x; },
                       [=](double x) { return mu * k_N_m * x; }};
  };
}

/// The reference cylinder: R 30 mm, L 100 mm, around x along x 2 triangles, open ends.
inline Surface cylinder_surface(int around = 25, int along = 10) {
  Surface surface;
  surface.vertices.resize(around * (along + 1), 3);
  surface.triangles.resize(around * along * 2, 3);
  for (int j = 0; j <= along; ++j)
    for (int i = 0; i < around; ++i) {
      const double angle = 2 * std::numbers::pi * i / around;
      surface.vertices.row(j * around + i) << 0.03 * std::cos(angle), 0.03 * std::sin(angle),
          0.1 / along * j;
    }
  for (int j = 0; j < along; ++j)
    for (int i = 0; i < around; ++i) {
      const int a = j * around + i, b = j * around + (i + 1) % around;
      surface.triangles.row(2 * a) << a, b, b + around;
      surface.triangles.row(2 * a + 1) << a, b + around, a + around;
    }
  return surface;
}

/// f^z = k d^2 / 10 mm, f^r = k_r d, L = mu(d) f^z.
inline double cylinder_normal_N_m(const Vec3& x) {
  return 400 * (1 + 0.3 * x[0] / std::hypot(x[0], x[1]) +
                0.2 * std::sin(2 * std::numbers::pi * x[2] / 0.1));
}
inline double cylinder_lateral_N_m(const Vec3& x) {
  return 300 * (1 + 0.25 * x[1] / std::hypot(x[0], x[1])) * (1 + 0.1 * x[2] / 0.1);
}
inline double cylinder_friction(double depth_m) { return 0.2 + 0.2 / (1 + depth_m / 0.004); }

inline Model cylinder_model() {
  Model model;
  model.surface = cylinder_surface();
  model.inward_normal = Points::Zero(model.surface.vertices.rows(), 3);
  model.inward_normal.leftCols(2) = -model.surface.vertices.leftCols(2).rowwise().normalized();
  constexpr double kRange_m = 0.008;
  const auto normal_N = [](const Vec3& x, double d) {
    return cylinder_normal_N_m(x) * d * d / 0.01;
  };
  set_curves(
      model,
      [&](const Vec3& x) {
        const double lateral = cylinder_lateral_N_m(x);
        return PointCurves{[=](double d) { return normal_N(x, d); },
                           [=](double d) { return lateral * d; },
                           [=](double d) { return cylinder_friction(d) * normal_N(x, d); }};
      },
      kRange_m, 200);
  model.curves.basis[0] = {2, {0, kRange_m}};  // a parabola exactly
  model.curves.control[0] = Controls::Zero(model.surface.vertices.rows(), 3);
  for (Eigen::Index v = 0; v < model.surface.vertices.rows(); ++v)
    model.curves.control[0](v, 2) = normal_N(model.surface.vertices.row(v), kRange_m);
  return model;
}

/// A closed sphere about the origin: `rings` bands between the poles, twice as many around.
inline Model sphere_model(double radius_m, int rings,
                          const std::function<PointCurves(const Vec3&)>& curves) {
  const int around = 2 * rings;
  Model model;
  model.surface.vertices.resize(around * (rings - 1) + 2, 3);
  for (int j = 1; j < rings; ++j)
    for (int i = 0; i < around; ++i) {
      const double polar = std::numbers::pi * j / rings,
                   angle = 2 * std::numbers::pi * (i + 0.5 * (j % 2)) / around;
      model.surface.vertices.row((j - 1) * around + i) << std::sin(polar) * std::cos(angle),
          std::sin(polar) * std::sin(angle), std::cos(polar);
    }
  const int north = around * (rings - 1), south = north + 1;
  model.surface.vertices.row(north) << 0, 0, 1;
  model.surface.vertices.row(south) << 0, 0, -1;
  model.inward_normal = -model.surface.vertices.rowwise().normalized();
  model.surface.vertices *= radius_m;
  std::vector<Eigen::Vector3i> triangles;
  for (int i = 0; i < around; ++i) {
    const int next = (i + 1) % around, last = (rings - 2) * around;
    triangles.emplace_back(north, i, next);
    triangles.emplace_back(south, last + next, last + i);
    for (int j = 0; j + 2 < rings; ++j) {
      const int a = j * around + i, b = j * around + next, c = a + around, d = b + around;
      if (j % 2) {  // this ring (j + 1) is even: not shifted against the one before
        triangles.emplace_back(a, c, b);
        triangles.emplace_back(b, c, d);
      } else {
        triangles.emplace_back(a, c, d);
        triangles.emplace_back(a, d, b);
      }
    }
  }
  model.surface.triangles.resize(static_cast<Eigen::Index>(triangles.size()), 3);
  for (std::size_t t = 0; t < triangles.size(); ++t)
    model.surface.triangles.row(static_cast<Eigen::Index>(t)) = triangles[t].transpose();
  set_curves(model, curves, 0.01, 8);
  return model;
}

/// One everywhere: the scale of a body that is even.
inline double even(const Vec3&) { return 1; }

/// A square plate in z = 0 of `cells` x `cells` x 2 triangles, outward +z.
inline Model plate_model(double side_m, int cells,
                         const std::function<PointCurves(const Vec3&)>& curves) {
  Model model;
  const int row = cells + 1;
  model.surface.vertices = Points::Zero(row * row, 3);
  model.surface.triangles.resize(2 * cells * cells, 3);
  for (int j = 0; j < row; ++j)
    for (int i = 0; i < row; ++i)
      model.surface.vertices.row(j * row + i) << side_m * i / cells - side_m / 2,
          side_m * j / cells - side_m / 2, 0;
  for (int j = 0; j < cells; ++j)
    for (int i = 0; i < cells; ++i) {
      const int a = j * row + i;
      model.surface.triangles.row(2 * (j * cells + i)) << a, a + 1, a + row + 1;
      model.surface.triangles.row(2 * (j * cells + i) + 1) << a, a + row + 1, a + row;
    }
  model.inward_normal = Points::Zero(row * row, 3);
  model.inward_normal.col(2).setConstant(-1);
  set_curves(model, curves, 0.01, 8);
  return model;
}

inline Model plate() { return plate_model(0.08, 16, uniform(400, 300, 0.3)); }

/// A plate whose sides rise by `slope_rad` from a groove along y, its bottom at x = z = 0.
inline Model groove_model(double side_m, int cells, double slope_rad) {
  Model model = plate_model(side_m, cells, uniform(400, 300, 0.3));
  for (Eigen::Index v = 0; v < model.surface.vertices.rows(); ++v) {
    const double x = model.surface.vertices(v, 0), side = std::abs(x) < 1e-6 ? 0 : x > 0 ? 1 : -1;
    model.surface.vertices(v, 2) = std::tan(slope_rad) * std::abs(x);
    model.inward_normal.row(v) << side * std::sin(slope_rad), 0,
        side == 0 ? -1 : -std::cos(slope_rad);
  }
  return model;
}

/// Leaves nothing known where `is_bare` holds.
inline void uncover(Model& model, const std::function<bool(const Vec3&)>& is_bare) {
  for (Eigen::Index v = 0; v < model.surface.vertices.rows(); ++v) {
    if (!is_bare(model.surface.vertices.row(v))) continue;
    model.is_covered[static_cast<std::size_t>(v)] = 0;
    for (Controls& control : model.curves.control)
      if (control.size() > 0) control.row(v).setZero();
  }
}

/// A closed box about the origin, `cells` x `cells` x 2 triangles a side; normals of edges and
/// corners are those between their sides.
inline Model box_model(double half_m, int cells,
                       const std::function<PointCurves(const Vec3&)>& curves) {
  Model model;
  std::map<std::array<int, 3>, int> index;
  std::vector<Vec3> vertices, normals;
  std::vector<Eigen::Vector3i> triangles;
  const auto vertex = [&](const std::array<int, 3>& at) {
    const auto [found, is_new] = index.emplace(at, static_cast<int>(vertices.size()));
    if (!is_new) return found->second;
    Vec3 outward = Vec3::Zero();
    for (int k = 0; k < 3; ++k) {
      const int j = at[static_cast<std::size_t>(k)];
      outward[k] = j == 0 ? -1 : j == cells ? 1 : 0;
    }
    vertices.push_back(half_m * (2.0 / cells * Vec3(at[0], at[1], at[2]) - Vec3::Ones()));
    normals.push_back(-outward.normalized());
    return found->second;
  };
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (const int side : {0, cells})
      for (int i = 0; i < cells; ++i)
        for (int j = 0; j < cells; ++j) {
          const auto corner = [&](int di, int dj) {
            std::array<int, 3> at{};
            at[axis] = side;
            at[(axis + 1) % 3] = i + di;
            at[(axis + 2) % 3] = j + dj;
            return vertex(at);
          };
          const int a = corner(0, 0), b = corner(1, 0), c = corner(1, 1), d = corner(0, 1);
          if (side == cells) {
            triangles.emplace_back(a, b, c);
            triangles.emplace_back(a, c, d);
          } else {
            triangles.emplace_back(a, c, b);
            triangles.emplace_back(a, d, c);
          }
        }
  const auto rows = static_cast<Eigen::Index>(vertices.size());
  model.surface.vertices.resize(rows, 3);
  model.inward_normal.resize(rows, 3);
  for (Eigen::Index v = 0; v < rows; ++v) {
    model.surface.vertices.row(v) = vertices[static_cast<std::size_t>(v)].transpose();
    model.inward_normal.row(v) = normals[static_cast<std::size_t>(v)].transpose();
  }
  model.surface.triangles.resize(static_cast<Eigen::Index>(triangles.size()), 3);
  for (std::size_t t = 0; t < triangles.size(); ++t)
    model.surface.triangles.row(static_cast<Eigen::Index>(t)) = triangles[t].transpose();
  set_curves(model, curves, 0.01, 8);
  return model;
}

}  // namespace palpate::test
