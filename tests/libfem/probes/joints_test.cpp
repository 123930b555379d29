#include <gtest/gtest.h>

#include <cmath>

#include "probe_cases.hpp"

namespace palpate::fem {
namespace {

/// Jumps of distance, gradient and hessian from one side of a place to the other.
struct Jump {
  double distance, gradient, hessian;
};

Jump jump_across(const Probe& probe, const Vec3& place, const Vec3& across) {
  const SignedDistance a = probe.distance(Vec3::UnitZ(), place - across);
  const SignedDistance b = probe.distance(Vec3::UnitZ(), place + across);
  return {std::abs(a.distance_m - b.distance_m), (a.gradient - b.gradient).norm(),
          (a.hessian - b.hessian).norm()};
}

/// C1: only the hessian may jump. curvature_1_m: what it jumps by.
void expect_smooth(const Probe& probe, const Vec3& place, const Vec3& direction,
                   double curvature_1_m) {
  const double step = 1e-9;
  const Jump jump = jump_across(probe, place, step * direction.normalized());
  EXPECT_LE(jump.distance, 3 * step);
  EXPECT_LE(jump.gradient, 4 * step * (curvature_1_m + 1 / place.norm()));
  EXPECT_NEAR(jump.hessian, curvature_1_m, 0.01 * curvature_1_m + 1e-3);
}

TEST(Joints, the_fillet_of_a_flat_meets_end_and_wall_with_one_normal) {
  const Probe flat =
      make_probe(spec_of("flat", {{"radius", {0.006}}, {"edge_radius", {0.001}}}), "t");
  for (const double away : {-0.0005, 0.0, 0.0005}) {  // inside, on, outside
    const double r = 0.001 + away;
    expect_smooth(flat, Vec3(0.005, 0, away), Vec3::UnitX(), 1 / r);
    expect_smooth(flat, Vec3(0.006 + away, 0, -0.001), Vec3::UnitZ(), 1 / r);
  }
}

TEST(Joints, a_flat_is_known_in_numbers) {
  const Probe flat =
      make_probe(spec_of("flat", {{"radius", {0.006}}, {"edge_radius", {0.001}}}), "t");
  const auto distance = [&](double x, double z) {
    return flat.distance(Vec3::UnitZ(), Vec3(x, 0, z)).distance_m;
  };
  EXPECT_NEAR(distance(0.003, 0.002), 0.002, 1e-15);
  EXPECT_NEAR(distance(0.003, -0.0005), -0.0005, 1e-15);
  EXPECT_NEAR(distance(0.008, -0.5), 0.002, 1e-15);
  EXPECT_NEAR(distance(0.008, 0.003), 0.004,
              1e-15);  // 3-4-5 from the fillet's centre, less its radius
}

TEST(Joints, a_cones_tip_meets_its_flank_with_one_normal) {
  const double alpha = 0.5, t = 0.001;
  const Probe cone =
      make_probe(spec_of("cone", {{"half_angle", {alpha}}, {"tip_radius", {t}}}), "t");
  const Vec3 flank(std::sin(alpha), 0, -std::cos(alpha)),
      normal(std::cos(alpha), 0, std::sin(alpha));
  for (const double away : {-0.0003, 0.0, 0.0005})
    expect_smooth(cone, -t * Vec3::UnitZ() + (t + away) * normal, flank, 1 / (t + away));
  // Up the flank the distance is that to a straight line.
  const Vec3 on = -t * Vec3::UnitZ() + t * normal + 0.02 * flank;
  EXPECT_NEAR(cone.distance(Vec3::UnitZ(), on).distance_m, 0, 1e-16);
  EXPECT_NEAR(cone.distance(Vec3::UnitZ(), on + 0.004 * normal).distance_m, 0.004, 1e-16);
}

TEST(Joints, a_capsules_seam_has_one_normal) {
  ProbeSpec spec = spec_of("capsule", {{"radius", {0.004}}, {"length", {0.02}}});
  for (const double away : {-0.001, 0.0, 0.002}) {
    const double r = 0.004 + away;
    expect_smooth(make_probe(spec, "t"), Vec3(r, 0, -0.004), Vec3::UnitZ(), 1 / r);
  }
  spec.orientation = Vec3::UnitX();
  const Probe lying = make_probe(spec, "t");
  expect_smooth(lying, Vec3(0.006, 0, 0), Vec3::UnitX(), 1 / 0.004);
  EXPECT_NEAR(lying.distance(Vec3::UnitZ(), Vec3(0.006, 0, 0)).distance_m, 0, 1e-15);
  EXPECT_NEAR(lying.distance(Vec3::UnitZ(), Vec3(0.010, 0, -0.004)).distance_m, 0, 1e-15);
  EXPECT_NEAR(lying.distance(Vec3::UnitZ(), Vec3(0, 0.006, -0.004)).distance_m, 0.002, 1e-15);
}

}  // namespace
}  // namespace palpate::fem
