// What a user is shown of a recording.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/libfit/recordings/signal/presses.hpp"

namespace palpate::recordings {
namespace {

using namespace testing_signal;

// 20,000 readings, 1,000 of them in contact: few of equally spaced ones would show the press.
TEST(signal, a_trace_shows_the_whole_and_the_press) {
  auto raw = axial_press(20000, 200);
  for (double& travel : raw.travel_m) travel -= 19e-2;
  for (int i = 0; i < 20000; ++i) {
    const double depth = std::max(0.0, raw.travel_m[static_cast<std::size_t>(i)]);
    raw.push_N[static_cast<std::size_t>(i)] =
        0.05 + 3e2 * std::pow(depth, 1.5) + 1e-4 * std::sin(40.0 * i);
  }
  raw.push_N[700] = 0.5;  // a spike, that samples leave out
  const Conditioned r = condition(raw, {}, Vec3(0, 0, -1), "a.csv");
  const SignalTrace& t = r.trace;
  ASSERT_LE(t.readings(), 202u);
  for (const std::size_t n : {t.time_s.size(), t.travel_m.size(), t.phase.size(), t.is_used.size()})
    EXPECT_EQ(n, t.readings());
  EXPECT_EQ(t.time_s.front(), 0);
  EXPECT_TRUE(std::is_sorted(t.time_s.begin(), t.time_s.end()));
  EXPECT_EQ(*std::max_element(t.push_N.begin(), t.push_N.end()), 0.5f) << "as recorded";
  EXPECT_EQ(*std::max_element(t.travel_m.begin(), t.travel_m.end()),
            static_cast<float>(raw.travel_m.back()));
  const auto pressed =
      std::count_if(t.travel_m.begin(), t.travel_m.end(), [](float travel) { return travel > 0; });
  EXPECT_GT(pressed, 45);
  EXPECT_NEAR(t.bias_N, 0.05, 1e-4);
  EXPECT_NEAR(t.drift_N_m, 0, 1e-9);
}

TEST(signal, a_trace_says_the_line_that_was_taken_off) {
  auto raw = axial_press(400, 200);
  for (std::size_t i = 0; i < raw.push_N.size(); ++i) raw.push_N[i] += 20 * raw.travel_m[i];
  SignalSettings settings;
  settings.drift = Drift::line;
  settings.known_contact = FoundContact{1e-3, 0};  // a slope alone looks like contact
  const Conditioned r = condition(raw, settings, Vec3(0, 0, -1), "a.csv");
  EXPECT_NEAR(r.trace.drift_N_m, 20, 0.5);
  const SignalTrace& t = r.trace;
  for (std::size_t i = 0; i < t.readings(); ++i)
    EXPECT_NEAR(t.push_N[i] - t.bias_N - t.drift_N_m * t.travel_m[i],
                3e4 * std::pow(std::max(0.0, t.travel_m[i] - 1e-3), 1.5), 2e-3);
}

TEST(signal, a_refused_recording_keeps_its_trace) {
  auto raw = axial_press(400, 200);
  for (double& push : raw.push_N) push = 0.05 - push;
  SignalTrace trace;
  EXPECT_THROW(condition(raw, {}, Vec3(0, 0, -1), "a.csv", &trace), Error);
  EXPECT_GT(trace.readings(), 190u);
}

}  // namespace
}  // namespace palpate::recordings
