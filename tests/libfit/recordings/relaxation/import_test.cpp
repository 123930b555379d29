// From recordings that relax to samples in time.

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <random>

#include "libfit/io/files/files.hpp"
#include "libfit/recordings/placing/assemble.hpp"
#include "tests/libfit/io/scratch.hpp"
#include "tests/libfit/recordings/relaxation/relaxing_presses.hpp"

namespace palpate::recordings {
namespace {

using namespace testing_relaxation;

class RelaxationImport : public testing_io::ScratchTest {
 protected:
  // A recording as a file and its entry.
  BatchItem item_of(const importers::RawRecording& raw, const std::string& name) const {
    BatchItem item;
    item.file = folder_ / name;
    std::ofstream out(item.file);
    out << "t,z,f\n";
    for (std::size_t k = 0; k < raw.time_s.size(); ++k)
      out << raw.time_s[k] << "," << 1e3 * raw.travel_m[k] << "," << raw.push_N[k] << "\n";
    item.shown = item.file.filename();
    item.point = "p";
    item.position_m = Vec3::Zero();
    item.normal = Vec3(0, 0, -1);
    item.read.columns.time = "t", item.read.columns.depth = "z", item.read.columns.force = {"f"};
    item.read.units = {"s", "mm", "N"};
    item.read.is_force_on_tool = false;
    item.signal.radius_m = 5e-3;
    return item;
  }
};

TEST_F(RelaxationImport, gives_rows_in_time_and_keeps_rates_apart) {
  // Two repeats at one speed, which would be pooled, with a hold.
  std::vector<BatchItem> items;
  const RecoveryCase c = recovery_cases()[1];
  for (int i = 0; i < 2; ++i) {
    std::mt19937 random(static_cast<unsigned>(40 + i));
    items.push_back(item_of(record({c.relaxation, 1}, c.ways[0], 0.01, 2, {0.003, 0}, random),
                            "hold" + std::to_string(i) + ".csv"));
  }
  BatchOptions batch;
  batch.jobs = 1;
  const auto results = run_batch(items, batch, Progress{});
  const Assembled found = assemble(items, results, {});
  for (const PlacedRecording& outcome : found.outcomes)
    ASSERT_FALSE(outcome.failure) << outcome.failure->fact();
  ASSERT_TRUE(found.relaxation);
  const Samples& samples = found.samples;
  ASSERT_EQ(samples.relaxation.branches(), 1);
  EXPECT_NEAR(samples.relaxation.share[0], 0.5, 0.03);
  EXPECT_NEAR(samples.relaxation.time_s[0], 3, 0.3);
  ASSERT_EQ(samples.time_s.size(), samples.rows());
  EXPECT_EQ(samples.experiment.back(), 1);
  EXPECT_GT(samples.time_s.maxCoeff(), 20);
  EXPECT_NE(found.notes.at(0).find("relaxation"), std::string::npos);
  for (const Eigen::Index r : {0, 1})  // both touch after 1 mm
    EXPECT_NEAR(samples.recordings.contact_m[r], 1e-3,
                3 * samples.recordings.contact_deviation_m[r]);

  write_samples(folder_ / "samples.h5", samples, {});
  const Samples back = read_samples(folder_ / "samples.h5");
  EXPECT_EQ(back.time_s, samples.time_s);

  BatchOptions none;
  none.relaxation = RelaxationUse::none;
  const Assembled pooled = assemble(items, results, none);
  EXPECT_EQ(pooled.samples.time_s.size(), 0);
  EXPECT_EQ(pooled.samples.experiment.back(), 0);
}

// The depth creeps as d^{3/2} = 1 + g - g e^{-t/((1 + g) tau)} times that at first.
TEST_F(RelaxationImport, of_a_press_whose_force_stays_while_it_creeps_finds_the_series) {
  constexpr double kShare = 0.5, kTime_s = 3, kSeconds = 30;
  std::mt19937 random(7);
  const auto raw = record({prony({kShare}, {kTime_s}), 1}, creep_way(kShare, kTime_s, kSeconds),
                          0.01, 2, {0.003, 0}, random);
  const std::vector<BatchItem> items{item_of(raw, "creep.csv")};
  BatchOptions batch;
  batch.jobs = 1;
  const Assembled found = assemble(items, run_batch(items, batch, Progress{}), {});
  for (const PlacedRecording& outcome : found.outcomes)
    ASSERT_FALSE(outcome.failure) << outcome.failure->fact();
  ASSERT_TRUE(found.relaxation);
  const Samples& samples = found.samples;
  ASSERT_EQ(samples.relaxation.branches(), 1);
  EXPECT_NEAR(samples.relaxation.share[0], kShare, 0.05);
  EXPECT_NEAR(samples.relaxation.time_s[0], kTime_s, 0.5);
  ASSERT_EQ(samples.time_s.size(), samples.rows());
  EXPECT_GT(samples.time_s.maxCoeff(), 20);
  EXPECT_TRUE(found.relaxation->has_holds);
}

// A body that goes on relaxing where the recordings end, and one whose points differ: rows in time
// would be worse than the mean of repeats (once 153 % against 66 of points left out).
TEST_F(RelaxationImport, what_is_doubted_is_proposed_and_not_applied) {
  std::vector<BatchItem> slow, uneven;
  std::mt19937 random(11);
  for (int i = 0; i < 2; ++i) {
    slow.push_back(item_of(record({prony({2}, {60}), 1}, hold_way(10), 0.01, 2, {0.003, 0}, random),
                           "slow" + std::to_string(i) + ".csv"));
    uneven.push_back(item_of(
        record({prony({i == 0 ? 0.3 : 1.2}, {2}), 1}, hold_way(20), 0.01, 2, {0.003, 0}, random),
        "uneven" + std::to_string(i) + ".csv"));
    uneven.back().point = "p" + std::to_string(i);
    uneven.back().position_m = Vec3(0.01 * i, 0, 0);
  }
  BatchOptions batch;
  batch.jobs = 1;
  for (const auto& [items, doubt] :
       {std::pair{slow, std::string("a branch is slower than the recordings")},
        {uneven, std::string("points do not relax alike")}}) {
    const auto results = run_batch(items, batch, Progress{});
    const Assembled proposed = assemble(items, results, {});
    ASSERT_TRUE(proposed.relaxation);
    EXPECT_GT(proposed.relaxation->fit.relaxation.branches(), 0) << doubt;
    EXPECT_EQ(proposed.relaxation->doubts, std::vector<std::string>{doubt});
    EXPECT_FALSE(proposed.relaxation->is_applied);
    EXPECT_EQ(proposed.samples.relaxation.branches(), 0);
    EXPECT_EQ(proposed.samples.time_s.size(), 0);
    const bool is_said = std::ranges::any_of(proposed.notes, [&](const std::string& note) {
      return note.starts_with("relaxation is proposed, not applied: " + doubt);
    });
    EXPECT_TRUE(is_said) << doubt;
    BatchOptions always;
    always.relaxation = RelaxationUse::always;
    const Assembled applied = assemble(items, results, always);
    EXPECT_TRUE(applied.relaxation->is_applied);
    EXPECT_GT(applied.samples.relaxation.branches(), 0);
    EXPECT_EQ(applied.samples.time_s.size(), applied.samples.rows());
  }
}

}  // namespace
}  // namespace palpate::recordings
