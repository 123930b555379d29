// Where a press begins and ends, and what is no end of it.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "libfit/recordings/signal/signal.hpp"
#include "tests/libfit/recordings/signal/presses.hpp"

namespace palpate::recordings {
namespace {

using namespace testing_signal;

TEST(signal, approach_hold_slide_and_retract_are_told_apart) {
  Signal signal;
  signal.inward = Vec3(0, 0, -1);
  std::vector<Vec3> way;
  for (int i = 0; i < 100; ++i) way.emplace_back(0, 0, -1e-5 * i);
  for (int i = 0; i < 100; ++i) way.emplace_back(0, 0, -1e-3);
  for (int i = 0; i < 100; ++i) way.emplace_back(1e-5 * i, 0, -1e-3);
  for (int i = 0; i < 100; ++i) way.emplace_back(1e-3, 0, -1e-3 + 1e-5 * i);
  signal.position_m.resize(400, 3);
  signal.force_N = Points::Zero(400, 3);
  for (int i = 0; i < 400; ++i) signal.position_m.row(i) = way[static_cast<std::size_t>(i)];
  for (const double jitter_m : {0., 1e-7, 1e-6, 5e-6})
    for (unsigned seed = 1; seed <= 10; ++seed) {
      std::mt19937 random(seed);
      std::normal_distribution<double> draw(0, 1);
      for (std::size_t i = 0; i < way.size(); ++i)
        signal.position_m.row(static_cast<Eigen::Index>(i)) << way[i].x() + jitter_m * draw(random),
            way[i].y() + jitter_m * draw(random), way[i].z();
      const auto phases = find_phases(signal);
      EXPECT_EQ(phases[50], Phase::approach) << jitter_m << " m, seed " << seed;
      EXPECT_EQ(phases[150], Phase::hold) << jitter_m << " m, seed " << seed;
      EXPECT_EQ(phases[250], Phase::slide) << jitter_m << " m, seed " << seed;
      EXPECT_EQ(phases[350], Phase::retract) << jitter_m << " m, seed " << seed;
    }
}

// Once 0.1 mm of noise beside 10 um of way a reading was a slide: "the tip goes in over 4 rows".
TEST(signal, an_encoders_noise_beside_the_way_ends_no_press) {
  const Vec3 inward(0, 0, -1);
  for (const int readings : {50, 250, 1000})
    for (const double jitter_m : {1e-7, 1e-6, 1e-5, 1e-4, 3e-4})
      for (unsigned seed = 1; seed <= 5; ++seed) {
        const auto axis = elastic_press(readings, 0.3, 1e-3, seed);
        importers::RawRecording robot = axis;
        std::mt19937 random(seed);
        std::normal_distribution<double> draw;
        robot.travel_m.clear(), robot.push_N.clear();
        robot.position_m.resize(readings, 3), robot.force_N.resize(readings, 3);
        const double lean = std::tan(2.0 * seed * 3.14159265 / 180);  // to 10 degrees
        for (int i = 0; i < readings; ++i) {
          const auto at = static_cast<std::size_t>(i);
          const double travel_m = axis.travel_m[at], push_N = axis.push_N[at];
          robot.position_m.row(i) << lean * travel_m + jitter_m * draw(random),
              jitter_m * draw(random), -travel_m;
          robot.force_N.row(i) << 0.05 * push_N, 0, -push_N;
        }
        const Conditioned one = condition(axis, {}, {}, "axis.csv"),
                          three = condition(robot, {}, inward, "robot.csv");
        const auto where = testing::Message()
                           << readings << " readings, " << jitter_m << " m, seed " << seed;
        EXPECT_NEAR(three.contact.travel_m, one.contact.travel_m, 1e-6) << where;
        ASSERT_EQ(three.deflection_m.rows(), one.deflection_m.rows()) << where;
        // A reading at the turn may count in one alone: rows then have other readings, with a noise
        // of 1 mN each, and move along the curve.
        const auto hertz_N = [](double depth_m) {
          return 4.0 / 3 * 1e4 / 0.75 * std::sqrt(5e-3) * std::pow(depth_m, 1.5);
        };
        for (Eigen::Index i = 0; i < one.deflection_m.rows(); ++i) {
          const double depth_m = three.deflection_m.row(i) * inward,
                       push_N = three.force_N.row(i) * inward,
                       of_axis_N = one.force_N(i, 0) - hertz_N(one.deflection_m(i, 0));
          EXPECT_NEAR(push_N - hertz_N(depth_m), of_axis_N, 3e-3) << where << ", row " << i;
        }
      }
}

// Once a light that waved while a pyramid was pressed in 0.2 um was "the tool breaks in", and 16
// presses of a force map ended at a sixth of their depth.
TEST(signal, push_that_waves_while_the_tip_goes_in_is_no_break) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    auto raw = elastic_press(1000, 0.3, 1e-4, seed);
    std::mt19937 random(seed);
    std::normal_distribution<double> draw;
    double wave = 0, before = 0;
    for (double& push_N : raw.push_N) {
      wave = 0.7 * wave + draw(random);
      if (push_N > 0.01) push_N += 0.008 * (wave + before) / 2;
      before = wave;
    }
    const Conditioned r = condition(raw, {}, {}, "a.csv");
    EXPECT_FALSE(r.breaks) << "seed " << seed;
    EXPECT_GT(r.deflection_m.col(0).maxCoeff(), 2.5e-3) << "seed " << seed;
  }
}

// Microscopes may begin with the way back from a press: force and signs are right.
TEST(signal, a_recording_that_begins_with_a_way_back_is_read) {
  for (const double free_N : {0.0, -0.02, -1.0}) {
    auto raw = elastic_press(400, 0, 1e-3, kPressSeed);
    std::rotate(raw.travel_m.begin(), raw.travel_m.begin() + 200, raw.travel_m.end());
    std::rotate(raw.push_N.begin(), raw.push_N.begin() + 200, raw.push_N.end());
    for (double& push_N : raw.push_N) push_N += free_N;
    EXPECT_EQ(refusal_of(raw, {}), "") << free_N;
  }
}

}  // namespace
}  // namespace palpate::recordings
