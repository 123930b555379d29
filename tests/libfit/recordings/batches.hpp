#pragma once

#include <gtest/gtest.h>

#include "libfit/io/atomic_file.hpp"
#include "libfit/io/files/files.hpp"
#include "libfit/recordings/placing/assemble.hpp"
#include "tests/libfit/io/scratch.hpp"
#include "tests/libfit/recordings/synthetic.hpp"

namespace palpate::recordings {

using namespace testing_recordings;

inline constexpr unsigned kSeed = 20261121;

/// Synthetic batches, and what is checked of all of them.
class BatchTest : public testing_io::ScratchTest {
 protected:
  std::vector<BatchItem> make(int count) {
    std::vector<BatchItem> items;
    for (int i = 0; i < count; ++i) {
      items.push_back(item_of(folder_, i, kSeed));
      write_recording(items.back().file, i, kSeed);
    }
    return items;
  }
  // Samples and summaries as bytes.
  std::string outcome(const std::vector<BatchItem>& items, const std::vector<ItemResult>& results,
                      const std::string& name) {
    const Assembled assembled = assemble(items, results, {});
    write_samples(at(name + ".h5"), assembled.samples);
    write_signals(at(name + ".signals.h5"), signals_of(assembled));
    write_summary(at(name + ".csv"), at(name + ".json"), assembled);
    return read_whole_file(at(name + ".h5")) + read_whole_file(at(name + ".csv")) +
           read_whole_file(at(name + ".json")) + read_whole_file(at(name + ".signals.h5"));
  }
  void check(const std::vector<BatchItem>& items, const std::vector<ItemResult>& results);
};

inline void BatchTest::check(const std::vector<BatchItem>& items,
                             const std::vector<ItemResult>& results) {
  const Assembled assembled = assemble(items, results, {});
  ASSERT_EQ(assembled.outcomes.size(), items.size());
  double worst_contact_m = 0, worst_force = 0;
  for (std::size_t i = 0; i < items.size(); ++i) {
    const Truth truth = truth_of(static_cast<int>(i), kSeed);
    const PlacedRecording& outcome = assembled.outcomes[i];
    if (truth.bad >= 0) {
      const BadWay& way = kBadWays[static_cast<std::size_t>(truth.bad)];
      ASSERT_TRUE(outcome.failure) << "recording " << i << ": " << way.name << " was imported";
      EXPECT_NE(outcome.failure->fact().find(way.reason), std::string::npos)
          << "recording " << i << ": " << way.name << ": " << outcome.failure->fact();
      EXPECT_FALSE(outcome.failure->remedy().empty());
      EXPECT_NE(outcome.failure->where().find(items[i].shown), std::string::npos)
          << outcome.failure->where();
      continue;
    }
    ASSERT_FALSE(outcome.failure) << "recording " << i << " (seed " << kSeed
                                  << "): " << outcome.failure->where() << ": "
                                  << outcome.failure->fact();
    const Conditioned& r = results[i].recordings[0];
    const double off_m = (*r.contact_m - truth.position_m).norm();
    worst_contact_m = std::max(worst_contact_m, off_m);
    const Eigen::Index last = r.deflection_m.rows() - 1;
    const double expected_N = hertz_N(
        truth.young_Pa, -r.deflection_m(last, 2) + (r.contact_m->z() - truth.position_m.z()) * -1);
    worst_force = std::max(worst_force, std::abs(-r.force_N(last, 2) - expected_N) /
                                            (5 * r.error_N[last] + 0.003 * expected_N));
  }
  EXPECT_LT(worst_contact_m, 0.2e-3);
  EXPECT_LT(worst_force, 1);  // five deviations and 0.3 %
}

}  // namespace palpate::recordings
