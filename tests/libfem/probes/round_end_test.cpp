// How tools end, found from their signed distances, against the closed forms of their shapes.

#include "libfem/probes/probes.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "libfem/probes/shapes.hpp"
#include "probe_cases.hpp"

namespace palpate::fem {
namespace {

constexpr double kPi = 3.14159265358979323846;

Probe capsule(double radius_m, double length_m, const Vec3& inward) {
  ProbeSpec spec = spec_of("capsule", {{"radius", {radius_m}}, {"length", {length_m}}});
  spec.orientation = inward;
  return make_probe(spec, "t");
}

TEST(RoundEnd, of_a_ball_is_the_ball) {
  const auto end = round_end(make_probe(sphere_spec(0.004), "t"));
  ASSERT_TRUE(end);
  EXPECT_EQ(end->round_end_m, 0.004);
  EXPECT_EQ(end->points, 0);
}

TEST(RoundEnd, of_a_cone_presses_as_sneddon_has_it) {
  for (const double alpha_deg : {30.0, 60.0, 75.0}) {
    const Probe cone = make_probe(
        spec_of("cone", {{"half_angle", {alpha_deg * kPi / 180}}, {"tip_radius", {0.001}}}), "t");
    const auto end = round_end(cone);
    ASSERT_TRUE(end) << alpha_deg;
    EXPECT_NEAR(end->round_end_m, 0.001, 1e-5);
    EXPECT_TRUE(runtime::is_possible(*end));
    for (double a = 2e-4; a < 0.03; a *= 1.4) {
      const double exact = ConeShape::depth_of(cone.geometry, a);
      EXPECT_NEAR(runtime::depth_at(*end, a), exact, 2e-3 * exact) << alpha_deg << ", " << a;
    }
  }
}

TEST(RoundEnd, of_a_rod_is_flat_up_to_its_edge) {
  const auto end =
      round_end(make_probe(spec_of("flat", {{"radius", {0.005}}, {"edge_radius", {0.0005}}}), "t"));
  ASSERT_TRUE(end);
  EXPECT_EQ(end->round_end_m, 0);
  EXPECT_LT(runtime::depth_at(*end, 0.00449), 1e-9);
  EXPECT_GT(runtime::depth_at(*end, 0.0047), 5e-5);
  // The fillet beyond the flat: d = a int_b^a (r - b) / sqrt(e^2 - (r - b)^2) / sqrt(a^2 - r^2) dr.
  const double a = 0.0049, b = 0.0045, e = 0.0005;
  double sum = 0;
  constexpr int kSteps = 200000;
  for (int i = 0; i < kSteps; ++i) {  // r = a sin t
    const double from = std::asin(b / a), t = from + (kPi / 2 - from) * (i + 0.5) / kSteps,
                 beside = a * std::sin(t) - b;
    sum += beside / std::sqrt(e * e - beside * beside) * (kPi / 2 - from) / kSteps;
  }
  EXPECT_NEAR(runtime::depth_at(*end, a), a * sum, 5e-3 * a * sum);
  EXPECT_NEAR(runtime::widest_m(*end), 0.005, 2e-5);
}

TEST(RoundEnd, of_upright_shapes_of_revolution_is_that_of_their_tips) {
  for (const Probe& upright :
       {capsule(0.004, 0.02, Vec3::UnitZ()), capsule(0.004, 0.02, -Vec3::UnitZ())}) {
    const auto end = round_end(upright);
    ASSERT_TRUE(end);
    EXPECT_NEAR(end->round_end_m, 0.004, 4e-6);
    for (double a = 2e-4; a < 0.0036; a *= 1.3) {
      const double exact = a * std::atanh(a / 0.004);
      EXPECT_NEAR(runtime::depth_at(*end, a), exact, 6e-3 * exact) << a;
    }
  }
}

TEST(RoundEnd, of_what_is_not_round_along_its_press_is_none) {
  EXPECT_FALSE(round_end(capsule(0.004, 0.02, Vec3::UnitX())));
  EXPECT_FALSE(round_end(capsule(0.004, 0.02, Vec3(1, 0, 1).normalized())));
}

}  // namespace
}  // namespace palpate::fem
