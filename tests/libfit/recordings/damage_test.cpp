// Recordings of bodies that break: forces that drop.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "libfit/recordings/placing/assemble.hpp"

namespace palpate::recordings {
namespace {

constexpr double kFree_m = 1e-3, kRate_Hz = 200, kSpeed_m_s = 2e-3, kStiff_N_m2 = 2e4;

double curve_N(double depth_m) { return depth_m > 0 ? kStiff_N_m2 * depth_m * depth_m : 0; }

// Led from travel to travel at one speed; push by a curve, and noise.
importers::RawRecording led(const std::vector<double>& turns_m, unsigned seed,
                            double noise_N = 2e-3, double breaks_N = 1e9) {
  importers::RawRecording raw;
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, noise_N);
  double travel = turns_m.front();
  bool is_broken = false;
  for (std::size_t leg = 1; leg < turns_m.size(); ++leg) {
    const double stride = kSpeed_m_s / kRate_Hz * (turns_m[leg] > travel ? 1 : -1);
    const int rows = static_cast<int>(std::abs((turns_m[leg] - travel) / stride));
    for (int k = 0; k < rows; ++k) {
      travel += stride;
      const double depth = travel - kFree_m;
      double push = curve_N(depth);
      is_broken |= push >= breaks_N;
      if (is_broken) push = 0.2 * breaks_N + 5 * std::max(0.0, depth);
      raw.time_s.push_back(static_cast<double>(raw.time_s.size()) / kRate_Hz);
      raw.travel_m.push_back(travel);
      raw.push_N.push_back(push + 0.05 + noise(random));
      raw.line.push_back(raw.line.size() + 2);
    }
  }
  return raw;
}

TEST(damage_recordings, a_push_that_drops_is_told_and_ends_the_curve) {
  SignalSettings settings;
  for (const unsigned seed : {1u, 2u, 3u}) {
    const Conditioned r = condition(led({0, 9e-3, 0}, seed, 2e-3, 0.4), settings, {}, "needle");
    EXPECT_TRUE(r.breaks) << "seed " << seed;
    EXPECT_LE(r.deflection_m.col(0).maxCoeff(), std::sqrt(0.4 / kStiff_N_m2) + 3e-4);
    EXPECT_TRUE(std::ranges::any_of(
        r.reasons,
        [](const std::string& reason) { return reason.starts_with("the force falls from 0."); }))
        << "seed " << seed;
  }
  const Conditioned whole = condition(led({0, 9e-3, 0}, 1), settings, {}, "whole");
  EXPECT_FALSE(whole.breaks);
  EXPECT_NEAR(whole.deflection_m.col(0).maxCoeff(), 8e-3, 3e-4);
}

TEST(damage_recordings, a_force_that_relaxes_or_springs_back_is_none) {
  importers::RawRecording raw = led({0, 6e-3}, 4);
  const std::size_t held = raw.push_N.size();
  const double top = raw.push_N.back();
  for (int k = 0; k < 400; ++k) {  // a hold, and on
    raw.travel_m.push_back(raw.travel_m.back());
    raw.push_N.push_back(top * (0.5 + 0.5 * std::exp(-k / 20.0)));
  }
  for (int k = 0; k < 300; ++k) {
    raw.travel_m.push_back(raw.travel_m.back() + kSpeed_m_s / kRate_Hz);
    raw.push_N.push_back(0.5 * top + curve_N(raw.travel_m.back() - kFree_m) - top);
  }
  while (raw.time_s.size() < raw.push_N.size()) {
    raw.time_s.push_back(static_cast<double>(raw.time_s.size()) / kRate_Hz);
    raw.line.push_back(raw.line.size() + 2);
  }
  ASSERT_GT(raw.push_N.size(), held);
  EXPECT_FALSE(condition(raw, {}, {}, "held").breaks);
}

TEST(damage_recordings, a_batch_tells_where_tools_broke_in) {
  std::vector<BatchItem> items;
  std::vector<ItemResult> results;
  for (int i = 0; i < 4; ++i) {
    BatchItem item;
    item.shown = item.file = "press" + std::to_string(i) + ".csv";
    item.point = "p" + std::to_string(i / 2);
    item.position_m = Vec3(0.01 * (i / 2), 0, 0);
    item.normal = Vec3(0, 0, -1);
    const double breaks_N = 0.4 + 0.1 * (i / 2) + 0.01 * (i % 2);
    ItemResult result;
    result.is_done = true;
    result.recordings.push_back(
        condition(led({0, 9e-3, 0}, static_cast<unsigned>(i), 1e-3, breaks_N), item.signal,
                  *item.normal, item.shown));
    items.push_back(item);
    results.push_back(result);
  }
  const Assembled out = assemble(items, results, {});
  EXPECT_EQ(out.failed(), 0u);
  ASSERT_FALSE(out.notes.empty());
  EXPECT_EQ(out.notes[0].substr(0, 47), "the tool breaks in in 4 recordings at 2 points;");
}

}  // namespace
}  // namespace palpate::recordings
