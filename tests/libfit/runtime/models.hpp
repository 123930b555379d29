#pragma once

// Models in closed form that the engine's tests export and touch.

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <random>

#include "libfit/assets/asset_bytes.hpp"
#include "libfit/core/curves.hpp"
#include "libfit/core/samples.hpp"
#include "libfit/runtime/engine.hpp"

namespace palpate::test {

using runtime::Asset;
using runtime::Contact;
using runtime::ContactState;
using runtime::Output;
using runtime::Status;

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

/// Makes a model one of rings on f^z = scale(x) (12 d + 4500 d^2) over 1 cm, lambda 0.71, gamma of
/// (15 + 5 scale(x)) / m and friction times (0.285 + 16 d/m), with the given side force g_2 [N/m^2]
/// and the curvature of a ball of radius_m about the origin (0: flat).
inline void make_rings(Model& model, double friction, double radius_m,
                       const std::function<double(const Vec3&)>& scale,
                       const std::function<Vec3(const Vec3&)>& side = nullptr) {
  constexpr double kRange_m = 0.01;
  const Eigen::Index vertices = model.surface.vertices.rows();
  CurveSet rings(CurveFamily::rings);
  rings.basis[0] = {2, {0, kRange_m}};
  for (std::size_t part = 0; part < rings.control.size(); ++part)
    rings.control[part] = Controls::Zero(
        vertices, parts_of(CurveFamily::rings)[part].width *
                      size_of(parts_of(CurveFamily::rings)[part], rings.basis[part]));
  for (Eigen::Index v = 0; v < vertices; ++v) {
    const Vec3 x = model.surface.vertices.row(v), u = model.inward_normal.row(v);
    const double here = scale(x);
    rings.control[0].row(v) << 0, here * 0.06, here * 0.57;
    rings.control[runtime::kLambda](v, 0) = 0.71;
    rings.control[runtime::kFriction](v, 0) = friction * 0.285;
    rings.control[runtime::kFrictionSlope](v, 0) = friction * 16;
    rings.control[runtime::kSpread](v, 0) = 15 + 5 * here;
    if (side) rings.control[runtime::kSide2].row(v) = side(x).transpose();
    if (radius_m == 0) continue;
    rings.control[runtime::kCurvature].row(v) =
        numbers_of((Mat3::Identity() - u * u.transpose()) / radius_m);
  }
  model.curves = std::move(rings);
}

/// Lets a body of rings sway by symmetric matrices, xx, yy, zz, xy, xz, yz [m/N].
using Symmetric = Eigen::Matrix<double, 1, 6>;
inline void set_sway(Model& model, const std::function<Symmetric(const Vec3&)>& sway) {
  Controls& control = model.curves.control[runtime::kSway];
  for (Eigen::Index v = 0; v < control.rows(); ++v)
    control.row(v) = sway(model.surface.vertices.row(v));
  control = rounded_to_float(control);
}

/// A smooth shape response of points at some vertices, which others blend by their distance: a
/// seeded dent about as deep as the press, and modes that are sines in space.
inline void make_shaped(Model& model, const std::vector<Eigen::Index>& at, int modes,
                        unsigned seed) {
  const auto points = static_cast<int>(at.size());
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> draw(-1, 1);
  ShapeResponse& shape = model.shape;
  shape.intervals = 10;
  shape.modes = modes;
  shape.depth_m = 0.005;
  shape.radius_m = 0.006;
  const Eigen::Index vertices = model.surface.vertices.rows();
  shape.point = Controls::Zero(points, runtime::shape_numbers(shape.intervals, modes));
  shape.drag = Eigen::VectorXd::Zero(runtime::shape_drag_numbers(shape.intervals));
  for (Eigen::Index i = 0; i < shape.point.size(); ++i) shape.point.data()[i] = 0.05 * draw(random);
  shape.point.rightCols(3 * modes) *= 0.01;  // by newtons
  for (Eigen::Index i = 0; i < shape.drag.size(); ++i) shape.drag[i] = 0.05 * draw(random);
  for (int j = 0; j < shape.intervals; ++j) {
    const double fall = std::exp(-0.3 * j);
    shape.point.col(j).array() += fall;
    shape.drag[j] += fall;
  }
  shape.mode = Controls::Zero(vertices, 3 * modes);
  for (Eigen::Index v = 0; v < vertices; ++v)
    for (int i = 0; i < 3 * modes; ++i)
      shape.mode(v, i) = 0.2 * std::sin(100 * (i + 1) * model.surface.vertices(v, i % 3) + i);
  shape.point = rounded_to_float(shape.point);
  shape.drag = rounded_to_float(shape.drag);
  shape.mode = rounded_to_float(shape.mode);
  model.blend_point = Triangles::Zero(vertices, 3);
  model.blend_weight = Points::Zero(vertices, 3);
  for (Eigen::Index v = 0; v < vertices; ++v) {
    std::vector<std::pair<double, int>> nearest;
    for (int p = 0; p < points; ++p) {
      const Vec3 place = model.surface.vertices.row(at[static_cast<std::size_t>(p)]),
                 x = model.surface.vertices.row(v);
      nearest.emplace_back((place - x).norm(), p);
    }
    std::sort(nearest.begin(), nearest.end());
    for (int k = 0; k < 3; ++k) {
      model.blend_point(v, k) = nearest[static_cast<std::size_t>(k)].second;
      model.blend_weight(v, k) = 1 / (1e-3 + nearest[static_cast<std::size_t>(k)].first);
    }
    if (nearest[0].first == 0) model.blend_weight.row(v) << 1, 0, 0;
    model.blend_weight.row(v) /= model.blend_weight.row(v).sum();
  }
}
/// The same of so many points all over the body.
inline void make_shaped(Model& model, int points, int modes, unsigned seed) {
  std::vector<Eigen::Index> at;
  for (int p = 0; p < points; ++p) at.push_back(p * model.surface.vertices.rows() / points);
  make_shaped(model, at, modes, seed);
}

/// An asset with its bytes.
struct Loaded {
  AssetBytes bytes;
  Asset asset;
};

inline Loaded load(const Model& model, const ExportOptions& options = {}) {
  Loaded out{make_asset_bytes(model, options), {}};
  Status status;
  out.asset = Asset::open(out.bytes.data(), out.bytes.size(), &status);
  if (status != Status::ok) throw std::runtime_error(sentence(status));
  return out;
}

/// A tip, or a ball, that remembers its contact and latest output.
struct Tool {
  const runtime::AssetView& asset;
  double radius_m, dt_s;
  Contact contact{};
  Output out{};
  Status status = Status::ok;

  explicit Tool(const runtime::AssetView& a, double radius = 0, double tick_s = 0)
      : asset(a), radius_m(radius), dt_s(tick_s) {}
  Vec3 tick(const Vec3& place_m) {  // force of the tool ON the body
    status = touch_ball(asset, contact, place_m.data(), radius_m, out, nullptr, dt_s);
    return -Vec3::Map(out.force_on_tool_N);
  }
  /// Straight on to `tip_m` in steps no longer than step_m; returns the last force on the body.
  Vec3 go(const Vec3& from_m, const Vec3& tip_m, double step_m) {
    const int steps = std::max(1, static_cast<int>(std::ceil((tip_m - from_m).norm() / step_m)));
    Vec3 force = Vec3::Zero();
    for (int i = 1; i <= steps; ++i) force = tick(from_m + (tip_m - from_m) * (double(i) / steps));
    return force;
  }
};

/// How many columns of the tangent of a tick to x are its slope by central differences; where the
/// slope changes within them (a ring begins to slip) nothing is compared.
/// tick(place, tangent): the force on the body, each time from the same state.
template <class Tick>
int expect_tangent_is_slope(const Tick& tick, const Vec3& x) {
  double tangent[9];
  tick(x, tangent);
  int compared = 0;
  for (int k = 0; k < 3; ++k) {
    const auto slope = [&](double h) {
      return Vec3((tick(x + h * Vec3::Unit(k), nullptr) - tick(x - h * Vec3::Unit(k), nullptr)) /
                  (2 * h));
    };
    const Vec3 rough = slope(1e-8), fine = slope(3e-9);
    if ((rough - fine).norm() > 1e-5 * fine.norm()) continue;
    ++compared;
    EXPECT_LT((Vec3(tangent[k], tangent[3 + k], tangent[6 + k]) - fine).norm(),
              1e-4 * (1 + fine.norm()))
        << "at " << x.transpose() << ", axis " << k;
  }
  return compared;
}

inline Vec3 drawn_vector(std::mt19937& random, double size) {
  std::uniform_real_distribution<double> share(-size, size);
  const double x = share(random), y = share(random), z = share(random);
  return {x, y, z};
}

/// Draws for one body of rings, flat or round, even or uneven: for attacks by seed.
class DrawnRings {
 public:
  explicit DrawnRings(unsigned seed)
      : is_round(seed % 2 == 1), is_rough_(seed % 3 > 0), random_(seed) {}

  const bool is_round;
  double unit() { return unit_(random_); }
  Vec3 vector(double size) {
    const double x = unit(), y = unit(), z = unit();
    return Vec3((2 * x - 1) * size, (2 * y - 1) * size, (2 * z - 1) * size);
  }
  /// Stiffness and side force change from node to node of a rough one. Highest at z top_m().
  Model model(double friction) {
    Model out = is_round ? sphere_model(0.03, 24, uniform(400, 300, 0.3))
                         : plate_model(0.08, 16, uniform(400, 300, 0.3));
    make_rings(
        out, friction, top_m(), [&](const Vec3&) { return is_rough_ ? 0.4 + 1.2 * unit() : 1; },
        [&](const Vec3&) { return Vec3(is_rough_ ? vector(500) : Vec3(0, 0, 0)); });
    return out;
  }
  double top_m() const { return is_round ? 0.03 : 0; }

 private:
  bool is_rough_;
  std::mt19937 random_;
  std::uniform_real_distribution<double> unit_{0, 1};
};

}  // namespace palpate::test
