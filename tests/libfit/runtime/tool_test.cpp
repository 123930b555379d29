// A rigid tool of several balls (docs/method-tools.md, section 29): force and torque are
// derivatives of what it stores, and no motion creates anything. Failures print the seed.

#include <gtest/gtest.h>

#include <random>

#include "libfit/runtime/palpate.h"
#include "tests/libfit/runtime/c_face.hpp"
#include "tests/libfit/runtime/capsule.hpp"

namespace palpate::test {
namespace {

TEST(Tool, of_one_ball_that_does_not_turn_is_the_ball) {
  Capsule one(rings_model(true, 0.5, 10), 1);
  Contact alone;
  Output out;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> share(-1, 1);
  Vec3 at(0.001, 0.002, 0.0345);
  for (int i = 0; i < 600; ++i) {
    ASSERT_EQ(one.tick(pose_at(at, Vec3::Zero())), Status::ok);
    runtime::touch_ball(one.loaded.asset, alone, at.data(), kRadius_m, out);
    EXPECT_LT((one.force() + Vec3::Map(out.force_on_tool_N)).norm(), 1e-12) << i;
    EXPECT_NEAR(one.out.stored_J, out.stored_J, 1e-15);
    at += Vec3(8e-5 * share(random), 8e-5 * share(random), i < 100 ? -3e-5 : 2e-5 * share(random));
  }
  EXPECT_GT(one.force().norm(), 0.02);
}

TEST(Tool, bears_on_the_side_that_goes_deeper) {
  Capsule level(rings_model(false, 0.3)), tilted(rings_model(false, 0.3));
  for (int i = 0; i <= 300; ++i) {
    const Vec3 place(0.001, 0.002, kRadius_m + 0.001 - 1e-5 * i);
    ASSERT_EQ(level.tick(pose_at(place, Vec3::Zero())), Status::ok);
    ASSERT_EQ(tilted.tick(pose_at(place, {0, 0.1, 0})), Status::ok);  // own x sinks
  }
  EXPECT_EQ(level.out.touching, 4);
  EXPECT_LT(level.torque().norm(), 1e-6);
  EXPECT_GT(tilted.torque().y(), 1e-4);       // x times a force along -z
  EXPECT_GT(tilted.out.contact_m[0], 0.002);  // where the deeper balls are
  EXPECT_GE(tilted.out.triangle, 0);
  // Balls that sink each other bear less than as many by themselves.
  Capsule one(rings_model(false, 0.3), 1);
  for (int i = 0; i <= 300; ++i)
    one.tick(pose_at({0.001, 0.002, kRadius_m + 0.001 - 1e-5 * i}, Vec3::Zero()));
  EXPECT_LT(level.force().norm(), 3.9 * one.force().norm());
  EXPECT_GT(level.force().norm(), 1.5 * one.force().norm());
}

TEST(Tool, force_and_torque_are_derivatives_of_what_it_stores_while_all_sticks) {
  for (const bool is_round : {false, true}) {
    Capsule capsule(rings_model(is_round, 300, 5));
    const double top = is_round ? 0.03 : 0;
    const Vec3 turn(0.05, -0.12, 0.2);
    Vec3 place;
    for (int i = 0; i <= 400; ++i) {
      place = Vec3(0.001 + 1e-6 * i, 0.002 - 5e-7 * i, top + kRadius_m + 0.0015 - 1e-5 * i);
      ASSERT_EQ(capsule.tick(pose_at(place, turn * (1 + 2e-4 * i))), Status::ok);
    }
    ASSERT_GE(capsule.out.touching, 2);
    const Eigen::Isometry3d here = pose_at(place, turn * 1.08);
    capsule.tick(here);
    const Vec3 force = capsule.force(), torque = capsule.torque();
    constexpr double kStep_m = 1e-7, kStep_rad = 1e-5;
    for (int k = 0; k < 3; ++k) {
      Eigen::Isometry3d plus = here, minus = here;
      plus.pretranslate(kStep_m * Vec3::Unit(k));
      minus.pretranslate(-kStep_m * Vec3::Unit(k));
      EXPECT_NEAR(force[k],
                  (capsule.stored_after(plus) - capsule.stored_after(minus)) / (2 * kStep_m),
                  2e-5 * force.norm());
      const Eigen::AngleAxisd by(kStep_rad, Vec3::Unit(k));
      plus = minus = here;
      plus.linear() = by * here.linear();
      minus.linear() = by.inverse() * here.linear();
      // The coupling of contacts that roll changes by what the ledger books (M72): 0.5 %.
      EXPECT_NEAR(torque[k],
                  (capsule.stored_after(plus) - capsule.stored_after(minus)) / (2 * kStep_rad),
                  1e-2 * torque.norm());
    }
    EXPECT_GT(torque.norm(), 1e-4);
  }
}

TEST(Tool, that_rolls_over_its_side_feels_no_friction) {
  Capsule capsule(rings_model(false, 0.5));
  for (int i = 0; i <= 300; ++i)
    capsule.tick(pose_at({0, 0, kRadius_m + 0.0005 - 1e-5 * i}, Vec3::Zero()));
  // About own x, on to -y.
  for (int i = 1; i <= 200; ++i)
    ASSERT_EQ(
        capsule.tick(pose_at({0, -1e-5 * i, kRadius_m - 0.0025}, {1e-5 * i / kRadius_m, 0, 0})),
        Status::ok);
  EXPECT_LT(std::abs(capsule.force().y()), 1e-3 * capsule.force().norm());
  Capsule dragged(rings_model(false, 0.5));
  for (int i = 0; i <= 300; ++i)
    dragged.tick(pose_at({0, 0, kRadius_m + 0.0005 - 1e-5 * i}, Vec3::Zero()));
  for (int i = 1; i <= 200; ++i)
    dragged.tick(pose_at({0, -1e-5 * i, kRadius_m - 0.0025}, Vec3::Zero()));
  EXPECT_GT(std::abs(dragged.force().y()), 0.1 * dragged.force().norm());
}

// Cut by its size, the force yielded 2.6 uJ in each of these loops, in one sense, at any tick
// length.
TEST(Tool, that_is_capped_takes_energy_round_a_loop_and_never_exceeds_its_cap) {
  for (const int ticks : {-6400, -1600, -400, 400, 1600, 6400}) {  // either sense
    Capsule capsule(rings_model(true, 200), 1);
    capsule.tool.shape.max_force_N = 0.1;
    double work_J = 0, largest_N = 0;
    Vec3 before, before_N;
    for (int i = 0; i <= 23 * std::abs(ticks); ++i) {
      const double turn = 2 * M_PI * i / ticks, deep_m = 0.0045 - 0.0015 * std::cos(turn);
      const Vec3 at(0.0008 + 0.0006 * std::sin(turn), 0, 0.03 + kRadius_m - deep_m);
      if (i == 0)
        for (double above_m = 0.0045; above_m > 0; above_m -= 1e-5)
          capsule.tick(pose_at(at + Vec3(-0.0008, 0, above_m), Vec3::Zero()));
      ASSERT_EQ(capsule.tick(pose_at(at, Vec3::Zero())), Status::ok);
      if (i > 3 * std::abs(ticks)) work_J += 0.5 * (capsule.force() + before_N).dot(at - before);
      before = at;
      before_N = capsule.force();
      largest_N = std::max(largest_N, before_N.norm());
    }
    EXPECT_GT(work_J, -1e-9) << "J in 20 loops of " << ticks << " ticks";
    EXPECT_LT(largest_N, 0.1 * (1 + 1e-12));
    EXPECT_GT(largest_N, 0.0999);
  }
}

// A group whose tools changed let every pressed tool go: its force went to 0 in one tick.
TEST(Tool, that_joins_leaves_or_begins_anew_leaves_pressed_ones_pressed) {
  Capsule group(rings_model(false, 0.3), 1);
  std::vector<runtime::Tool> tools(3, group.tool);
  const auto tick = [&](const std::vector<int>& which, double lift_m) {
    std::vector<runtime::Tool*> here;
    std::vector<ToolInput> in;
    for (const int k : which) {
      here.push_back(&tools[static_cast<std::size_t>(k)]);
      in.emplace_back();
      in.back().pose = to_pose(pose_at(Vec3(0.008 * (k - 1), 0, kRadius_m + lift_m), Vec3::Zero()));
      in.back().dt_s = 1e-3;
    }
    std::vector<ToolOutput> out(which.size());
    std::vector<runtime::Status> status(which.size());
    touch_tools(group.loaded.asset, here.data(), in.data(), out.data(), status.data(),
                static_cast<int>(which.size()));
    std::vector<double> down_N;
    for (const ToolOutput& one : out) down_N.push_back(one.force_on_tool_N[2]);
    return down_N;
  };
  for (double lift_m = 5e-4; lift_m > -0.002; lift_m -= 1e-5) tick({0, 1}, lift_m);
  const std::vector<double> two_N = tick({0, 1}, -0.002);
  ASSERT_GT(two_N[0], 0.03);
  const std::vector<double> joined_N = tick({2, 1, 0}, -0.002);  // the third is inside: silent
  EXPECT_EQ(joined_N[0], 0);
  EXPECT_NEAR(joined_N[1], two_N[1], 1e-9);
  EXPECT_NEAR(joined_N[2], two_N[0], 1e-9);
  const double alone_N = tick({1}, -0.002)[0];  // what the other had pressed away comes back
  EXPECT_GT(alone_N, two_N[1]);
  EXPECT_LT(alone_N, 1.1 * two_N[1]);
  tools[0] = group.tool;  // begins anew
  const std::vector<double> again_N = tick({0, 1}, -0.002);
  EXPECT_EQ(again_N[0], 0);
  EXPECT_NEAR(again_N[1], alone_N, 1e-9);
}

TEST(Tool, of_several_balls_needs_contacts_that_move_each_other) {
  Model model = rings_model(false, 0.3);
  Capsule capsule(model);
  EXPECT_EQ(capsule.tick(pose_at({0, 0, 0.001}, Vec3::Zero())), Status::ok);
  model.curves.coupling = {};
  Capsule alone(model), one(model, 1);
  EXPECT_EQ(alone.tick(pose_at({0, 0, 0.001}, Vec3::Zero())), Status::tool_wrong);
  EXPECT_EQ(one.tick(pose_at({0, 0, 0.001}, Vec3::Zero())), Status::ok);
}

TEST(Tool, whose_ball_is_not_that_of_the_curves_says_so) {
  for (const double radius_m : {kRadius_m, 0.5 * kRadius_m}) {
    Capsule one(rings_model(false, 0.3), 1);
    one.tool.shape.ball[0].radius_m = radius_m;
    for (int i = 0; i <= 100; ++i)
      one.tick(pose_at({0, 0, radius_m + 0.0005 - 1e-5 * i}, Vec3::Zero()));
    ASSERT_GT(one.force().norm(), 0);
    EXPECT_EQ((one.out.flags & PALPATE_FLAG_OTHER_RADIUS) != 0, radius_m != kRadius_m);
  }
}

// It rolled while it touched: the place where its contact let go lay beside the ball by as much,
// and the next press was lost.
TEST(Tool, that_turned_in_place_touches_again_after_it_lifted_off) {
  for (const double turned_rad : {1.2, 2.0})
    for (int seed = 0; seed < 50; ++seed) {
      Capsule one(rings_model(true, 0.5, 5), 1);
      const Vec3 u = Vec3(0.01 * (seed % 7 - 3), 0.008 * (seed % 5 - 2), 0.03).normalized();
      const auto at = [&](double depth_m, double angle) {
        return pose_at((0.03 + kRadius_m - depth_m) * u, angle * Vec3(0.6, 0.8, 0));
      };
      one.tick(at(-0.001, 0));
      for (int i = 0; i <= 150; ++i) one.tick(at(-0.001 + 2e-5 * i, 0));
      for (int i = 1; i <= 200; ++i) one.tick(at(0.002, turned_rad * i / 200));
      for (int i = 1; i <= 100; ++i) one.tick(at(0.002 - 2e-5 * i, turned_rad));
      for (int i = 1; i <= 100; ++i) one.tick(at(2e-5 * i, turned_rad));
      EXPECT_GT(one.force().norm(), 0.02) << turned_rad << " rad, seed " << seed;
    }
}

// The contact point of a ball that pressed 1.4 times the range into a body that sways by 12 mm/N
// went several millimetres in a tick, with 0.19 N.
TEST(Tool, beyond_the_range_of_a_body_that_sways_slides_on_step_by_step) {
  for (const unsigned seed : {2U, 12U, 17U}) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> share(-1, 1);
    Model model = testing_hands::swaying_body(true, 0.6, 20);
    model.probe = sphere_spec(kRadius_m, 0.6);
    Capsule ball(model, 1);
    Vec3 at(0.01 * share(random), 0.01 * share(random), 0.03 + kRadius_m + 0.002);
    const Vec3 out = at;
    ball.tick(pose_at(at, Vec3::Zero()));
    Vec3 force = Vec3::Zero();
    for (const double aside_m : {0.01, 0.015, 0.0}) {
      const Vec3 from = at, by(aside_m * share(random), aside_m * share(random), -0.022);
      const Vec3 to = aside_m > 0 ? Vec3(out + by) : out;
      const int ticks = static_cast<int>((to - from).norm() / 1e-5);
      for (int i = 1; i <= ticks; ++i) {
        at = from + (to - from) * i / ticks;
        ball.tick(pose_at(at, Vec3::Zero()));
        ASSERT_LT((ball.force() - force).norm(), 0.03) << "seed " << seed << ", " << at.transpose();
        force = ball.force();
      }
    }
  }
}

TEST(Tool, in_c_is_the_same_on_a_body_that_stands_anywhere) {
  const Model model = rings_model(true, 0.4, 5);
  Capsule here(model, 3);
  const AssetBytes bytes = make_asset_bytes(model, {});
  palpate_asset asset;
  ASSERT_EQ(palpate_open(&asset, bytes.data(), bytes.size()), PALPATE_OK);
  palpate_tool balls = palpate_ball(kRadius_m);
  balls.balls = 3;
  for (int i = 0; i < 3; ++i) {
    balls.radius_m[i] = kRadius_m;
    balls.centre_m[i][0] = kHalf_m * (i - 1);
  }
  palpate_contact there;
  ASSERT_EQ(palpate_start(&there, &balls), PALPATE_OK);
  Eigen::Isometry3d body = Eigen::Isometry3d::Identity();
  body.rotate(Eigen::AngleAxisd(1.1, Vec3(1, -2, 0.5).normalized()));
  body.pretranslate(Vec3(0.3, -0.2, 0.1));
  palpate_output out;
  palpate_input in = palpate_input_at(0, 0, 0, 0.001);
  in.body = pose_of(body);
  for (int i = 0; i <= 400; ++i) {
    const auto pose = pose_at({2e-6 * i, 0.001, 0.0345 - 1e-5 * i}, {0.02, 3e-4 * i, 0.1});
    ASSERT_EQ(here.tick(pose), Status::ok);
    in.tool = pose_of(body * pose);
    ASSERT_EQ(palpate_tick(&asset, &there, 1, &in, &out), PALPATE_OK);
    EXPECT_LT((body.linear() * here.force() + Vec3::Map(out.force_on_tool_N)).norm(), 1e-8);
    EXPECT_LT((body.linear() * here.torque() + Vec3::Map(out.torque_on_tool_Nm)).norm(), 1e-10);
    EXPECT_NEAR(out.stored_J, here.out.stored_J, 1e-12);
    EXPECT_EQ(out.touching, here.out.touching);
    EXPECT_EQ(out.triangle < 0, out.touching == 0);
  }
  EXPECT_GT(here.force().norm(), 0.02);
  in.tool.orientation[0] = 0.5;
  EXPECT_EQ(palpate_tick(&asset, &there, 1, &in, &out), PALPATE_POSE_WRONG);
  expect_silence(out, "pose");
  palpate_contact raw{};
  EXPECT_EQ(palpate_tick(&asset, &raw, 1, &in, &out), PALPATE_NOT_STARTED);
  balls.balls = 9;
  EXPECT_EQ(palpate_start(&raw, &balls), PALPATE_TOOL_WRONG);
  balls.balls = 0;
  EXPECT_EQ(palpate_start(&raw, &balls), PALPATE_TOOL_WRONG);
}

}  // namespace
}  // namespace palpate::test
