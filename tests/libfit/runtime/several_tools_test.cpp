// What several tools feel of each other (docs/method-tools.md, section 28), against closed forms
// and against a tool alone.

#include "libfit/runtime/series/tick.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <vector>

#include "tests/libfit/runtime/hands.hpp"

namespace palpate::test {
namespace {

using namespace testing_hands;

TEST(SeveralTools, straight_presses_meet_the_surface_where_the_others_have_brought_it) {
  // f_i = F(d_i - c f_j), F = 12 d + 4500 d^2 without friction, solved here by bisection.
  const CouplingView feel = coupling_of(0.005);
  Hands hands(rings_body(false, 0), feel, 2);
  const double r = 0.012, d[2] = {0.003, 0.002};
  const std::vector<Vec3> away{{-r / 2, 0, kBallRadius_m + 5e-4}, {r / 2, 0, kBallRadius_m + 5e-4}},
      down{{-r / 2, 0, kBallRadius_m - d[0]}, {r / 2, 0, kBallRadius_m - d[1]}};
  hands.tick(away);
  hands.go(down, 400);
  const double c = runtime::coupling_at(feel, r * r).isotropic;
  const auto F = [](double x) { return x > 0 ? 12 * x + 4500 * x * x : 0; };
  double low = 0, high = F(d[0]);
  for (int k = 0; k < 100; ++k) {
    const double f = (low + high) / 2;
    (F(d[0] - c * F(d[1] - c * f)) > f ? low : high) = f;
  }
  EXPECT_NEAR(-hands.force(0).z(), low, 1e-6 * low);
  EXPECT_NEAR(-hands.force(1).z(), F(d[1] - c * low), 1e-6 * low);
  EXPECT_LT(low, 0.995 * F(d[0]));
}

TEST(SeveralTools, a_tool_that_comes_touches_the_surface_in_the_dent) {
  Hands hands(rings_body(false, 1), coupling_of(0.006), 2);
  const double r = 0.009;
  std::vector<Vec3> at{{-r / 2, 0, kBallRadius_m + 5e-4}, {r / 2, 0, kBallRadius_m + 5e-4}};
  hands.tick(at);
  at[0].z() = kBallRadius_m - 0.004;
  hands.go(at, 400);
  const double alone_N = -hands.force(0).z();
  const double sunk_m = runtime::coupling_at(hands.feel, r * r).isotropic * alone_N;
  ASSERT_GT(sunk_m, 1e-4);
  at[1].z() = kBallRadius_m - 0.97 * sunk_m;
  hands.go(at, 200);
  EXPECT_EQ(hands.force(1).norm(), 0);
  EXPECT_EQ(-hands.force(0).z(), alone_N);
  at[1].z() = kBallRadius_m - 1.05 * sunk_m;
  hands.go(at, 20);
  EXPECT_GT(hands.force(1).norm(), 0);
  // It stays in touch with the surface that comes back.
  at[0].z() = kBallRadius_m + 5e-4;
  hands.go(at, 400);
  EXPECT_EQ(hands.force(0).norm(), 0);
  EXPECT_NEAR(-hands.force(1).z(), 12 * 1.05 * sunk_m + 4500 * std::pow(1.05 * sunk_m, 2), 5e-7);
}

TEST(SeveralTools, in_one_place_bear_more_than_one_and_say_so) {
  Model model = rings_body(false, 1);
  Hands one(model, coupling_of(0.004), 1), four(model, coupling_of(0.004), 4);
  const Vec3 away(0, 0, kBallRadius_m + 5e-4), down(0, 0, kBallRadius_m - 0.003);
  one.tick({away});
  one.go({down}, 300);
  four.tick({away, away, away, away});
  four.go({down, down, down, down}, 300);
  double sum = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_NE(four.tool[i].out.flags & PALPATE_FLAG_CROWDED, 0u);
    EXPECT_EQ(four.tool[i].out.flags & PALPATE_FLAG_UNFINISHED, 0u);
    EXPECT_LT(four.force(i).norm(), one.force(0).norm());
    sum += four.force(i).norm();
  }
  EXPECT_GT(sum, one.force(0).norm());
  EXPECT_EQ(one.tool[0].out.flags & PALPATE_FLAG_CROWDED, 0u);
}

TEST(SeveralTools, one_tool_in_a_group_is_a_tool) {
  Hands hands(rings_body(true, 1, 10), coupling_of(0.004, 0.002), 2);
  Contact alone;
  Output out;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> share(-1, 1);
  Vec3 at(0.001, 0.002, 0.0345);
  const Vec3 far(0, 0, -0.05);
  for (int i = 0; i < 600; ++i) {
    hands.tick({at, far});
    runtime::touch_ball(hands.asset, alone, at.data(), kBallRadius_m, out);
    EXPECT_LT((hands.force(0) + Vec3::Map(out.force_on_tool_N)).norm(), 1e-12) << i;
    EXPECT_NEAR(hands.stored_J(), out.stored_J, 1e-15);
    at += Vec3(8e-5 * share(random), 8e-5 * share(random), i < 100 ? -3e-5 : 2e-5 * share(random));
  }
  EXPECT_GT(hands.force(0).norm(), 0.02);
}

TEST(SeveralTools, without_coupling_each_is_by_itself_bit_for_bit) {
  Hands hands(rings_body(true, 1, 10), {}, 2);
  hands.asset.coupling = nullptr;
  Contact alone[2];
  Output out[2];
  for (int i = 0; i < 300; ++i) {
    const std::vector<Vec3> at{{0.008 + 1e-5 * i, 0, 0.034 - 2e-5 * i},
                               {-0.008, 0, 0.034 - 1e-5 * i}};
    hands.tick(at);
    for (std::size_t k = 0; k < 2; ++k) {
      runtime::touch_ball(hands.asset, alone[k], at[k].data(), kBallRadius_m, out[k]);
      EXPECT_EQ(0, std::memcmp(&out[k], &hands.tool[k].out, sizeof(double) * 3));
      EXPECT_EQ(out[k].stored_J, hands.tool[k].out.stored_J);
    }
  }
}

TEST(SeveralTools, on_a_body_that_sways_one_is_a_tool_and_two_sway_together) {
  Hands hands(swaying_body(false, 1), coupling_of(1e-7), 2);
  Contact alone;
  Output out;
  std::vector<Vec3> at{{-0.02, 0, kBallRadius_m + 5e-4}, {0.02, 0, kBallRadius_m + 0.01}};
  for (int i = 0; i < 300; ++i) {
    at[0].z() -= 1e-5;
    hands.tick(at);
    runtime::touch_ball(hands.asset, alone, at[0].data(), kBallRadius_m, out);
    EXPECT_LT((hands.force(0) + Vec3::Map(out.force_on_tool_N)).norm(), 1e-6);
    EXPECT_NEAR(hands.stored_J(), out.stored_J, 1e-10);
  }
  const double before_N = hands.force(0).norm();
  at[1].z() =
      kBallRadius_m - 0.002;  // 40 mm away: what it pushes away goes from under the first, too
  hands.go(at, 600);
  EXPECT_GT(hands.force(1).norm(), 0.01);
  EXPECT_LT(hands.force(0).norm(), 0.97 * before_N);
}

TEST(SeveralTools, a_tool_that_is_refused_leaves_the_others) {
  Hands hands(rings_body(false, 0), coupling_of(0.004), 2);
  std::vector<Vec3> at{{-0.006, 0, kBallRadius_m + 5e-4}, {0.006, 0, kBallRadius_m + 5e-4}};
  hands.tick(at);
  for (Vec3& x : at) x.z() = kBallRadius_m - 0.002;
  hands.go(at, 200);
  const double stored_J = hands.stored_J();
  at[1].x() = std::numeric_limits<double>::quiet_NaN();
  hands.tick(at);
  EXPECT_EQ(hands.tool[1].status, Status::tip_not_finite);
  EXPECT_EQ(hands.force(1).norm(), 0);
  EXPECT_EQ(hands.tool[0].status, Status::ok);
  EXPECT_NEAR(-hands.force(0).z(), 12 * 0.002 + 4500 * 0.002 * 0.002, 1e-9);
  EXPECT_LT(hands.stored_J(), stored_J);
}

// A body that sways by most of what a tool is pressed: one tick all the way ends where many do.
// Newton's first step went past the surface there, every contact let go, and the force was none.
TEST(SeveralTools, six_balls_that_jump_into_a_body_that_sways_bear_what_six_that_go_slowly_do) {
  Model model = rings_body(false, 0);
  for (const double sway_m_N : {0.004, 0.06, 0.3}) {
    set_sway(model,
             [&](const Vec3&) { return Symmetric{sway_m_N, sway_m_N, 1.5 * sway_m_N, 0, 0, 0}; });
    for (const double depth_m : {0.001, 0.003, 0.004}) {
      Hands jump(model, coupling_of(0.0002), 6), slow(model, coupling_of(0.0002), 6);
      std::vector<Vec3> away, down;
      for (int i = 0; i < 6; ++i) {
        away.emplace_back(0.003 * (i - 2.5), 0, kBallRadius_m + 1e-4);
        down.emplace_back(0.003 * (i - 2.5), 0, kBallRadius_m - depth_m);
      }
      jump.tick(away);
      jump.tick(down);
      slow.tick(away);
      slow.go(down, 300);
      for (std::size_t i = 0; i < 6; ++i) {
        EXPECT_EQ(jump.tool[i].out.flags & PALPATE_FLAG_UNFINISHED, 0U);
        EXPECT_GT(-slow.force(i).z(), 1e-4);
        EXPECT_NEAR(-jump.force(i).z(), -slow.force(i).z(), 1e-5 * -slow.force(i).z())
            << "ball " << i << ", " << depth_m << " m, sways by " << sway_m_N << " m/N";
      }
    }
  }
}

// On a round body that sways, a second ball found the surface where neither its normal nor its sway
// were known: it began deflected, clicked, and each touch brought energy.
TEST(SeveralTools,
     a_second_touch_on_a_round_body_that_sways_begins_without_force_and_brings_nothing) {
  for (const double step_m : {2e-6, 8e-6, 32e-6}) {
    Model model = rings_body(true, 0.3);
    set_sway(model,
             [](const Vec3& x) { return Symmetric{0.02, 0.02, 0.03 * (1 - 15 * x[0]), 0, 0, 0}; });
    Hands hands(model, coupling_of(0.004), 2);
    const auto at = [](double angle, double depth_m) {
      const double r = 0.03 + kBallRadius_m - depth_m;
      return Vec3(r * std::sin(angle), 0, r * std::cos(angle));
    };
    std::vector<Vec3> balls{at(0, -5e-4), at(0.5, -5e-4)};
    hands.tick(balls);
    balls[0] = at(0, 0.003);
    hands.go(balls, 400);
    double depth_m = -5e-4, work_J = 0, largest_N = 0;
    while (hands.force(1).norm() == 0 && depth_m < 0.003) {
      depth_m += step_m;
      balls[1] = at(0.5, depth_m);
      hands.tick(balls);
    }
    ASSERT_GT(hands.force(1).norm(), 0);
    EXPECT_LT(hands.force(1).norm(), 60 * step_m) << "N at the touch, in steps of " << step_m;
    const int quarter = static_cast<int>(3e-4 / step_m);
    for (int cycle = 0; cycle < 20; ++cycle)
      for (int i = 1; i <= 4 * quarter; ++i) {
        const int steps = i < quarter ? i : i < 3 * quarter ? 2 * quarter - i : i - 4 * quarter;
        const Vec3 before_N = hands.force(1), from = balls[1];
        balls[1] = at(0.5, depth_m + step_m * steps);
        hands.tick(balls);
        work_J += 0.5 * (hands.force(1) + before_N).dot(balls[1] - from);
        if (before_N.norm() == 0) largest_N = std::max(largest_N, hands.force(1).norm());
      }
    EXPECT_LT(largest_N, 60 * step_m) << "N, in steps of " << step_m;
    EXPECT_GT(work_J, -1e-9) << "J in 20 cycles, in steps of " << step_m;
  }
}

}  // namespace
}  // namespace palpate::test
