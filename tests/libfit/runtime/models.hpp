#pragma once

// What the engine's tests make of bodies in closed form, and the tools that touch them.

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include "libfit/assets/asset_bytes.hpp"
#include "libfit/runtime/engine.hpp"
#include "tests/libfit/runtime/plain_models.hpp"

namespace palpate::test {

using runtime::Asset;
using runtime::Contact;
using runtime::ContactState;
using runtime::Output;
using runtime::Status;

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
