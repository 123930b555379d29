#include "libfem/mesh/grade/smooth_surface.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "data/generators/structured_block.hpp"
#include "tests/libfem/mesh/grade/bodies_for_tests.hpp"
#include "tests/support/error_of.hpp"

namespace palpate::fem {
namespace {

Vec3 random_weights(std::mt19937& random) {
  std::uniform_real_distribution<double> unit(0, 1);
  double u = unit(random), v = unit(random);
  if (u + v > 1) {
    u = 1 - u;
    v = 1 - v;
  }
  return {1 - u - v, u, v};
}

Vec3 random_point(std::mt19937& random, double half_width_m) {
  std::uniform_real_distribution<double> side(-half_width_m, half_width_m);
  return {side(random), side(random), side(random)};
}

Vec3 on_facet(const Surface& s, std::int32_t t, const Vec3& w) {
  return w[0] * s.vertices.row(s.triangles(t, 0)) + w[1] * s.vertices.row(s.triangles(t, 1)) +
         w[2] * s.vertices.row(s.triangles(t, 2));
}

// Largest distance to the sphere over random points of all triangles, of facets and when lifted.
std::pair<double, double> sphere_errors(double radius_m, int levels) {
  const SmoothSurface smooth(icosphere(levels, radius_m));
  std::mt19937 random(7);
  double flat = 0, lifted = 0;
  for (std::int32_t t = 0; t < smooth.surface().triangles.rows(); ++t)
    for (int repeat = 0; repeat < 10; ++repeat) {
      const Vec3 w = random_weights(random);
      flat = std::max(flat, std::abs(on_facet(smooth.surface(), t, w).norm() - radius_m));
      lifted = std::max(lifted, std::abs(smooth.lifted(t, w).norm() - radius_m));
    }
  return {flat, lifted};
}

TEST(SmoothSurface, sphere_is_met_far_better_than_by_facets_and_with_higher_order) {
  const double lifted2 = sphere_errors(0.05, 2).second;
  const auto [flat3, lifted3] = sphere_errors(0.05, 3);
  EXPECT_LT(lifted3, flat3 / 20);
  EXPECT_GT(lifted2 / lifted3, 6);  // third order, that of the corner normals; facets are second
}

TEST(SmoothSurface, cylinder_side_is_met_and_its_caps_stay_flat) {
  const double radius = 0.03;
  const SmoothSurface smooth(cylinder(radius, 0.1, 25, 10));
  std::mt19937 random(3);
  const double sagitta = radius * (1 - std::cos(3.14159265358979 / 25));
  double worst = 0;
  for (std::int32_t t = 0; t < smooth.surface().triangles.rows(); ++t) {
    const Vec3 w = random_weights(random);
    const Vec3 flat = on_facet(smooth.surface(), t, w), lifted = smooth.lifted(t, w);
    const bool is_cap = std::abs(flat.z()) < 1e-12 || std::abs(flat.z() - 0.1) < 1e-12;
    if (is_cap)
      EXPECT_LT((lifted - flat).norm(), 1e-16);
    else
      worst = std::max(worst, std::abs(lifted.head<2>().norm() - radius));
  }
  EXPECT_LT(worst, sagitta / 40);
}

TEST(SmoothSurface, box_with_sharp_edges_is_reproduced_exactly) {
  const SmoothSurface smooth(boundary_surface(structured_block({0.1, 0.08, 0.04}, {5, 4, 2})));
  std::mt19937 random(5);
  for (std::int32_t t = 0; t < smooth.surface().triangles.rows(); ++t) {
    const Vec3 w = random_weights(random);
    EXPECT_LT((smooth.lifted(t, w) - on_facet(smooth.surface(), t, w)).norm(), 1e-16);
    const Vec3 n = smooth.normal(t, w);
    EXPECT_NEAR(n.cwiseAbs().maxCoeff(), 1, 1e-12) << "normal " << n.transpose();
  }
}

TEST(SmoothSurface, closest_agrees_with_a_search_of_all_triangles) {
  const Surface sphere = icosphere(2, 0.05);
  const SmoothSurface smooth(sphere);
  std::mt19937 random(11);
  for (int repeat = 0; repeat < 300; ++repeat) {
    const Vec3 point = random_point(random, 0.08);
    const SurfaceHit hit = smooth.closest(point);
    EXPECT_NEAR(hit.weights.sum(), 1, 1e-12);
    EXPECT_NEAR((hit.on_facet - point).norm(), hit.distance_m, 1e-15);
    EXPECT_LT((on_facet(sphere, hit.triangle, hit.weights) - hit.on_facet).norm(), 1e-15);
    // A search that cannot be wrong: no sample of any triangle is nearer.
    for (std::int32_t t = 0; t < sphere.triangles.rows(); ++t)
      for (int k = 0; k < 4; ++k) {
        Vec3 w = Vec3::Constant(1.0 / 3);
        if (k < 3) w = Vec3::Unit(k);
        EXPECT_GE((on_facet(sphere, t, w) - point).norm(), hit.distance_m - 1e-12)
            << "seed 11, point " << point.transpose();
      }
    // Outside a convex body the nearest point is where the facet's normal points back.
    if (point.norm() > 0.05) {
      EXPECT_LT(
          (hit.on_facet + hit.distance_m * (point - hit.on_facet).normalized() - point).norm(),
          1e-12);
      EXPECT_GT(hit.normal.dot((point - hit.on_facet).normalized()), 0.9);
    }
  }
}

TEST(SmoothSurface, thin_sheet_is_never_hit_on_its_other_side) {
  const SmoothSurface sheet(boundary_surface(structured_block({0.1, 0.1, 0.001}, {10, 10, 1})));
  const Vec3 near_bottom{0.043, 0.052, 0.0001};
  EXPECT_NEAR(sheet.closest(near_bottom).position.z(), 0, 1e-15);
  const auto up = sheet.closest(near_bottom, {0, 0, 1}, 0.5);
  ASSERT_TRUE(up.has_value());
  EXPECT_NEAR(up->position.z(), 0.001, 1e-15);
  EXPECT_NEAR(up->normal.z(), 1, 1e-12);
  EXPECT_FALSE(sheet.closest(near_bottom, Vec3(1, 1, 1), 0.999).has_value());
}

TEST(SmoothSurface, creases_are_found_only_within_reach) {
  const SmoothSurface box(boundary_surface(structured_block({0.1, 0.1, 0.04}, {5, 5, 2})));
  const auto hit = box.closest_crease({0.037, 0.002, 0.041}, 0.01);
  ASSERT_TRUE(hit.has_value());
  EXPECT_LT((*hit - Vec3(0.037, 0, 0.04)).norm(), 1e-15);
  EXPECT_FALSE(box.closest_crease({0.05, 0.05, 0.04}, 0.01).has_value());
}

TEST(SmoothSurface, surfaces_without_area_are_refused) {
  EXPECT_THROW(SmoothSurface(Surface{}), Error);
  Surface flat = icosphere(0, 0.01);
  flat.vertices.setZero();
  EXPECT_THROW(SmoothSurface{flat}, Error);
}

}  // namespace
}  // namespace palpate::fem
