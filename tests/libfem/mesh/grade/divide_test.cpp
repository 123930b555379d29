#include "libfem/mesh/grade/smooth_surface.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>

#include "bodies_for_tests.hpp"
#include "libfit/core/closest_point.hpp"
#include "tests/support/surfaces.hpp"

namespace palpate::fem {
namespace {

using testing_support::coarse_block;

double smallest_angle(const Surface& surface) {
  double least = 4;
  for (const auto& t : surface.triangles.rowwise())
    for (int k = 0; k < 3; ++k) {
      const Vec3 p = surface.vertices.row(t[k]);
      const Vec3 a = surface.vertices.row(t[(k + 1) % 3]).transpose() - p,
                 b = surface.vertices.row(t[(k + 2) % 3]).transpose() - p;
      least = std::min(least, std::acos(a.normalized().dot(b.normalized())));
    }
  return least;
}

void expect_closed(const Surface& surface) {
  std::map<std::pair<int, int>, int> sides;
  for (const auto& t : surface.triangles.rowwise())
    for (int k = 0; k < 3; ++k) sides[{t[k], t[(k + 1) % 3]}] += 1;
  for (const auto& [side, count] : sides) {
    EXPECT_EQ(count, 1);
    EXPECT_TRUE(sides.contains({side.second, side.first}));
  }
}

// How far the middles of edges that come above z = 0 are from their place on a sphere [m].
double farthest_middle_m(const Surface& surface, double radius_m) {
  double most = 0;
  for (const auto& t : surface.triangles.rowwise())
    for (int k = 0; k < 3; ++k) {
      const Vec3 a = surface.vertices.row(t[k]), b = surface.vertices.row(t[(k + 1) % 3]);
      if (std::max(a[2], b[2]) > 0)
        most = std::max(most, std::abs(((a + b) / 2).norm() - radius_m));
    }
  return most;
}

TEST(Dividing, keeps_the_shape_closed_and_the_angles_and_leaves_what_is_far) {
  const Surface block = coarse_block(0.08, 0.08, 0.03);
  const Vec3 top(0.04, 0.04, 0.03);
  const Surface fine = divided_near(block, top, 0.015, 0.004);
  EXPECT_NEAR(volume_m3(fine), volume_m3(block), 1e-15);
  EXPECT_NEAR(area_m2(fine), area_m2(block), 1e-15);
  expect_closed(fine);
  std::size_t in_window = 0;
  for (const auto& t : fine.triangles.rowwise()) {
    Vec3 place[3];
    for (int k = 0; k < 3; ++k) place[k] = fine.vertices.row(t[k]);
    const Vec3 w = nearest_weights(top, place[0], place[1], place[2]);
    if ((w[0] * place[0] + w[1] * place[1] + w[2] * place[2] - top).norm() > 0.015) continue;
    ++in_window;
    for (int k = 0; k < 3; ++k)
      EXPECT_LE((place[k] - place[(k + 1) % 3]).norm(), 0.004 * (1 + 1e-12));
  }
  EXPECT_GT(in_window, 80u);
  EXPECT_GE(smallest_angle(fine), 0.5 * smallest_angle(block));
  EXPECT_LT(fine.triangles.rows(), 3 * static_cast<Eigen::Index>(in_window)) << "far ones stay";
  EXPECT_EQ(divided_near(block, top, 0.015, 1).triangles.rows(), 12);
}

// Of a sphere: a chord of length e lies e^2/8R below it.
TEST(Dividing, comes_to_the_smooth_surface_where_it_is_asked_to) {
  constexpr double kRadius_m = 0.05, kSagitta_m = 1e-4;
  const Surface coarse = icosphere(2, kRadius_m);
  EXPECT_GT(farthest_middle_m(coarse, kRadius_m), 5 * kSagitta_m);
  const auto is_above = [](std::int32_t, const Vec3& a, const Vec3& b, const Vec3& c) {
    return std::max({a[2], b[2], c[2]}) > 0;
  };
  const Surface fine = divided(SmoothSurface(coarse), is_above, {.sagitta_m = kSagitta_m});
  expect_closed(fine);
  EXPECT_TRUE(fine.vertices.topRows(coarse.vertices.rows()) == coarse.vertices);
  EXPECT_LT(farthest_middle_m(fine, kRadius_m), 1.5 * kSagitta_m);
  Eigen::Index below = 0;
  for (const auto& t : fine.triangles.rowwise())
    below += std::max({fine.vertices(t[0], 2), fine.vertices(t[1], 2), fine.vertices(t[2], 2)}) <
             -0.2 * kRadius_m;
  EXPECT_LT(below, coarse.triangles.rows() / 2) << "what is not asked for stays";
  EXPECT_GT(fine.triangles.rows(), 2 * coarse.triangles.rows());
}

TEST(Dividing, leaves_a_flat_end_flat_and_its_crease_where_it_is) {
  constexpr double kRadius_m = 0.02, kLength_m = 0.05;
  const Surface coarse = cylinder(kRadius_m, kLength_m, 12, 4);
  const auto all = [](std::int32_t, const Vec3&, const Vec3&, const Vec3&) { return true; };
  const Surface fine = divided(SmoothSurface(coarse), all, {.sagitta_m = 1e-4});
  expect_closed(fine);
  EXPECT_GT(fine.vertices.rows(), coarse.vertices.rows());
  EXPECT_NEAR(fine.vertices.col(2).maxCoeff(), kLength_m, 1e-15);
  EXPECT_NEAR(fine.vertices.col(2).minCoeff(), 0, 1e-15);
  for (const auto& p : fine.vertices.rowwise())
    EXPECT_LT(p.head<2>().norm(), kRadius_m * (1 + 1e-3));
}

}  // namespace
}  // namespace palpate::fem
