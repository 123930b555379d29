// The force of a half-space whose surface has the body's shape, against closed forms.

#include "libfit/refine/interpolation.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "tests/libfit/refine/blending.hpp"

namespace palpate::testing_refine {
namespace {

constexpr double kBall_m = 0.008;

// Predictions of the gap at a vertex, for presses up to deepest_m.
GapForces gap_at(const Surface& surface, Eigen::Index vertex, double deepest_m,
                 const Indenter& tool) {
  FittedCurves curves = curves_at(surface, [](const Vec3&) { return 1; });
  curves.curves.basis[0].knots_m.back() = deepest_m;
  std::vector<char> is_wanted(static_cast<std::size_t>(surface.vertices.rows()), 0);
  is_wanted[static_cast<std::size_t>(vertex)] = 1;
  return gap_forces(curves, surface, vertex_normals(surface), is_wanted, {}, tool);
}
// Forces at compared depths.
Eigen::RowVectorXd forces_at(const Surface& surface, Eigen::Index vertex, double deepest_m,
                             const Indenter& tool = runtime::ball_indenter(kBall_m)) {
  return gap_at(surface, vertex, deepest_m, tool).force.at_vertex.row(vertex).array().exp();
}

constexpr int kCells = 60;
constexpr Eigen::Index kMiddle = (kCells / 2) * (kCells + 1) + kCells / 2;
Surface patch(const std::function<double(double x, double y)>& height_m, double side_m = 0.04) {
  return sheet(kCells, kCells, [&](double u, double v) {
    const double x = side_m * (u - 0.5), y = side_m * (v - 0.5);
    return Vec3(x, y, height_m(x, y));
  });
}
double flat(double, double) { return 0; }

// Hertz, of a half-space of modulus 1 under a ball of radius r.
double hertz(double r_m, double depth_m) {
  return 4.0 / 3 * std::sqrt(r_m) * std::pow(depth_m, 1.5);
}

TEST(GapForce, of_an_even_surface_is_sneddons) {
  const auto forces = forces_at(patch(flat), kMiddle, 0.004);
  for (int k = 0; k < kComparedDepths; ++k) {
    const double depth_m = 0.004 * (k + 1) / kComparedDepths;
    const double a = runtime::contact_radius_at(runtime::ball_indenter(kBall_m), depth_m);
    double sum = 0;  // Sneddon 1965: F = 2 int_0^a (d - d(x)) dx
    constexpr int kSteps = 2000;
    for (int i = 0; i < kSteps; ++i)
      sum += 2 * a / kSteps *
             (depth_m - runtime::depth_at(runtime::ball_indenter(kBall_m), a * (i + 0.5) / kSteps));
    EXPECT_NEAR(forces[k] / sum, 1, k == 0 ? 0.03 : 0.01) << "depth " << depth_m;
  }
}

TEST(GapForce, of_a_round_bump_and_hollow_is_hertzs_of_both_radii) {
  for (const double body_m : {0.05, 0.02, -0.05, -0.03}) {
    const auto bowl = [&](double x, double y) { return -(x * x + y * y) / (2 * body_m); };
    const double depth_m = 4e-4;  // shallow, as Hertz has it
    const double both_m = 1 / (1 / kBall_m + 1 / body_m);
    const double force = forces_at(patch(bowl, 0.012), kMiddle, depth_m)[kComparedDepths - 1];
    EXPECT_NEAR(force / hertz(both_m, depth_m), 1, 0.05) << "radius " << body_m;
  }
}

// Beside an even surface another ball's force grows by the root of both radii in Hertz's law, of
// which (M83a) takes the root.
TEST(GapForce, of_another_ball_on_a_bump_and_in_a_hollow_is_hertzs) {
  for (const double body_m : {1e9, 0.05, 0.02, -0.05, -0.03}) {
    const auto bowl = [&](double x, double y) { return -(x * x + y * y) / (2 * body_m); };
    const double effect = gap_at(patch(bowl, 0.012), kMiddle, 4e-4, runtime::ball_indenter(kBall_m))
                              .radius_effect[kMiddle];
    for (const double ratio : {0.5, 0.7, 1.3, 1.5})
      EXPECT_NEAR((1 + std::log(ratio) * effect) /
                      std::pow((1 + kBall_m / body_m) / (1 + ratio * kBall_m / body_m), 0.25),
                  1, 0.03)
          << "radius " << body_m << ", ratio " << ratio;
  }
}

TEST(GapForce, of_a_saddle_is_that_of_an_even_surface) {
  const auto saddle = [](double x, double y) { return (x * x - y * y) / 0.08; };
  const auto even = forces_at(patch(flat), kMiddle, 0.002),
             found = forces_at(patch(saddle), kMiddle, 0.002);
  EXPECT_LT((found.array() / even.array() - 1).abs().maxCoeff(), 0.02);
}

TEST(GapForce, scales_with_length_and_does_not_turn_with_the_body) {
  const auto wave = [](double x, double y) {
    return 5e-4 * std::sin(700 * x + 1) * std::cos(500 * y);
  };
  const Surface surface = patch(wave);
  const auto plain = forces_at(surface, kMiddle, 0.004);
  Surface large = surface;
  large.vertices *= 10;
  const auto scaled = forces_at(large, kMiddle, 0.04, runtime::ball_indenter(10 * kBall_m));
  EXPECT_LT((scaled.array() / plain.array() / 100 - 1).abs().maxCoeff(), 1e-9);
  for (const unsigned seed : {1U, 2U, 3U}) {
    std::mt19937 random(seed);
    std::normal_distribution<double> any;
    const Eigen::Quaterniond turn =
        Eigen::Quaterniond(any(random), any(random), any(random), any(random)).normalized();
    Surface turned = surface;
    turned.vertices = surface.vertices * turn.toRotationMatrix().transpose();
    turned.vertices.rowwise() += Eigen::RowVector3d(0.1, -0.2, 0.3);
    const auto found = forces_at(turned, kMiddle, 0.004);
    EXPECT_LT((found.array() / plain.array() - 1).abs().maxCoeff(), 0.01) << "seed " << seed;
  }
}

TEST(GapForce, hardly_depends_on_the_mesh) {
  const auto wave = [](double x, double y) { return 4e-4 * std::sin(400 * x) * std::cos(300 * y); };
  const Surface fine = sheet(240, 240, [&](double u, double v) {
    const double x = 0.04 * (u - 0.5), y = 0.04 * (v - 0.5);
    return Vec3(x, y, wave(x, y));
  });
  const auto coarse = forces_at(patch(wave), kMiddle, 0.004),
             found = forces_at(fine, 120 * 241 + 120, 0.004);
  EXPECT_LT((found.array() / coarse.array() - 1).abs().maxCoeff(), 0.02);
}

TEST(GapForce, knows_the_sheet_that_is_pressed_and_no_other) {
  const Surface sheet_alone = patch(flat);
  Surface above = sheet_alone;
  above.vertices.col(2).array() += 0.003;  // faces as the pressed one does
  const auto alone = forces_at(sheet_alone, kMiddle, 0.004),
             both = forces_at(together(sheet_alone, above), kMiddle, 0.004);
  EXPECT_EQ(alone, both);
}

TEST(GapForce, goes_on_past_a_border_and_falls_off_past_a_side) {
  const Surface surface = patch(flat);
  const auto middle = forces_at(surface, kMiddle, 0.004);
  EXPECT_LT((forces_at(surface, 0, 0.004).array() / middle.array() - 1).abs().maxCoeff(), 1e-6);
  // A bar of 6 mm, round on top: the ball hangs over both sides.
  const Surface bar = cylinder(48, 60, 0.003, 0.04);
  EXPECT_LT(forces_at(bar, 30, 0.004)[kComparedDepths - 1], 0.7 * middle[kComparedDepths - 1]);
}

TEST(GapForce, is_finite_in_a_pit_and_rises) {
  const Surface pit =
      patch([](double x, double y) { return 2 * std::hypot(x, y); });  // steeper than the ball
  const auto found = forces_at(pit, kMiddle, 0.004);
  EXPECT_TRUE(found.allFinite());
  EXPECT_GT(found[0], forces_at(patch(flat), kMiddle, 0.004)[0]);
  for (int k = 1; k < kComparedDepths; ++k) EXPECT_GT(found[k], found[k - 1]);
}

TEST(GapForce, of_a_rod_that_ends_flat_is_proportional_to_depth) {
  Indenter rod;  // even to 3 mm, then steep
  rod.points = 3;
  rod.r_m[1] = 0.003, rod.r_m[2] = 0.0030001;
  rod.slope[2] = 10;
  const auto forces = forces_at(patch(flat), kMiddle, 0.002, rod);
  for (int k = 0; k < kComparedDepths; ++k)  // 2 a d: a punch (Boussinesq)
    EXPECT_NEAR(forces[k] / (2 * 0.97 * 0.003 * 0.002 * (k + 1) / kComparedDepths), 1, 0.02);
}

}  // namespace
}  // namespace palpate::testing_refine
