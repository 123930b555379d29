// Several tools that feel each other (docs/method-tools.md, section 28): forces are derivatives of
// what all store together, and nothing is created. Failures print the seed.

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "libfit/runtime/tool/tool.hpp"
#include "tests/libfit/runtime/hands.hpp"

namespace palpate::test {
namespace {

using namespace testing_hands;

// Three that stick: forces by differences of what all store.
void expect_gradient(const Model& model, bool is_round, double tolerance) {
  Hands hands(model, coupling_of(0.004, 0.003), 3);
  hands.tick(places(is_round, -0.0005));
  std::vector<Vec3> at = places(is_round, 0.003);
  for (std::size_t i = 0; i < 3; ++i) at[i] += 1e-4 * Vec3(1, double(i), -0.5);
  hands.go(at, 300);
  for (std::size_t i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) {
      constexpr double h = 1e-7;
      auto plus = at, minus = at;
      plus[i][k] += h;
      minus[i][k] -= h;
      const auto stored = [&] { return hands.stored_J(); };
      const double slope = (hands.after(plus, stored) - hands.after(minus, stored)) / (2 * h);
      EXPECT_NEAR(hands.force(i)[k], slope, tolerance * hands.force(i).norm()) << i << " " << k;
    }
  EXPECT_GT(hands.force(0).norm(), 0.02);
}

TEST(SeveralTools, forces_are_the_gradient_of_what_all_store_while_all_stick) {
  for (const bool is_round : {false, true})
    expect_gradient(rings_body(is_round, 300, 5), is_round, 2e-5);
}

TEST(SeveralTools, forces_are_that_gradient_on_a_body_that_sways) {
  for (const bool is_round : {false, true})
    expect_gradient(swaying_body(is_round, 300, 5), is_round, 5e-5);
}

TEST(SeveralTools, what_one_does_to_another_is_mutual) {
  Hands hands(rings_body(true, 300, 5), coupling_of(0.004, 0.003), 3);
  hands.tick(places(true, -0.0005));
  const auto at = places(true, 0.003);
  hands.go(at, 300);
  constexpr double h = 1e-6;
  const auto by = [&](std::size_t i, std::size_t j) {  // d f_i / d x_j
    Mat3 out;
    for (int k = 0; k < 3; ++k) {
      auto plus = at, minus = at;
      plus[j][k] += h;
      minus[j][k] -= h;
      const auto force = [&] { return hands.force(i); };
      out.col(k) = (hands.after(plus, force) - hands.after(minus, force)) / (2 * h);
    }
    return out;
  };
  const Mat3 there = by(0, 1), back = by(1, 0);
  EXPECT_GT(there.norm(), 0.1);
  EXPECT_LT((there - back.transpose()).norm(), 1e-3 * there.norm());
}

// A tool that presses at 10 Hz beside a damped one that goes along with the dent by a few percent:
// what the damper took was the work of the surface's own motion, and cycles yielded energy for
// ever.
TEST(SeveralTools, beside_one_that_presses_a_damper_takes_what_it_says) {
  for (const double along : {0.02, 0.08}) {
    Loaded loaded = load(rings_body(false, 1));
    const CouplingView feel = coupling_of(0.006);
    loaded.asset.coupling = &feel;
    runtime::Tool tool[2];
    for (runtime::Tool& t : tool) t.shape.ball[0].radius_m = kBallRadius_m;
    tool[1].shape.damping_Ns_m = 100;
    tool[1].shape.damper_depth_m = 1e-4;
    runtime::Tool* const tools[2] = {&tool[0], &tool[1]};
    double work_J = 0, before_z[2] = {}, before_N[2] = {};
    constexpr int kTicks = 400;
    for (int k = 0; k <= 20 * kTicks; ++k) {
      const double press_m = 0.002 * (1 - std::cos(2 * M_PI * k / kTicks)) - 1e-4;
      const double z[2] = {kBallRadius_m - press_m, kBallRadius_m - 0.001 - along * press_m};
      runtime::ToolInput in[2];
      runtime::ToolOutput out[2];
      Status status[2];
      for (int i = 0; i < 2; ++i) {
        in[i].pose.position_m[0] = 0.01 * i;
        in[i].pose.position_m[2] = k == 0 ? kBallRadius_m + 1e-3 : z[i];
        in[i].dt_s = 2.5e-4;
      }
      touch_tools(loaded.asset, tools, in, out, status, 2);
      for (int i = 0; i < 2; ++i) {
        ASSERT_EQ(status[i], Status::ok);
        const double now_z = in[i].pose.position_m[2], now_N = out[i].force_on_tool_N[2];
        if (k > kTicks) work_J -= 0.5 * (before_N[i] + now_N) * (now_z - before_z[i]);
        before_z[i] = now_z;
        before_N[i] = now_N;
      }
    }
    EXPECT_GT(work_J, 0) << "19 cycles, going along by " << along;
    EXPECT_GT(tool[1].damped_J, 0);
  }
}

}  // namespace
}  // namespace palpate::test
