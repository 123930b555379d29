#include "tests/support/bodies.hpp"

#include <cmath>
#include <numbers>
#include <random>

#include "libfit/core/error.hpp"

namespace palpate::tools {
namespace {

constexpr double kRange_m = 0.008;

double lateral_stiffness_N_m(const Vec3& x) {
  return 300 * (1 + 0.25 * x[1] / kCylinderRadius_m) * (1 + 0.1 * x[2] / kCylinderLength_m);
}
double friction(double depth_m) { return 0.2 + 0.2 / (1 + depth_m / 0.004); }

Surface cylinder(int around, int along) {
  Surface surface;
  surface.vertices.resize(around * (along + 1), 3);
  surface.triangles.resize(2 * around * along, 3);
  for (int j = 0; j <= along; ++j)
    for (int i = 0; i < around; ++i) {
      const double angle = 2 * std::numbers::pi * i / around;
      surface.vertices.row(j * around + i) << kCylinderRadius_m * std::cos(angle),
          kCylinderRadius_m * std::sin(angle), kCylinderLength_m * j / along;
    }
  for (int j = 0; j < along; ++j)
    for (int i = 0; i < around; ++i) {
      const int a = j * around + i, b = j * around + (i + 1) % around;
      surface.triangles.row(2 * a) << a, b, b + around;
      surface.triangles.row(2 * a + 1) << a, b + around, a + around;
    }
  return surface;
}

}  // namespace

double cylinder_stiffness_N_m(const Vec3& x) {
  return 400 * (1 + 0.3 * x[0] / std::hypot(x[0], x[1]) +
                0.2 * std::sin(2 * std::numbers::pi * x[2] / kCylinderLength_m));
}

Model bench_cylinder(int around, int along, int pieces, double scatter) {
  Model model;
  model.surface = cylinder(around, along);
  const Points& x = model.surface.vertices;
  model.inward_normal = Points::Zero(x.rows(), 3);
  model.inward_normal.leftCols(2) = -x.leftCols(2).rowwise().normalized();
  model.is_covered.assign(static_cast<std::size_t>(x.rows()), 1);
  std::mt19937_64 random(1);         // its numbers are the same everywhere, unlike a distribution's
  Eigen::VectorXd factor(x.rows());  // uniform of the given deviation
  for (double& each : factor)
    each = 1 + scatter * std::sqrt(12.0) * (double(random() >> 11) / 9007199254740992.0 - 0.5);
  for (std::size_t kind = 0; kind < kCurveKinds; ++kind) {
    CurveBasis& basis = model.curves.basis[kind];
    basis.degree = 3;
    for (int i = 0; i <= pieces; ++i) basis.knots_m.push_back(kRange_m * i / pieces);
    Controls& control = model.curves.control[kind] = Controls::Zero(x.rows(), basis.size());
    // Greville abscissae: the spline follows the curve to second order in the pieces' length.
    for (int j = 1; j < basis.size(); ++j) {
      double at = 0;
      for (int k = 1; k <= 3; ++k) at += kRange_m * std::clamp(j - 3 + k, 0, pieces) / pieces / 3;
      for (Eigen::Index v = 0; v < x.rows(); ++v) {
        const double normal_N = cylinder_stiffness_N_m(x.row(v)) * at * at / 0.01;
        const double force_N = kind == 0   ? normal_N
                               : kind == 1 ? lateral_stiffness_N_m(x.row(v)) * at
                                           : friction(at) * normal_N;
        control(v, j) = factor[v] * force_N;
      }
    }
  }
  return model;
}

Model with_family(Model model, CurveFamily family) {
  if (family == CurveFamily::separable) return model;
  const Points& u = model.inward_normal;
  CurveSet curves(family);
  const std::size_t kept = curves_of(family);
  for (std::size_t kind = 0; kind < kept; ++kind) {
    curves.basis[kind] = model.curves.basis[kind];
    curves.control[kind] = model.curves.control[kind];
  }
  const auto parts = parts_of(family);
  for (std::size_t part = kept; part < parts.size(); ++part)
    curves.control[part] =
        Controls::Zero(u.rows(), parts[part].width * size_of(parts[part], curves.basis[part]));
  for (Eigen::Index v = 0; v < u.rows(); ++v) {
    const Vec3 around(-u(v, 1), u(v, 0), 0);
    curves.control[runtime::kLambda](v, 0) = 0.71;
    curves.control[runtime::kFriction](v, 0) = 0.28;
    curves.control[runtime::kFrictionSlope](v, 0) = 16;
    curves.control[runtime::kSpread](v, 0) = 20;
    curves.control[runtime::kSide2].row(v) = 900 * around.transpose();
    curves.control[runtime::kSide3].row(v) = 5e4 * around.transpose();
    const Eigen::Matrix3d curvature = around * around.transpose() / kCylinderRadius_m;
    curves.control[runtime::kCurvature].row(v) << curvature(0, 0), curvature(1, 1), curvature(2, 2),
        curvature(0, 1), curvature(0, 2), curvature(1, 2);
  }
  model.curves = std::move(curves);
  return model;
}

BenchAsset make_bench_asset(const Model& model) {
  BenchAsset out{make_asset_bytes(model, {.fades_borders = false}), {}};
  runtime::Status status;
  out.asset = runtime::Asset::open(out.bytes.data(), out.bytes.size(), &status);
  if (status != runtime::Status::ok)
    throw Error("bench", std::string("the engine refuses its own body: ") + sentence(status),
                "Report this.");
  return out;
}

}  // namespace palpate::tools
