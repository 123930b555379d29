#pragma once

// Bodies of rings that tests certify and attack.

#include "libfit/certify/certificate.hpp"
#include "tests/libfit/runtime/models.hpp"

namespace palpate::certify::test {

using namespace palpate::test;

struct Kind {
  double friction = 1;    // of make_rings
  double unevenness = 0;  // change of stiffness in 1 cm
  double side = 0;        // of the side force against the slope of the stored energy
};

/// A smooth random field of size 1, waves of 2 to 6 cm.
inline std::function<double(const Vec3&)> waves(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> draw(-1, 1);
  std::vector<std::array<double, 4>> wave(4);
  for (auto& w : wave)
    for (double& x : w) x = draw(random);
  return [wave](const Vec3& x) {
    double sum = 0;
    for (const auto& w : wave)
      sum += 0.5 * std::sin(200 * (w[0] * x[0] + w[1] * x[1] + w[2] * x[2]) + 3 * w[3]);
    return sum;
  };
}

/// Plates (even seeds) and spheres of 6 cm (odd ones) whose stiffness waves.
inline Model random_body(unsigned seed, const Kind& kind) {
  const bool is_round = seed % 2 == 1;
  Model model = is_round ? sphere_model(0.06, 20, uniform(400, 300, 0.3))
                         : plate_model(0.08, 8, uniform(400, 300, 0.3));
  const auto wave = waves(seed);
  const auto scale = [&](const Vec3& x) { return 1 + kind.unevenness * wave(x); };
  const auto side = [&](const Vec3& x) {  // Z is about d^2 (6 + 1500 d) scale: g_2 its gradient
    constexpr double kStep_m = 1e-5;
    Vec3 slope;
    for (int k = 0; k < 3; ++k)
      slope[k] =
          (scale(x + kStep_m * Vec3::Unit(k)) - scale(x - kStep_m * Vec3::Unit(k))) / (2 * kStep_m);
    return Vec3(kind.side * 6 * slope);
  };
  make_rings(model, kind.friction, is_round ? 0.06 : 0, scale, side);
  return model;
}

/// The paper's cylinder, R 30 mm, even: f^z = 300 N/m d, so that ring 1 is the whole bed.
inline Model even_cylinder(int around, double friction, int along = 10) {
  constexpr double kRange_m = 0.0025;
  Model model;
  model.surface.vertices.resize(around * (along + 1), 3);
  model.surface.triangles.resize(around * along * 2, 3);
  for (int j = 0; j <= along; ++j)
    for (int i = 0; i < around; ++i) {
      const double angle = 2 * std::numbers::pi * i / around;
      model.surface.vertices.row(j * around + i) << 0.03 * std::cos(angle), 0.03 * std::sin(angle),
          0.1 * j / along;
    }
  for (int j = 0; j < along; ++j)
    for (int i = 0; i < around; ++i) {
      const int a = j * around + i, b = j * around + (i + 1) % around;
      model.surface.triangles.row(2 * (j * around + i)) << a, b, b + around;
      model.surface.triangles.row(2 * (j * around + i) + 1) << a, b + around, a + around;
    }
  const Eigen::Index vertices = model.surface.vertices.rows();
  model.inward_normal = Points::Zero(vertices, 3);
  model.inward_normal.leftCols(2) = -model.surface.vertices.leftCols(2).rowwise().normalized();
  model.is_covered.assign(static_cast<std::size_t>(vertices), 1);
  make_rings(model, 1, 0, [](const Vec3&) { return 1.0; });
  model.curves.basis[0] = {1, {0, kRange_m}};
  model.curves.control[0] = Controls::Zero(vertices, 2);
  for (Eigen::Index v = 0; v < vertices; ++v) {
    const Vec3 u = model.inward_normal.row(v), axis(0, 0, 1), tangent = u.cross(axis);
    model.curves.control[0](v, 1) = 300 * kRange_m;
    model.curves.control[runtime::kFriction](v, 0) = friction;
    model.curves.control[runtime::kFrictionSlope](v, 0) = 0;
    const Eigen::Matrix3d kappa = tangent * tangent.transpose() / 0.03;
    model.curves.control[runtime::kCurvature].row(v) << kappa(0, 0), kappa(1, 1), kappa(2, 2),
        kappa(0, 1), kappa(0, 2), kappa(1, 2);
  }
  return model;
}

inline Certificate certify(const Asset& asset, double radius_m = 0, int max_boxes = 400) {
  CertifyOptions options;
  options.radii_m = {radius_m};
  options.facet.max_boxes = max_boxes;
  options.continuity.walks = 20;
  return palpate::certify::certify(asset, options);
}

}  // namespace palpate::certify::test
