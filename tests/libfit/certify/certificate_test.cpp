// What a certificate says of bodies in closed form.

#include <gtest/gtest.h>

#include <array>

#include "libfit/certify/devices.hpp"
#include "tests/libfit/certify/bodies.hpp"

namespace palpate::certify::test {
namespace {

// The paper's cylinder, R 30 mm, even: f^z = 300 N/m d, so that ring 1 is the whole bed.
Model even_cylinder(int around, double friction) {
  constexpr int kAlong = 10;
  constexpr double kRange_m = 0.0025;
  Model model;
  model.surface.vertices.resize(around * (kAlong + 1), 3);
  model.surface.triangles.resize(around * kAlong * 2, 3);
  for (int j = 0; j <= kAlong; ++j)
    for (int i = 0; i < around; ++i) {
      const double angle = 2 * std::numbers::pi * i / around;
      model.surface.vertices.row(j * around + i) << 0.03 * std::cos(angle), 0.03 * std::sin(angle),
          0.01 * j;
    }
  for (int j = 0; j < kAlong; ++j)
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

// With the tool 2.5 mm deep the contact point goes over a facet that is 1 / (1 - d/R) times as long
// as the tool's way.
TEST(certificate, an_even_cylinder_needs_the_tangent_of_the_angle_between_normal_and_facet) {
  for (const int around : {25, 50, 100}) {
    const Loaded body = load(even_cylinder(around, 0.3));
    double bound = 0, found = 0;
    ElementOptions options;
    options.far = 0;
    for (int t = 8 * around; t < 8 * around + 8; ++t) {  // far from the open ends
      const Sliding sliding = certify_sliding(body.asset, t, OtherRings::any, options);
      bound = std::max(bound, sliding.ratio * sliding.friction);
      found = std::max(found, sliding.worst_found * sliding.friction);
    }
    const double mu = std::tan(std::numbers::pi / around) / (1 - 2.5 / 30);  // 0.138, 0.069, 0.034
    EXPECT_NEAR(found, mu, 0.02 * mu) << around;
    EXPECT_GT(bound, found) << around;
    EXPECT_LT(bound, 1.12 * mu) << around;
  }
}

}  // namespace
}  // namespace palpate::certify::test
