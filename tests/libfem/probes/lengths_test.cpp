#include <gtest/gtest.h>

#include <cmath>

#include "probe_cases.hpp"

namespace palpate::fem {
namespace {

constexpr double kPi = 3.14159265358979323846;

TEST(Lengths, a_balls_are_its_radius_and_hertzs_contact) {
  const Probe ball = make_probe(sphere_spec(0.01), "t");
  EXPECT_DOUBLE_EQ(ball.contact_radius_m(0.0004), 0.002);
  EXPECT_DOUBLE_EQ(ball.contact_reach_m(0.0004), 0.002);
  EXPECT_DOUBLE_EQ(ball.contact_radius_m(0.05), 0.01);  // never wider than itself
  for (const double depth : {0.0001, 0.001, 0.01, 0.03})
    EXPECT_DOUBLE_EQ(pressed_to(ball, depth).length_m, 0.01);
  EXPECT_EQ(ball.half_width_m, 0.01);
}

TEST(Lengths, a_flat_has_its_own_radius_at_every_depth) {
  const Probe flat =
      make_probe(spec_of("flat", {{"radius", {0.006}}, {"edge_radius", {0.0006}}}), "t");
  for (const double depth : {1e-6, 1e-3, 0.01}) {
    EXPECT_GE(flat.contact_radius_m(depth), 0.0054);
    EXPECT_LE(flat.contact_radius_m(depth), 0.006);
    EXPECT_LT(flat.mesh_length_m(depth), flat.contact_radius_m(depth));
    EXPECT_GT(flat.contact_reach_m(depth), 0.006);
    EXPECT_EQ(pressed_to(flat, depth).length_m, 0.006);
  }
}

TEST(Lengths, a_cones_contact_is_sneddons_and_its_length_grows_with_depth) {
  const double t = 1e-3, alpha = 70 * kPi / 180;
  const Probe cone =
      make_probe(spec_of("cone", {{"half_angle", {alpha}}, {"tip_radius", {t}}}), "t");
  EXPECT_NEAR(cone.contact_radius_m(1e-6) / std::sqrt(t * 1e-6), 1, 1e-3);  // a ball's at first
  const double deep =
      0.1;  // the sharp cone's with the tip far behind: the profile lies lower by a part of t
  EXPECT_NEAR(cone.contact_radius_m(deep) / (2 / kPi * deep * std::tan(alpha)), 1, 1e-3);
  EXPECT_EQ(cone.length_m, t);
  EXPECT_NEAR(pressed_to(cone, deep).length_m,
              4 / (kPi * kPi) * deep * std::pow(std::tan(alpha), 2), 2e-3);
  double before = 0;
  for (double depth = 1e-5; depth < 0.02; depth *= 1.1) {
    const double a = cone.contact_radius_m(depth);
    EXPECT_GT(a, before);
    before = a;
  }
}

TEST(Lengths, a_capsule_lying_touches_along_a_line_and_upright_is_a_ball) {
  ProbeSpec spec = spec_of("capsule", {{"radius", {0.004}}, {"length", {0.03}}});
  const Probe upright = make_probe(spec, "t");
  EXPECT_DOUBLE_EQ(upright.contact_reach_m(0.001), 0.002);
  EXPECT_DOUBLE_EQ(upright.half_width_m, 0.004);
  spec.orientation = Vec3::UnitX();
  const Probe lying = make_probe(spec, "t");
  EXPECT_DOUBLE_EQ(lying.contact_radius_m(0.001), 0.002);
  EXPECT_GE(lying.contact_reach_m(0.001), lying.mesh_length_m(0.001));
  const ContactLine line = lying.contact_line_m(Vec3::UnitZ(), 0.001);
  EXPECT_LT((line.to - Vec3(0.011, 0, 0)).norm(),
            1e-15);  // along the first direction of drags there
  EXPECT_EQ(line.from, Vec3(-line.to));
  const ContactLine none = upright.contact_line_m(Vec3::UnitZ(), 0.001);
  EXPECT_EQ(none.from, none.to);
  EXPECT_DOUBLE_EQ(lying.half_width_m, 0.015);
  EXPECT_DOUBLE_EQ(pressed_to(lying, 0.001).length_m, 0.004);
}

// From the end that goes deepest to where it is as high as the depth.
TEST(Lengths, a_capsule_that_leans_touches_along_what_has_sunk) {
  ProbeSpec spec = spec_of("capsule", {{"radius", {0.004}}, {"length", {0.03}}});
  spec.orientation = Vec3::UnitX();
  const Vec3 down = -Vec3::UnitZ();
  const Probe lying = make_probe(spec, "t");
  for (const double tilt : {0.05, -0.05, 0.3}) {
    const Probe leaning = tilted(lying, down, lean_of(tilt, 0), "t");
    const ContactLine line = leaning.contact_line_m(down, 0.001);
    EXPECT_EQ(line.from, Vec3(Vec3::Zero()));
    const double sunk = std::min(0.022, 0.001 / std::sin(std::abs(tilt)));
    EXPECT_NEAR(line.to.norm(), sunk * std::cos(tilt), 1e-9) << tilt;
    EXPECT_NEAR(line.to.z(), 0, 1e-12);
    // The capsule is as deep there, and not beyond.
    const double touch = 0.001 - sunk * std::sin(std::abs(tilt));
    EXPECT_NEAR(leaning.distance(down, line.to + (0.001 - touch) * -down).distance_m, 0,
                0.25 * 0.001)
        << tilt;
  }
}

TEST(Lengths, a_meshs_are_those_of_the_solid_it_describes) {
  ProbeSpec spec;
  spec.shape = "mesh";
  spec.mesh = ball_mesh(0.008, 4);
  spec.values["smoothing"] = {0.0005};
  const Probe ball = make_probe(spec, "t");
  for (const double depth : {0.0005, 0.001, 0.003})
    EXPECT_NEAR(ball.contact_radius_m(depth) / std::sqrt(0.008 * depth), 1, 0.15) << depth;
  EXPECT_NEAR(ball.length_m, 0.008, 0.0015);
  EXPECT_NEAR(ball.half_width_m, 0.008, 1e-6);

  spec.mesh = box_mesh(Vec3(0.004, 0.006, 0.01));
  const Probe box = make_probe(spec, "t");
  EXPECT_NEAR(box.contact_reach_m(0.001), std::hypot(0.004, 0.006), 1e-9);
  EXPECT_NEAR(box.half_width_m, std::hypot(0.004, 0.006), 1e-9);
  EXPECT_NEAR(box.contact_radius_m(0.001), std::sqrt(0.008 * 0.012 / (2 * kPi)), 1e-9);
}

}  // namespace
}  // namespace palpate::fem
