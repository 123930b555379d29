#include "libfit/recordings/signal/signal.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/libfit/recordings/relaxation/relaxing_presses.hpp"

namespace palpate::recordings {
namespace {

using namespace testing_relaxation;

TEST(TimedPress, keeps_corners_and_means_of_a_recording) {
  std::mt19937 random(3);
  const auto raw = record({prony({0.5}, {3}), 1}, hold_way(), 0.01, 2, {0.002, 0}, random);
  SignalSettings settings;
  settings.radius_m = 5e-3;
  const Conditioned done = condition(raw, settings, std::nullopt, "press.csv");
  const TimedPress& p = done.history;
  ASSERT_GT(p.rows(), 50);
  EXPECT_LT(p.rows(), 250);
  EXPECT_GT(held_share(p), 0.8);
  const double touch_s = 0.5 + (done.contact.travel_m - 1e-3) / 2e-3;
  for (Eigen::Index i = 0; i < p.rows(); ++i) {
    if (i > 0) {
      EXPECT_GT(p.time_s[i], p.time_s[i - 1]);
    }
    // On the way, straight between its corners.
    EXPECT_NEAR(p.depth_m[i],
                hold_way().depth_at(p.time_s[i] + touch_s) + 1e-3 - done.contact.travel_m, 1e-9)
        << "row " << i;
  }
}

// A force that is held while the tool sinks counts as a hold, as a depth does.
TEST(TimedPress, a_force_that_is_held_is_a_hold) {
  Way slow = ramp_way(60);
  const std::vector<std::tuple<std::string, Relaxation, Way, bool>> cases{
      {"creep", prony({0.5}, {3}), creep_way(0.5, 3, 30), true},
      {"creep of a tenth", prony({0.1}, {5}), creep_way(0.1, 5, 30), true},
      {"creep after a slow way in", prony({0.5}, {20}), creep_way(0.5, 20, 60, 2), true},
      {"hold", prony({0.5}, {3}), hold_way(), true},
      {"slow way in", prony({}, {}), slow, false}};
  for (const auto& [name, relaxation, way, is_held] : cases)
    for (unsigned seed = 1; seed <= 10; ++seed)
      for (const double noise : {0.0, 0.01, 0.02}) {
        const auto presses = presses_of({name, relaxation, {way}, {noise, noise / 2}}, seed, 0.02);
        EXPECT_EQ(held_share(presses[0]) >= 0.1, is_held)
            << name << ", noise " << noise << ", seed " << seed;
      }
}

// A sensor of steps shows one value for seconds while the tool sinks. Once the free part before a
// long hold was too short to be seen, and what is free was "saturated over 100 %".
TEST(TimedPress, a_coarse_sensor_s_held_force_is_not_saturated) {
  std::mt19937 random(3);
  auto raw = record({prony({0.5}, {3}), 1}, creep_way(0.5, 3, 30), 0.02, 2, {0, 0}, random);
  const double step_N = 0.02 * *std::ranges::max_element(raw.push_N);
  for (double& push_N : raw.push_N) push_N = step_N * std::round(push_N / step_N);
  SignalSettings settings;
  settings.radius_m = 5e-3;
  const auto done = condition(raw, settings, std::nullopt, "press.csv");
  for (const RowStatus status : done.status) EXPECT_EQ(status, RowStatus::good);
}

}  // namespace
}  // namespace palpate::recordings
