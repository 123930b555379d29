#include "libfit/core/closest_point.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <limits>
#include <random>

#include "tests/libfit/refine/surfaces.hpp"

namespace palpate {
namespace {

using testing_refine::icosphere;

Vec3 random_point(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return {normal(random), normal(random), normal(random)};
}

TEST(nearest_on_triangle, no_sample_of_the_triangle_is_nearer) {
  for (unsigned seed = 1; seed <= 200; ++seed) {
    std::mt19937 random(seed);
    const Vec3 a = random_point(random), b = random_point(random);
    Vec3 c = random_point(random);
    if (seed % 4 == 0) c = a + 1.7 * (b - a);  // flat
    if (seed % 10 == 0) c = a;
    const Vec3 p = 2 * random_point(random);
    const SurfacePoint hit = nearest_on_triangle(p, a, b, c);
    EXPECT_NEAR(hit.weight.sum(), 1, 1e-15);
    EXPECT_GE(hit.weight.minCoeff(), 0);
    const Vec3 foot = hit.weight[0] * a + hit.weight[1] * b + hit.weight[2] * c;
    EXPECT_NEAR((foot - p).norm(), hit.distance_m, 1e-12) << "seed " << seed;
    EXPECT_EQ(foot, hit.position);
    for (int i = 0; i <= 40; ++i)
      for (int j = 0; i + j <= 40; ++j)
        EXPECT_LE(hit.distance_m, (a + (b - a) * i / 40 + (c - a) * j / 40 - p).norm() + 1e-12)
            << "seed " << seed;
  }
}

TEST(closest_point, finds_what_trying_all_triangles_finds) {
  const Surface sphere = icosphere(3, 1);
  const BoxTree boxes = triangle_boxes(sphere);
  std::mt19937 random(11);
  for (int i = 0; i < 300; ++i) {
    const Vec3 p = i == 0 ? Vec3::Zero() : Vec3(random_point(random));
    const auto upper = [&](const SurfacePoint& at) {
      return i % 2 == 0 || sphere.vertices(sphere.triangles(at.triangle, 0), 2) > 0;
    };
    SurfacePoint best;
    double squared_best = std::numeric_limits<double>::infinity();
    for (std::int32_t t = 0; t < sphere.triangles.rows(); ++t) {
      SurfacePoint point = nearest_on_triangle(p, sphere.vertices.row(sphere.triangles(t, 0)),
                                               sphere.vertices.row(sphere.triangles(t, 1)),
                                               sphere.vertices.row(sphere.triangles(t, 2)));
      point.triangle = t;
      const double squared = (point.position - p).squaredNorm();
      if (!(squared < squared_best) || !upper(point)) continue;
      squared_best = squared;
      best = point;
    }
    const auto hit = closest_point(sphere, boxes, p, 100, upper);
    ASSERT_TRUE(hit);
    EXPECT_EQ(hit->triangle, best.triangle) << "seed 11, query " << i;
    EXPECT_EQ(hit->distance_m, best.distance_m);
    EXPECT_EQ(hit->weight, best.weight);
    EXPECT_FALSE(closest_point(sphere, boxes, p, best.distance_m * 0.999, upper));
  }
}

TEST(closest_point, an_empty_surface_has_no_nearest_triangle) {
  const Surface empty;
  EXPECT_FALSE(closest_point(empty, triangle_boxes(empty), Vec3::Zero()));
  EXPECT_FALSE(ray_distance_m(empty, triangle_boxes(empty), Vec3::Zero(), Vec3::UnitX(), 0));
}

TEST(closest_point, of_two_as_near_the_lower_triangle_answers) {
  const Surface sphere = icosphere(1, 1);
  const BoxTree boxes = triangle_boxes(sphere);
  for (Eigen::Index v = 0; v < sphere.vertices.rows(); ++v) {
    const auto hit = closest_point(sphere, boxes, sphere.vertices.row(v));
    ASSERT_TRUE(hit);
    EXPECT_EQ(hit->distance_m, 0);
    Eigen::Index lowest = 0;
    while (!(sphere.triangles.row(lowest).array() == v).any()) ++lowest;
    EXPECT_EQ(hit->triangle, lowest);
  }
}

TEST(closest_point, a_place_that_is_no_number_has_none) {
  const Surface sphere = icosphere(1, 1);
  const Vec3 nowhere = Vec3::Constant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_FALSE(closest_point(sphere, triangle_boxes(sphere), nowhere));
}

TEST(ray_distance, finds_what_trying_all_triangles_finds) {
  const Surface sphere = icosphere(2, 1);
  const BoxTree boxes = triangle_boxes(sphere);
  std::mt19937 random(3);
  int met = 0;
  for (int i = 0; i < 300; ++i) {
    const Vec3 origin = 0.8 * random_point(random), direction = random_point(random).normalized();
    const double skip = i % 3 == 0 ? 0.1 : 0;
    double first = std::numeric_limits<double>::infinity();
    for (std::int32_t t = 0; t < sphere.triangles.rows(); ++t) {
      Mat3 columns;  // origin + s direction = a + v (b - a) + w (c - a)
      const Vec3 a = sphere.vertices.row(sphere.triangles(t, 0));
      columns << Vec3(sphere.vertices.row(sphere.triangles(t, 1)).transpose() - a),
          Vec3(sphere.vertices.row(sphere.triangles(t, 2)).transpose() - a), -direction;
      const Vec3 vws = columns.inverse() * (origin - a);
      if (vws[0] >= 0 && vws[1] >= 0 && vws[0] + vws[1] <= 1 && vws[2] >= skip)
        first = std::min(first, vws[2]);
    }
    const auto hit = ray_distance_m(sphere, boxes, origin, direction, skip);
    EXPECT_EQ(hit.has_value(), std::isfinite(first)) << "seed 3, ray " << i;
    if (hit) {
      EXPECT_NEAR(*hit, first, 1e-12);
    }
    met += hit.has_value();
  }
  EXPECT_GT(met, 100);
  EXPECT_LT(met, 300);
}

TEST(ray_distance, a_ray_through_a_vertex_or_along_an_axis_does_not_slip_through) {
  const Surface sphere = icosphere(2, 1);
  const BoxTree boxes = triangle_boxes(sphere);
  for (Eigen::Index v = 0; v < sphere.vertices.rows(); ++v) {
    const Vec3 out = sphere.vertices.row(v).transpose().normalized();
    const auto hit = ray_distance_m(sphere, boxes, Vec3::Zero(), out, 1e-6);
    ASSERT_TRUE(hit) << "vertex " << v;
    EXPECT_NEAR(*hit, 1, 1e-12);
  }
  for (int axis = 0; axis < 3; ++axis)
    EXPECT_TRUE(ray_distance_m(sphere, boxes, Vec3::Zero(), Vec3::Unit(axis), 0));
}

}  // namespace
}  // namespace palpate
