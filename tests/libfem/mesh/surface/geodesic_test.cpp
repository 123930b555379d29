#include "libfem/mesh/surface/geodesic.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/libfem/mesh/surface/surfaces.hpp"
#include "tests/support/voxels.hpp"

namespace palpate {
namespace {

SurfacePoint nearest(const Surface& surface, const Vec3& place) {
  return *closest_point(surface, triangle_boxes(surface), place);
}

TEST(Geodesic, on_a_sphere_is_the_arc) {
  const Surface ball = testing::sphere(0.05, 5);
  const Eigen::VectorXd distance = geodesic_distance_m(ball, nearest(ball, Vec3(0.01, 0.02, 1)));
  const Vec3 from = Vec3(0.01, 0.02, 1).normalized();
  double worst = 0;
  for (Eigen::Index v = 0; v < ball.vertices.rows(); ++v) {
    const double arc =
        0.05 * std::acos(std::clamp(from.dot(ball.vertices.row(v).normalized()), -1.0, 1.0));
    worst = std::max(worst, std::abs(distance[v] - arc));
  }
  EXPECT_LT(worst, 0.02 * 0.05 * 3.1416);  // edges are 1/16 of the radius and less
}

TEST(Geodesic, goes_round_the_rim_of_a_plate_to_its_back) {
  const Surface plate =
      testing_support::voxel_surface({40, 40, 2}, 1e-3, [](const Vec3&) { return true; });
  const Eigen::VectorXd distance = geodesic_distance_m(plate, nearest(plate, {0.02, 0.02, 0.002}));
  const auto at = [&](double x, double y, double z) {
    Eigen::Index v = 0;
    (plate.vertices.rowwise() - Eigen::RowVector3d(x, y, z)).rowwise().norm().minCoeff(&v);
    return distance[v];
  };
  EXPECT_NEAR(at(0.03, 0.026, 0.002), std::hypot(0.010, 0.006), 0.4e-3) << "on the face";
  EXPECT_NEAR(at(0.02, 0.02, 0), 0.042, 1.5e-3) << "round the nearest rim";
}

TEST(Geodesic, is_infinite_where_no_way_leads) {
  const Surface one = testing::sphere(0.05, 2);
  const Surface two = testing::together(one, testing::moved(one, Vec3(0.2, 0, 0)));
  const Eigen::VectorXd distance = geodesic_distance_m(two, nearest(two, Vec3::Zero()));
  EXPECT_TRUE(std::isfinite(distance[0]));
  EXPECT_TRUE(std::isinf(distance[distance.size() - 1]));
}

}  // namespace
}  // namespace palpate
