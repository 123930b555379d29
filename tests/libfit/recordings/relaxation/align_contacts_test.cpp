#include "libfit/recordings/relaxation/fit_relaxation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/libfit/recordings/relaxation/relaxing_presses.hpp"

namespace palpate::recordings {
namespace {

using namespace testing_relaxation;

// Contacts found 0.3 mm too early and 0.2 mm too late, with deviations that say so.
TEST(Contacts, of_one_point_are_aligned_by_the_curve_they_share) {
  const Relaxation body = prony({0.5}, {1});
  std::vector<TimedPress> presses;
  for (const auto& [duration_s, off_m] : {std::pair{8., -3e-4}, {0.8, 2e-4}, {2., 0.}}) {
    std::mt19937 random(7);
    const auto raw = record({body, 1}, ramp_way(duration_s), 0.01, 2, {0.002, 0}, random);
    SignalSettings settings;
    settings.known_contact = {1e-3 + off_m, 3e-4};
    const Conditioned done = condition(raw, settings, std::nullopt, "press.csv", false);
    presses.push_back(done.history);
    presses.back().noise_N = done.noise_N, presses.back().contact_deviation_m = 3e-4;
  }
  const auto aligned = align_contacts(presses, body, SlowCurve::powers).contact;
  ASSERT_EQ(aligned.size(), 3u);
  EXPECT_NEAR(aligned[1].moved_m - aligned[0].moved_m, -5e-4, 1e-5);
  EXPECT_NEAR(aligned[2].moved_m - aligned[0].moved_m, -3e-4, 1e-5);
  // Three readings of one contact: their mean.
  EXPECT_NEAR(aligned[2].moved_m, -1e-4 / 3, 1e-5);
  for (const ContactShift& one : aligned) EXPECT_NEAR(one.deviation_m, 3e-4 / std::sqrt(3), 2e-6);
  for (TimedPress& press : presses) press.contact_deviation_m = 0;  // where the rig knows it
  for (const ContactShift& one : align_contacts(presses, body, SlowCurve::powers).contact) {
    EXPECT_EQ(one.moved_m, 0);
    EXPECT_EQ(one.deviation_m, 0);
  }
}

}  // namespace
}  // namespace palpate::recordings
