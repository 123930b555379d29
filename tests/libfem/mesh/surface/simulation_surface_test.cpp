#include "libfem/mesh/surface/surface.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <set>

#include "libfem/mesh/repair/facts.hpp"
#include "libfem/mesh/repair/repair_steps.hpp"
#include "libfit/core/closest_point.hpp"
#include "tests/libfem/mesh/surface/surfaces.hpp"
#include "tests/support/error_of.hpp"

namespace palpate {
namespace {

using testing::cube, testing::inside_out, testing::together, testing::moved, testing::sphere,
    testing::subdivided;

TEST(SimulationSurface, a_sphere_keeps_its_volume_within_the_tolerance) {
  const Surface fine = sphere(0.05, 5);  // 8192 triangles
  const auto result = simulation_surface(fine, 0.012, {.volume_tolerance = 0.02});
  EXPECT_EQ(why_not_closed(result.surface), std::nullopt);
  EXPECT_TRUE(repair::self_intersections(result.surface).empty());
  EXPECT_NEAR(volume_m3(result.surface) / volume_m3(fine), 1, 0.02);
  EXPECT_LT(result.surface.triangles.rows(), fine.triangles.rows() / 7);
  // An edge e of chords on a sphere strays by about e^2 / (6 R); edges reach 4/3 of the target.
  EXPECT_LT(result.deviation_m, 0.016 * 0.016 / (6 * 0.05) * 1.2);
  for (const auto& p : result.surface.vertices.rowwise()) EXPECT_NEAR(p.norm(), 0.05, 1e-4);
}

TEST(SimulationSurface, a_cube_keeps_its_edges_and_corners_exactly) {
  Surface fine = cube(0.1);
  for (int level = 0; level < 4; ++level) fine = subdivided(fine);
  const auto result = simulation_surface(fine, 0.02);
  EXPECT_EQ(result.refused, "");
  EXPECT_NEAR(volume_m3(result.surface), 1e-3, 1e-15);
  EXPECT_NEAR(result.deviation_m, 0, 1e-12);
  EXPECT_LT(result.surface.triangles.rows(), fine.triangles.rows() / 4);
  std::set<int> corners;
  for (const auto& p : result.surface.vertices.rowwise())
    for (int v = 0; v < 8; ++v)
      if ((p.transpose() - 0.1 * Vec3(v % 2, v / 2 % 2, v / 4)).norm() < 1e-12) corners.insert(v);
  EXPECT_EQ(corners.size(), 8U);
}

TEST(SimulationSurface, too_coarse_a_target_is_made_finer_and_says_why) {
  const Surface fine = sphere(0.05, 4);
  const auto result = simulation_surface(fine, 0.060, {.volume_tolerance = 0.005});
  EXPECT_NE(result.refused.find("its volume is off by -"), std::string::npos) << result.refused;
  EXPECT_NEAR(volume_m3(result.surface) / volume_m3(fine), 1, 0.005);
}

TEST(SimulationSurface, thin_plates_get_edges_of_about_their_thickness) {
  Surface plate = cube(0.1);
  plate.vertices.col(2) *= 0.06;  // 100 x 100 x 6 mm
  for (int level = 0; level < 4; ++level) plate = subdivided(plate);
  const auto result = simulation_surface(plate, 0.012);
  EXPECT_LT(mean_edge_m(result.surface), 0.008);
  EXPECT_NEAR(volume_m3(result.surface), 6e-5, 1e-16);
}

TEST(SimulationSurface, walls_around_a_lumen_get_edges_of_two_to_three_thicknesses) {
  const Surface wall = together(sphere(0.040, 5), inside_out(sphere(0.037, 5)));
  const auto result = simulation_surface(wall, 0.012);
  EXPECT_EQ(result.refused, "");
  EXPECT_NEAR(mean_edge_m(result.surface), 2.5 * 0.003, 0.5 * 0.003);
  EXPECT_LT(result.deviation_m, 0.3 * 0.003);
}

TEST(SimulationSurface, thin_walls_are_coarser_away_from_the_region) {
  const Surface wall = together(sphere(0.040, 5), inside_out(sphere(0.038, 5)));
  const auto heights_m = [&](const Eigen::VectorXd& from_region_m) -> Eigen::ArrayXd {
    return simulation_surface(wall, 0.012, {.from_region_m = from_region_m})
        .surface.vertices.col(2);
  };
  const Eigen::ArrayXd even_m = heights_m({}),
                       graded_m = heights_m((0.035 - wall.vertices.col(2).array()).max(0));
  EXPECT_GE((graded_m > 0.036).count(), 0.9 * (even_m > 0.036).count());
  EXPECT_LT(2 * (graded_m < 0).count(), (even_m < 0).count());
}

TEST(SimulationSurface, the_same_input_gives_the_same_bits) {
  const Surface fine = sphere(0.05, 4);
  const auto a = simulation_surface(fine, 0.012), b = simulation_surface(fine, 0.012);
  EXPECT_EQ(a.surface.vertices, b.surface.vertices);
  EXPECT_EQ(a.surface.triangles, b.surface.triangles);
}

TEST(SimulationSurface, bad_input_is_refused) {
  const auto fact = [](const Surface& surface, double edge_m) {
    return testing_support::fact_of([&] { simulation_surface(surface, edge_m); });
  };
  Surface open = sphere(0.05, 2);
  open.triangles.conservativeResize(open.triangles.rows() - 1, 3);
  EXPECT_EQ(fact(open, 0.01), "it bounds no volume: 3 edges lie on a border");
  const Surface crossing = together(sphere(0.05, 3), moved(sphere(0.05, 3), Vec3(0.04, 0.01, 0)));
  EXPECT_TRUE(fact(crossing, 0.012).starts_with("it crosses itself")) << fact(crossing, 0.012);
}

TEST(SimulationSurface, is_closer_where_less_is_allowed) {
  const Surface fine = sphere(0.05, 4);
  SimulationSurfaceOptions options;
  const auto off_m = [&](const SimulationSurface& made, bool is_right) {
    const BoxTree boxes = triangle_boxes(made.surface);
    double most = 0;
    for (const auto& v : fine.vertices.rowwise())
      if ((v.x() > 0.02) == is_right)
        most = std::max(most, closest_point(made.surface, boxes, v.transpose())->distance_m);
    return most;
  };
  const SimulationSurface plain = simulation_surface(fine, 0.04, options);
  options.allowed_m = Eigen::VectorXd::Constant(fine.vertices.rows(), 0.02);
  for (Eigen::Index v = 0; v < fine.vertices.rows(); ++v)
    if (fine.vertices(v, 0) > 0.02) options.allowed_m[v] = 0.0008;
  const SimulationSurface closer = simulation_surface(fine, 0.04, options);
  EXPECT_GT(off_m(plain, true), 0.0016);  // or the rest says nothing
  EXPECT_LE(closer.excess, 1.1);
  EXPECT_LE(off_m(closer, true), 0.00088);
  EXPECT_GT(off_m(closer, false), 0.0016);  // and is as coarse as before elsewhere
  EXPECT_TRUE(repair::self_intersections(closer.surface).empty());
}

// A coarser ball inside another has chords that cross it; finer ones are needed there alone.
TEST(SimulationSurface, is_finer_where_it_would_cross_itself) {
  Surface hollow = sphere(0.02, 4);
  hollow.triangles.col(1).swap(hollow.triangles.col(2));
  const Vec3 aside(0.0285, 0, 0);  // leaves a wall of 1.5 mm
  const Surface fine = together(sphere(0.05, 5), moved(hollow, aside));
  const SimulationSurface made =
      simulation_surface(fine, 0.08, {.volume_tolerance = 0.2, .stray_tolerance = 1});
  EXPECT_EQ(made.refused, "");
  EXPECT_TRUE(repair::self_intersections(made.surface).empty());
  const auto count = [&](bool is_near) {
    return std::ranges::count_if(made.surface.vertices.rowwise(), [&](const auto& v) {
      return (v.norm() > 0.0499) && (v.x() > 0) == is_near;
    });
  };
  EXPECT_GT(count(true), count(false));
}

}  // namespace
}  // namespace palpate
