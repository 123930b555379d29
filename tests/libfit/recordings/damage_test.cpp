// Recordings of bodies that soften and break: presses in cycles, and forces that drop.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "libfit/core/experiments.hpp"
#include "libfit/recordings/placing/assemble.hpp"
#include "libfit/runtime/law/softening.hpp"

namespace palpate::recordings {
namespace {

constexpr double kFree_m = 1e-3, kRate_Hz = 200, kSpeed_m_s = 2e-3, kStiff_N_m2 = 2e4;

double curve_N(double depth_m) { return depth_m > 0 ? kStiff_N_m2 * depth_m * depth_m : 0; }
double curve_J(double depth_m) { return depth_m > 0 ? kStiff_N_m2 * std::pow(depth_m, 3) / 3 : 0; }

// Led from travel to travel at one speed; push by the softening law, and noise.
importers::RawRecording led(const std::vector<double>& turns_m, const runtime::DamageView& damage,
                            unsigned seed, double noise_N = 2e-3, double breaks_N = 1e9) {
  importers::RawRecording raw;
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, noise_N);
  double most_J = 0, travel = turns_m.front();
  bool is_broken = false;
  for (std::size_t leg = 1; leg < turns_m.size(); ++leg) {
    const double stride = kSpeed_m_s / kRate_Hz * (turns_m[leg] > travel ? 1 : -1);
    const int rows = static_cast<int>(std::abs((turns_m[leg] - travel) / stride));
    for (int k = 0; k < rows; ++k) {
      travel += stride;
      const double depth = travel - kFree_m, law_J = curve_J(depth);
      most_J = std::max(most_J, law_J);
      double push = curve_N(depth);
      if (damage.softens()) push *= runtime::softened(damage, curve_J(6e-3), most_J, law_J).share;
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

const std::vector<double> kCycles{0, 3e-3, 0.5e-3, 5e-3, 0.5e-3, 7e-3, 0.5e-3};

TEST(damage_recordings, a_press_in_cycles_has_the_rows_of_first_loading_and_all_its_ways) {
  const runtime::DamageView damage{0.8, 0.05, 0.3, 0};
  SignalSettings settings;
  const Conditioned r = condition(led(kCycles, damage, 5), settings, {}, "cycles", false);
  EXPECT_NEAR(r.contact.travel_m, kFree_m, 2e-4);
  EXPECT_NEAR(r.deflection_m.col(0).maxCoeff(), 6e-3, 4e-4);
  for (Eigen::Index i = 0; i < r.force_N.rows(); ++i)
    EXPECT_NEAR(r.force_N(i, 0), curve_N(r.deflection_m(i, 0) + r.contact.travel_m - kFree_m), 0.03)
        << r.deflection_m(i, 0);
  ASSERT_GT(r.cycles.depth_m.size(), 60);
  int turns = 0;
  double softest = 1, way_m = 0;
  for (Eigen::Index i = 1; i < r.cycles.depth_m.size(); ++i) {
    const double next_m = r.cycles.depth_m[i] - r.cycles.depth_m[i - 1];
    if (std::abs(next_m) < 1e-5) continue;  // either side of a turn
    turns += next_m * way_m < 0;
    way_m = next_m;
    if (r.cycles.depth_m[i] > 2.5e-3)
      softest = std::min(softest, r.cycles.push_N[i] / curve_N(r.cycles.depth_m[i]));
  }
  EXPECT_EQ(turns, 5);
  EXPECT_LT(softest, 0.4);
}

TEST(damage_recordings, ways_in_that_go_no_deeper_are_no_cycles) {
  SignalSettings settings;
  const Conditioned same =
      condition(led({0, 5e-3, 0.5e-3, 5e-3, 0.5e-3}, {}, 3), settings, {}, "same", false);
  EXPECT_EQ(same.cycles.depth_m.size(), 0);
  const Conditioned air =
      condition(led({0, 0.8e-3, 0, 5e-3, 0}, {}, 3), settings, {}, "air", false);
  EXPECT_EQ(air.cycles.depth_m.size(), 0) << "the first way in touches nothing";
  EXPECT_FALSE(air.breaks);
}

TEST(damage_recordings, a_push_that_drops_is_told_and_ends_the_curve) {
  SignalSettings settings;
  for (const unsigned seed : {1u, 2u, 3u}) {
    const Conditioned r =
        condition(led({0, 9e-3, 0}, {}, seed, 2e-3, 0.4), settings, {}, "needle", false);
    EXPECT_TRUE(r.breaks) << "seed " << seed;
    EXPECT_LE(r.deflection_m.col(0).maxCoeff(), std::sqrt(0.4 / kStiff_N_m2) + 3e-4);
    EXPECT_TRUE(std::ranges::any_of(
        r.reasons,
        [](const std::string& reason) { return reason.starts_with("the force falls from 0."); }))
        << "seed " << seed;
  }
  const Conditioned whole = condition(led({0, 9e-3, 0}, {}, 1), settings, {}, "whole", false);
  EXPECT_FALSE(whole.breaks);
  EXPECT_NEAR(whole.deflection_m.col(0).maxCoeff(), 8e-3, 3e-4);
}

TEST(damage_recordings, a_force_that_relaxes_or_springs_back_is_none) {
  importers::RawRecording raw = led({0, 6e-3}, {}, 4);
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
  EXPECT_FALSE(condition(raw, {}, {}, "held", false).breaks);
}

TEST(damage_recordings, a_batch_tells_where_tools_broke_in_and_what_was_cycled) {
  std::vector<BatchItem> items;
  std::vector<ItemResult> results;
  for (int i = 0; i < 6; ++i) {
    BatchItem item;
    item.shown = item.file = "press" + std::to_string(i) + ".csv";
    item.point = i < 4 ? "p" + std::to_string(i / 2) : "cycled";
    item.position_m = Vec3(0.01 * (i / 2), 0, 0);
    item.normal = Vec3(0, 0, -1);
    const double breaks_N = i < 4 ? 0.4 + 0.1 * (i / 2) + 0.01 * (i % 2) : 1e9;
    ItemResult result;
    result.is_done = true;
    result.recordings.push_back(
        condition(led(i < 4 ? std::vector<double>{0, 9e-3, 0} : kCycles,
                      i < 4 ? runtime::DamageView{} : runtime::DamageView{1.3, 0.05, 0.3, 0},
                      static_cast<unsigned>(i), 1e-3, breaks_N),
                  item.signal, *item.normal, item.shown, false));
    items.push_back(item);
    results.push_back(result);
  }
  const Assembled out = assemble(items, results, {});
  EXPECT_EQ(out.failed(), 0u);
  ASSERT_FALSE(out.notes.empty());
  EXPECT_EQ(out.notes[0].substr(0, 47), "the tool breaks in in 4 recordings at 2 points;");
  const Samples cycles = of_kinds(out.samples, {ExperimentKind::cycle});
  ASSERT_GT(cycles.rows(), 100);
  EXPECT_EQ(cycles.experiment.back(), cycles.experiment.front() + 1);
  EXPECT_EQ(cycles.point_name[0], "cycled");
  EXPECT_EQ(cycles.deflection.col(0).cwiseAbs().maxCoeff(), 0) << "along the normal";
}

}  // namespace
}  // namespace palpate::recordings
