#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "data/generators/structured_block.hpp"
#include "libfem/mesh/grade/smooth_surface.hpp"
#include "libfit/core/error.hpp"
#include "tests/libfem/mesh/grade/bodies_for_tests.hpp"

namespace palpate::fem {
namespace {

Vec3 random_direction(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return Vec3(normal(random), normal(random), normal(random)).normalized();
}

TEST(NormalGradient, sphere_has_minus_one_over_radius_on_tangents_and_none_along_the_normal) {
  const double radius = 0.05;
  const SmoothSurface sphere(icosphere(3, radius));
  std::mt19937 random(2);
  double worst = 0;
  for (int repeat = 0; repeat < 50; ++repeat) {
    const SurfaceHit hit = sphere.closest(radius * random_direction(random));
    const Mat3 gradient = sphere.normal_gradient(hit, 0.01);
    const Mat3 exact = -(Mat3::Identity() - hit.normal * hit.normal.transpose()) / radius;
    worst = std::max(worst, (gradient - exact).norm() * radius);
    EXPECT_LT((gradient * hit.normal).norm(), 1e-12 / radius);
    EXPECT_EQ(gradient, Mat3(gradient.transpose()));
  }
  EXPECT_LT(worst, 0.03);
}

TEST(NormalGradient, cylinder_bends_around_and_not_along) {
  const double radius = 0.03;
  const SmoothSurface body(cylinder(radius, 0.1, 50, 20));
  std::mt19937 random(4);
  std::uniform_real_distribution<double> angle(0, 6.28), height(0.02, 0.08);
  for (int repeat = 0; repeat < 30; ++repeat) {
    const double a = angle(random);
    const Vec3 out(std::cos(a), std::sin(a), 0), around(-std::sin(a), std::cos(a), 0);
    const Mat3 gradient =
        body.normal_gradient(body.closest(radius * out + Vec3(0, 0, height(random))), 0.008);
    EXPECT_NEAR(around.dot(gradient * around) * radius, -1, 0.03) << "seed 4, angle " << a;
    EXPECT_NEAR(gradient(2, 2) * radius, 0, 0.01);
    EXPECT_NEAR(around.dot(gradient.col(2)) * radius, 0, 0.01);
  }
}

TEST(NormalGradient, plane_has_none_even_beside_a_crease_and_on_few_triangles) {
  for (const int cells : {1, 20}) {
    const SmoothSurface box(
        boundary_surface(structured_block({0.1, 0.1, 0.04}, {cells, cells, 1})));
    for (const Vec3& point : {Vec3(0.05, 0.05, 0.04), Vec3(0.001, 0.06, 0.04)})
      EXPECT_LT(box.normal_gradient(box.closest(point), 0.01).norm(), 1e-8) << cells << " cells";
  }
}

TEST(NormalGradient, noise_of_a_tenth_of_a_millimetre_costs_a_tenth_of_the_curvature) {
  const double radius = 0.05, noise_m = 1e-4;
  std::mt19937 random(9);
  std::normal_distribution<double> noise(0, noise_m);
  Surface rough = icosphere(4, radius);  // 2 mm edges
  for (Eigen::Index v = 0; v < rough.vertices.rows(); ++v)
    rough.vertices.row(v) *= 1 + noise(random) / radius;
  const SmoothSurface sphere(rough);
  double sum = 0;
  const int repeats = 100;
  for (int repeat = 0; repeat < repeats; ++repeat) {
    const SurfaceHit hit = sphere.closest(radius * random_direction(random));
    const Mat3 exact = -(Mat3::Identity() - hit.normal * hit.normal.transpose()) / radius;
    sum += (sphere.normal_gradient(hit, 0.012) - exact).squaredNorm() * radius * radius;
  }
  const double rms = std::sqrt(sum / repeats);
  EXPECT_LT(rms, 0.15);
}

}  // namespace
}  // namespace palpate::fem
