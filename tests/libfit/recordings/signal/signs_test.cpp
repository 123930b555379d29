// Signs that are reversed, told by the recording.

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/libfit/recordings/signal/presses.hpp"

namespace palpate::recordings {
namespace {

using namespace testing_signal;

// Once the way back was taken for the way in: 17 to 27 kPa for 10, "fair".
TEST(signal, a_press_with_both_signs_reversed_says_so) {
  for (const int readings : {25, 100, 1000})
    for (const double free_N : {0.0, 0.02, -0.05}) {
      auto raw = elastic_press(readings, 0.3, 1e-3, kPressSeed);
      for (double& push_N : raw.push_N) push_N += free_N;
      EXPECT_EQ(refusal_of(raw, {}), "") << readings;
      for (double& travel : raw.travel_m) travel = -travel;
      for (double& push : raw.push_N) push = -push;
      EXPECT_NE(refusal_of(raw, {}).find("depth and force both have the reversed sign"),
                std::string::npos)
          << readings << ", " << free_N << ": " << refusal_of(raw, {});
    }
}

TEST(signal, a_compression_without_free_travel_and_with_both_signs_reversed_says_so) {
  for (const double exponent : {1.0, 1.5, 2.0}) {
    importers::RawRecording raw;
    std::mt19937 random(kPressSeed);
    std::normal_distribution<double> noise(0, 5e-3);
    for (int i = 0; i <= 400; ++i) {
      const double share = i <= 200 ? i / 200.0 : 2 - i / 200.0;
      raw.travel_m.push_back(-5e-3 * share);
      raw.push_N.push_back(-10 * std::pow(share, exponent) + noise(random));
      raw.line.push_back(static_cast<std::size_t>(i) + 1);
    }
    EXPECT_NE(refusal_of(raw, {}).find("both have the reversed sign"), std::string::npos)
        << exponent << ": " << refusal_of(raw, {});
  }
}

TEST(signal, a_normal_that_points_outward_is_told_by_both_signs) {
  const auto axial = elastic_press(200, 0, 1e-3, kPressSeed);
  importers::RawRecording raw;
  raw.time_s = axial.time_s, raw.line = axial.line;
  raw.position_m = raw.force_N = Points::Zero(200, 3);
  for (Eigen::Index i = 0; i < 200; ++i) {
    raw.position_m(i, 2) = -axial.travel_m[static_cast<std::size_t>(i)];
    raw.force_N(i, 2) = -axial.push_N[static_cast<std::size_t>(i)];
  }
  EXPECT_EQ(refusal_of(raw, Vec3(0, 0, -1)), "");
  EXPECT_NE(refusal_of(raw, Vec3(0, 0, 1)).find("the normal points out of the body"),
            std::string::npos)
      << refusal_of(raw, Vec3(0, 0, 1));
}

/// Lines to and fro at 2 N, whatever the depth.
TEST(signal, a_scan_under_force_control_with_the_sign_reversed_says_so) {
  importers::RawRecording raw;
  raw.position_m = raw.force_N = Points::Zero(480, 3);
  for (int i = 0; i < 480; ++i) {
    const double heading = i / 40 % 2 == 0 ? 1 : -1, place = heading * (i % 40 - 19.5);
    raw.time_s.push_back(i / 60.0), raw.line.push_back(static_cast<std::size_t>(i) + 1);
    raw.position_m.row(i) << 1e-3 * place, 1e-4 * i, -1e-6 * place * place;
    raw.force_N.row(i) << 0.6 * heading, 0, -2;
  }
  SignalSettings scan;
  scan.kind = ExperimentKind::scan;
  EXPECT_EQ(condition_scan(raw, scan, {}, "a.csv").size(), 12);
  raw.force_N *= -1;
  EXPECT_THROW(condition_scan(raw, scan, {}, "a.csv"), Error);
}

}  // namespace
}  // namespace palpate::recordings
