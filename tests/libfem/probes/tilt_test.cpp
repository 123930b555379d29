// Tools that lean: the reference point is what touches a flat surface first, for every shape.

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "libfit/core/error.hpp"
#include "probe_cases.hpp"

namespace palpate::fem {
namespace {

constexpr unsigned kSeed = 4211;
constexpr double kDeg = 0.017453292519943295;

class Tilted : public testing::TestWithParam<ProbeCase> {};

TEST_P(Tilted, touches_a_flat_surface_first_with_its_reference_point) {
  const Probe upright = make_probe(GetParam().spec, "[probe]");
  const bool is_smoothed = upright.shape->takes_mesh;
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> share(-1, 1);
  for (const double tilt : {5.0, 20.0, 50.0})
    for (int i = 0; i < 4; ++i) {
      const Vec3 axis = random_unit(random);
      const Lean lean = lean_of(tilt * kDeg, 3.14159 * share(random));
      if (upright.shape->name == "cone" && upright.geometry.number[0] > (90 - tilt) * kDeg) {
        EXPECT_THROW(tilted(upright, axis, lean, "[probe]"), Error);
        continue;
      }
      const Probe probe = tilted(upright, axis, lean, "[probe]");
      SCOPED_TRACE(testing::Message() << "seed " << kSeed << ", tilt " << tilt << ", lean "
                                      << lean.transpose() << ", axis " << axis.transpose());
      const double w = probe.half_width_m;
      EXPECT_NEAR(probe.distance(axis, Vec3::Zero()).distance_m, 0, 2e-8 * w);
      EXPECT_LT((probe.distance(axis, Vec3::Zero()).gradient - axis).norm(),
                is_smoothed ? 0.1 : 2e-4);
      EXPECT_LT(probe.distance(axis, -0.2 * GetParam().thin_m * axis).distance_m, 0);
      for (int k = 0; k < 200; ++k) {
        const Vec3 anywhere = 3 * w * Vec3(share(random), share(random), share(random));
        const Vec3 beside = anywhere - anywhere.dot(axis) * axis;
        EXPECT_GT(probe.distance(axis, beside).distance_m, is_smoothed ? -2e-3 * w : -2e-8 * w);
      }
    }
}

TEST_P(Tilted, derivatives_are_those_of_its_distance) {
  const Probe upright = make_probe(GetParam().spec, "[probe]");
  if (upright.shape->takes_mesh) GTEST_SKIP() << "its own axes turn; its suite has them";
  std::mt19937 random(kSeed);
  const Vec3 axis = random_unit(random);
  const Lean lean = lean_of(8 * kDeg, 1);
  const Probe probe = tilted(upright, axis, lean, "[probe]");
  const Mat3 turn = tilt_turn(axis, lean);
  for (int i = 0; i < 50; ++i) {
    const Vec3 offset = 0.4 * GetParam().thin_m * random_unit(random) - 0.1 * probe.touch;
    const SignedDistance here = probe.distance(axis, offset);
    if (!(here.distance_m > 0.05 * GetParam().thin_m)) continue;  // off the medial axis
    const double h = 1e-5 * GetParam().thin_m;
    for (int c = 0; c < 3; ++c) {
      const Vec3 d = h * Vec3::Unit(c);
      const SignedDistance plus = probe.distance(axis, offset + d),
                           minus = probe.distance(axis, offset - d);
      EXPECT_NEAR(here.gradient[c], (plus.distance_m - minus.distance_m) / (2 * h), 1e-6);
    }
  }
  EXPECT_NEAR((turn * axis).dot(axis), std::cos(8 * kDeg), 1e-12);
}

INSTANTIATE_TEST_SUITE_P(Shapes, Tilted, testing::ValuesIn(probe_cases()),
                         [](const auto& row) { return row.param.name; });

TEST(Tilt, a_ball_that_leans_is_the_ball) {
  const Probe upright = make_probe(sphere_spec(0.008), "[probe]");
  const Vec3 axis = Vec3(0.2, -0.4, -0.7).normalized();
  const Probe leaning = tilted(upright, axis, lean_of(50 * kDeg, 0.3), "[probe]");
  std::mt19937 random(kSeed);
  for (int i = 0; i < 50; ++i) {
    const Vec3 offset = 0.01 * random_unit(random);
    EXPECT_NEAR(leaning.distance(axis, offset).distance_m,
                upright.distance(axis, offset).distance_m, 1e-10);
  }
}

TEST(Tilt, the_frame_is_right_handed_smooth_and_takes_the_shaft_to_where_the_lean_says) {
  std::mt19937 random(kSeed);
  for (int i = 0; i < 100; ++i) {
    const Vec3 u = random_unit(random), other = (u + 1e-4 * random_unit(random)).normalized();
    const Mat3 frame = tilt_frame(u);
    EXPECT_LT((frame.transpose() * frame - Mat3::Identity()).norm(), 1e-9);
    // Tangents and the outward normal, as x, y and z are.
    EXPECT_NEAR(frame.col(0).cross(frame.col(1)).dot(-u), 1, 1e-9);
    if (u.z() < 0.9) {
      EXPECT_LT((tilt_frame(other) - frame).norm(), 1e-2);
    }
    const Lean lean = lean_of(0.5, 0.1 * i);
    const Vec3 shaft = tilt_turn(u, lean) * -u;
    EXPECT_NEAR(shaft.dot(-u), std::cos(0.5), 1e-12);
    EXPECT_LT((frame.leftCols<2>().transpose() * shaft - lean).norm(), 1e-9);
  }
  EXPECT_EQ(tilt_frame(-Vec3::UnitZ()).col(0), Vec3::UnitX());
}

}  // namespace
}  // namespace palpate::fem
