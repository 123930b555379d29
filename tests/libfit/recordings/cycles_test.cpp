// Recordings of several cycles, and single readings out of line.

#include <gtest/gtest.h>

#include <cmath>

#include "libfit/core/error.hpp"
#include "libfit/recordings/batch/batch.hpp"

namespace palpate::recordings {
namespace {

// Two cycles with a loop of 5 % of the force around the curve, and single spikes.
importers::RawRecording cycles_with_spikes(bool has_spikes) {
  importers::RawRecording raw;
  for (int i = 0; i < 1600; ++i) {
    const int phase = i % 800;
    const bool is_in = phase < 400;
    const double travel = 5e-6 * (is_in ? phase : 800 - phase),
                 depth = std::max(0.0, travel - 5e-4),
                 loop = 0.05 * std::sin(M_PI * depth / 1.5e-3) * (is_in ? 1 : -1);
    raw.time_s.push_back(0.01 * i);
    raw.travel_m.push_back(travel);
    raw.line.push_back(static_cast<std::size_t>(i) + 2);
    raw.push_N.push_back(2e3 * depth + 3 * loop * 2e3 * depth + 1e-3 * std::sin(40.0 * i) +
                         (has_spikes && i % 50 == 17 ? 0.9 : 0));
  }
  return raw;
}

TEST(signal, the_mean_of_all_ways_is_the_middle_of_the_loop) {
  SignalSettings settings;
  const Conditioned in = condition(cycles_with_spikes(false), settings, {}, "loop");
  settings.use = Use::mean;
  const Conditioned middle = condition(cycles_with_spikes(false), settings, {}, "loop");
  EXPECT_NEAR(middle.contact.travel_m, 5e-4, 1e-5);
  double off_in = 0, off_middle = 0;
  for (Eigen::Index i = 0; i < middle.force_N.rows(); ++i)
    off_middle = std::max(
        off_middle, std::abs(middle.force_N(i, 0) -
                             2e3 * (middle.contact.travel_m - 5e-4 + middle.deflection_m(i, 0))));
  for (Eigen::Index i = 0; i < in.force_N.rows(); ++i)
    off_in = std::max(off_in, std::abs(in.force_N(i, 0) - 2e3 * in.deflection_m(i, 0)));
  EXPECT_LT(off_middle, 0.01);
  EXPECT_GT(off_in, 0.1);
  EXPECT_LT(middle.error_N.mean(), 0.7 * in.error_N.mean());
  settings.kind = ExperimentKind::drag;
  importers::RawRecording drag = cycles_with_spikes(false);
  drag.position_m.resize(1600, 3);
  drag.force_N.resize(1600, 3);
  for (int i = 0; i < 1600; ++i)
    drag.position_m.row(i) << 0, 0, -drag.travel_m[static_cast<std::size_t>(i)],
        drag.force_N.row(i) << 0, 0, -drag.push_N[static_cast<std::size_t>(i)];
  EXPECT_THROW(condition(drag, settings, Vec3(0, 0, -1), "drag"), Error);
  settings.use = Use::approach, settings.cycle = 1;
  EXPECT_THROW(condition(drag, settings, Vec3(0, 0, -1), "drag"), Error);
}

// The second cycle of a file was never mentioned, not even when it was 20 % softer.
TEST(signal, of_several_presses_one_is_taken_and_the_others_are_said) {
  importers::RawRecording raw = cycles_with_spikes(false);
  for (std::size_t i = 800; i < raw.push_N.size(); ++i) raw.push_N[i] *= 0.8;
  const auto largest_N = [&](int cycle) {
    SignalSettings settings;
    settings.cycle = cycle;
    const Conditioned done = condition(raw, settings, {}, "loop");
    EXPECT_EQ(done.grade, Grade::fair) << cycle;
    const int taken = cycle == kLastCycle || cycle == 2 ? 2 : 1;
    const bool is_said = std::ranges::any_of(done.reasons, [&](const std::string& reason) {
      return reason == "holds 2 presses as deep; number " + std::to_string(taken) +
                           " is taken, and the last is 20 % softer than the first";
    });
    EXPECT_TRUE(is_said) << "cycle " << cycle;
    return done.force_N.col(0).maxCoeff();
  };
  const double first_N = largest_N(1);
  EXPECT_DOUBLE_EQ(largest_N(kDeepestCycle), first_N);
  EXPECT_NEAR(largest_N(2), 0.8 * first_N, 0.01 * first_N);
  EXPECT_DOUBLE_EQ(largest_N(kLastCycle), largest_N(2));
  SignalSettings third;
  third.cycle = 3;
  EXPECT_THROW(condition(raw, third, {}, "loop"), Error);

  const Conditioned alike = condition(cycles_with_spikes(false), {}, {}, "loop");
  EXPECT_EQ(alike.grade, Grade::good);
  EXPECT_EQ(alike.reasons, std::vector<std::string>{"holds 2 presses as deep; number 1 is taken"});
}

TEST(signal, single_spikes_are_left_out_and_counted) {
  const Conditioned clean = condition(cycles_with_spikes(false), {}, {}, "clean"),
                    spiked = condition(cycles_with_spikes(true), {}, {}, "spiked");
  ASSERT_EQ(clean.force_N.rows(), spiked.force_N.rows());
  EXPECT_LT((clean.force_N - spiked.force_N).cwiseAbs().maxCoeff(), 0.02);
  EXPECT_EQ(clean.reasons.size(), 1u) << "that there are two presses";
  ASSERT_EQ(spiked.reasons.size(), 2u);
  EXPECT_EQ(spiked.reasons[0].substr(0, 18), "32 single readings");
}

}  // namespace
}  // namespace palpate::recordings
