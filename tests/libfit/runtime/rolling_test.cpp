// A ball that turns (docs/method-tools.md, section 29): it is felt where it is, friction limits
// what its roll deflects, and the work of its torque is all that a roll over uneven ground stores.

#include <gtest/gtest.h>

#include <numbers>

#include "tests/libfit/runtime/capsule.hpp"

namespace palpate::test {
namespace {

constexpr double kDepth_m = 0.003, kBall_m = 0.03;

/// A ball that is pressed, kDepth_m deep, straight into the top of the body.
Capsule pressed(const Model& model, double top_m) {
  Capsule ball(model, 1);
  for (int i = 0; i <= 200; ++i)
    ball.tick(
        pose_at({0, 0, top_m + kRadius_m + 0.001 - (0.001 + kDepth_m) * i / 200}, Vec3::Zero()));
  return ball;
}
Vec3 contact(const Capsule& ball) { return Vec3::Map(ball.out.contact_m); }

TEST(Rolling, wound_in_place_keeps_its_normal_force_and_its_place) {
  for (const double friction : {0.0, 0.3, 0.8}) {
    Capsule ball = pressed(rings_model(true, friction), kBall_m);
    const double before_N = ball.force().z();
    const Vec3 from = contact(ball);
    for (int i = 1; i <= 1600; ++i) {
      const double angle = i <= 800 ? 0.005 * i : 8 - 0.005 * i;
      ball.tick(pose_at({0, 0, kBall_m + kRadius_m - kDepth_m}, {0, angle, 0}));
      ASSERT_NEAR(ball.force().z() / before_N, 1, 0.05) << friction << ", " << angle << " rad";
      ASSERT_LT((contact(ball) - from).norm(), 0.0025) << friction << ", " << angle << " rad";
    }
  }
}

TEST(Rolling, without_slip_over_an_even_sphere_keeps_its_force) {
  Capsule ball = pressed(rings_model(true, 0.5), kBall_m);
  const double before_N = ball.force().norm(), path_m = kBall_m + kRadius_m - kDepth_m;
  for (int i = 1; i <= 2000; ++i) {
    const double rolled_m = 1e-5 * i, angle = rolled_m / path_m;
    const Vec3 out(std::sin(angle), 0, std::cos(angle));
    ball.tick(pose_at(path_m * out, {0, rolled_m / kRadius_m, 0}));
    ASSERT_NEAR(-ball.force().dot(out) / before_N, 1, 0.05) << 1e3 * rolled_m << " mm";
    ASSERT_LT((contact(ball) - kBall_m * out).norm(), 0.0015) << 1e3 * rolled_m << " mm";
  }
}

// A finger rolls over a lump: a ridge of 2.5 times the stiffness across the way.
Model ridge_model(double friction) {
  Model model = plate_model(0.08, 64, uniform(400, 300, friction));
  make_rings(model, friction, 0,
             [](const Vec3& x) { return 1 + 1.5 * std::exp(-std::pow((x[0] - 0.01) / 0.004, 2)); });
  model.probe = sphere_spec(kRadius_m, friction);
  return model;
}

struct Loop {
  double work_J = 0, most_J = 0;
};
/// Shallow over the ridge, down, back at depth, up: rolled by `turn` times the way over the radius.
Loop loop_over_the_ridge(Capsule& ball, double turn, int ticks, int cycles) {
  Loop loop;
  Vec3 at;
  double angle = 0;
  Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
  const auto go = [&](const Vec3& to) {
    const Vec3 from = at;
    const double from_rad = angle;
    for (int i = 1; i <= ticks; ++i) {
      const Vec3 was = at;
      const double was_rad = angle;
      at = from + (to - from) * i / ticks;
      angle = from_rad + turn * (at.x() - from.x()) / kRadius_m;
      ball.tick(pose_at(at, {0, angle, 0}));
      loop.work_J += 0.5 * (force + ball.force()).dot(at - was) +
                     0.5 * (torque + ball.torque()).y() * (angle - was_rad);
      force = ball.force();
      torque = ball.torque();
      loop.most_J = std::max(loop.most_J, ball.out.stored_J);
    }
  };
  ball.tick(pose_at({0, 0, kRadius_m + 0.001}, Vec3::Zero()));
  at = {0, 0, kRadius_m + 0.001};
  go({0, 0, kRadius_m - 0.001});
  loop.work_J = 0;
  for (int i = 0; i < cycles; ++i) {
    go({0.011, 0, kRadius_m - 0.001});
    go({0.011, 0, kRadius_m - 0.003});
    go({0, 0, kRadius_m - 0.003});
    go({0, 0, kRadius_m - 0.001});
  }
  return loop;
}

TEST(Rolling, has_a_torque_that_is_the_derivative_of_what_it_stores_while_it_sticks) {
  Capsule ball = pressed(ridge_model(300), 0);
  const auto at = [](double x, double angle) {
    return pose_at({x, 0, kRadius_m - kDepth_m}, {0, angle, 0});
  };
  double x = 0;
  for (int i = 1; i <= 600; ++i, x += 1e-5) ball.tick(at(x, 1.1 * x / kRadius_m));
  const double angle = 1.1 * x / kRadius_m, step_rad = 1e-5;
  ball.tick(at(x, angle));
  const double slope_Nm =
      (ball.stored_after(at(x, angle + step_rad)) - ball.stored_after(at(x, angle - step_rad))) /
      (2 * step_rad);
  EXPECT_NEAR(ball.torque().y(), slope_Nm, 1e-4 * std::abs(slope_Nm));
  EXPECT_GT(std::abs(Vec3::Map(ball.tool.rolling[0].torque_Nm).y()), 0.05 * std::abs(slope_Nm));
}

// The torque of a contact that had ended was booked as work of the next one.
TEST(Rolling, that_lifted_off_leaves_nothing_to_the_next_touch) {
  Capsule ball = pressed(ridge_model(300), 0);
  for (int i = 1; i <= 600; ++i)
    ball.tick(pose_at({1e-5 * i, 0, kRadius_m - kDepth_m}, {0, 1.1e-5 * i / kRadius_m, 0}));
  ASSERT_GT(std::abs(Vec3::Map(ball.tool.rolling[0].torque_Nm).y()), 0);
  for (int i = 0; i <= 100; ++i)
    ball.tick(pose_at({6e-3, 0, kRadius_m - kDepth_m + 4e-5 * i}, {0, 1.65, 0}));
  ASSERT_EQ(ball.out.touching, 0);
  ball.tick(pose_at({6e-3, 0, kRadius_m + 1e-3}, {0, 1.2, 0}));
  EXPECT_EQ(Vec3::Map(ball.tool.rolling[0].torque_Nm).norm(), 0);
  EXPECT_EQ(ball.tool.rolling[0].followed, 0);
}

TEST(Rolling, over_a_ridge_is_felt_where_it_is) {
  Capsule ball = pressed(ridge_model(0.5), 0);
  for (int i = 1; i <= 1500; ++i) {
    const double x = 1e-5 * i;
    ball.tick(pose_at({x, 0, kRadius_m - kDepth_m}, {0, x / kRadius_m, 0}));
    if (i % 250 != 0) continue;
    Capsule fresh(ridge_model(0.5), 1);
    for (int k = 0; k <= 200; ++k)
      fresh.tick(pose_at({x, 0, kRadius_m + 0.001 - (0.001 + kDepth_m) * k / 200}, Vec3::Zero()));
    EXPECT_NEAR(ball.force().z() / fresh.force().z(), 1, 0.03) << 1e3 * x << " mm";
  }
}

TEST(Rolling, round_a_loop_over_a_ridge_yields_nothing) {
  for (const double friction : {0.02, 0.5})
    for (const double turn : {1.0, -1.0, 0.3, 2.0})
      for (const int ticks : {400, 1600}) {
        Capsule ball(ridge_model(friction), 1);
        const Loop loop = loop_over_the_ridge(ball, turn, ticks, 12);
        EXPECT_GT(loop.work_J, -0.01 * loop.most_J)
            << "friction " << friction << ", turns " << turn << " times, " << ticks << " ticks";
      }
}

}  // namespace
}  // namespace palpate::test
