// The work that a press does not give back.

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/libfit/recordings/signal/presses.hpp"

namespace palpate::recordings {
namespace {

using namespace testing_signal;

// Once the way out began a reading or more after the deepest one: +24 % at 25 readings.
TEST(signal, an_elastic_press_has_no_hysteresis_however_it_is_sampled) {
  for (const int readings : {25, 26, 50, 51, 100, 250})
    for (const double turn : {0.0, 0.3, 0.5, 0.8}) {
      SignalSettings settings;
      settings.radius_m = 5e-3;
      const Conditioned r =
          condition(elastic_press(readings, turn, 1e-4, kPressSeed), settings, {}, "a.csv");
      EXPECT_NEAR(r.hysteresis, 0, 0.01)
          << readings << " readings, turn " << turn << ", seed " << kPressSeed;
    }
}

// Noise on a flat top once put the largest push rows before the turn, and there was no way back.
TEST(signal, a_noisy_press_of_many_readings_has_its_way_back) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const Conditioned r = condition(elastic_press(4000, 0, 5e-3, seed), {}, {}, "a.csv");
    EXPECT_NEAR(r.hysteresis, 0, 0.02) << "seed " << seed;
  }
}

// Half of the work lost, in closed form: the way out has half the force of the way in.
TEST(signal, the_work_that_is_lost_is_the_hysteresis) {
  for (const int readings : {25, 100, 250}) {
    auto raw = elastic_press(readings, 0, 0, kPressSeed);
    for (std::size_t i = raw.push_N.size() / 2 + 1; i < raw.push_N.size(); ++i) raw.push_N[i] /= 2;
    const Conditioned r = condition(raw, {}, {}, "a.csv");
    // Half, but for the step at the turn: a trapezium from the whole to half of the force.
    EXPECT_NEAR(r.hysteresis, 0.5, readings < 50 ? 0.07 : 0.02) << readings;
  }
}

// Once the work of a file that ends in contact, on the way out or in a hold, was "not given back".
TEST(signal, a_recording_that_ends_in_contact_says_nothing_of_the_work_given_back) {
  const auto whole =
      elastic_press(400, 0, 1e-4, kPressSeed);  // 400 readings, deepest in the middle
  const auto hysteresis = [&](int way_out, int hold, double jitter_m) {
    auto raw = whole;
    const std::size_t kept = 200 + way_out;
    raw.travel_m.resize(kept), raw.push_N.resize(kept);
    std::mt19937 random(kPressSeed);
    std::normal_distribution<double> noise(0, 1);
    for (int i = 0; i < hold; ++i) {
      raw.travel_m.push_back(raw.travel_m[kept - 1] + jitter_m * noise(random));
      raw.push_N.push_back(raw.push_N[kept - 1] + 1e-4 * noise(random));
    }
    raw.time_s.clear(), raw.line.clear();
    for (std::size_t i = 0; i < raw.travel_m.size(); ++i)
      raw.time_s.push_back(0.02 * static_cast<double>(i)), raw.line.push_back(i + 2);
    return condition(raw, {}, {}, "a.csv").hysteresis;
  };
  for (const int way_out : {0, 3, 10, 50, 100})
    EXPECT_TRUE(std::isnan(hysteresis(way_out, 0, 0))) << way_out;
  for (const double jitter_m : {0.0, 1e-6, 2e-5, 5e-5})
    EXPECT_TRUE(std::isnan(hysteresis(0, 200, jitter_m))) << jitter_m;
  for (const int way_out : {140, 150, 200})  // less than a percent of the work is stored, or none
    EXPECT_NEAR(hysteresis(way_out, 0, 0), 0, 0.015) << way_out;
}

// Once a force 0.5 s late put the contact 1 mm too deep, known to 0.05 mm, and the grade was fair.
TEST(signal, a_force_that_lags_is_no_good_recording_and_its_delay_is_said) {
  constexpr double kContact_m = 1e-3;  // of elastic_press
  for (const double noise_N : {5e-5, 2e-4})
    for (const int late : {0, 5, 20, 40}) {
      SCOPED_TRACE(testing::Message()
                   << "noise " << noise_N << ", late by " << late << " readings");
      auto raw = elastic_press(400, 0, noise_N, kPressSeed);
      const auto push_N = raw.push_N;
      for (int i = 0; i < 400; ++i)
        raw.push_N[static_cast<std::size_t>(i)] =
            push_N[static_cast<std::size_t>(std::clamp(i - late, 0, 399))];
      const Conditioned r = condition(raw, {}, {}, "a.csv");
      const std::string reasons = testing::PrintToString(r.reasons);
      EXPECT_NEAR(r.contact.travel_m, kContact_m, 2 * r.contact.deviation_m) << reasons;
      EXPECT_EQ(r.grade == Grade::good, late == 0) << reasons;
      const std::size_t at = reasons.find("force_delay = ");
      ASSERT_EQ(at != std::string::npos, late > 0) << reasons;
      if (late == 0) continue;
      SignalSettings settings;
      settings.force_delay_s = std::stod(reasons.substr(reasons.find_first_of("0123456789", at)));
      EXPECT_NEAR(settings.force_delay_s, 0.02 * late, 0.01);
      const Conditioned corrected = condition(raw, settings, {}, "a.csv");
      EXPECT_EQ(corrected.grade, Grade::good);
      EXPECT_NEAR(corrected.contact.travel_m, kContact_m, 2 * corrected.contact.deviation_m);
    }
}

TEST(signal, a_press_that_loses_work_is_not_questioned) {
  auto raw = elastic_press(400, 0, 1e-4, kPressSeed);
  for (std::size_t i = 200; i < 400; ++i) raw.push_N[i] *= 0.8;
  const Conditioned r = condition(raw, {}, {}, "a.csv");
  EXPECT_EQ(r.grade, Grade::good) << testing::PrintToString(r.reasons);
  EXPECT_TRUE(r.reasons.empty()) << testing::PrintToString(r.reasons);
}

}  // namespace
}  // namespace palpate::recordings
