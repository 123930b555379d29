// Batches: nothing bad stops the rest or disappears, and results do not depend on how they were
// made.

#include <atomic>

#include "tests/libfit/recordings/batches.hpp"

namespace palpate::recordings {
namespace {

TEST_F(BatchTest, every_bad_recording_is_named_and_no_good_one_is_lost) {
  const auto items = make(300);
  check(items, run_batch(items, {}, {}));
}

TEST_F(BatchTest, results_do_not_depend_on_the_thread_count) {
  const auto items = make(120);
  EXPECT_EQ(outcome(items, run_batch(items, {.jobs = 1, .journal = {}}, {}), "one"),
            outcome(items, run_batch(items, {.jobs = 4, .journal = {}}, {}), "four"));
}

TEST_F(BatchTest, a_batch_killed_in_the_middle_goes_on_to_the_same_result) {
  const auto items = make(120);
  run_and_kill(items, {.jobs = 2, .journal = at("journal")}, 60);
  const auto resumed = run_batch(items, {.jobs = 2, .journal = at("journal")}, {});
  std::size_t reused = 0;
  for (const ItemResult& result : resumed) reused += result.is_reused;
  EXPECT_GE(reused, 50u);
  EXPECT_LT(reused, items.size());
  EXPECT_EQ(outcome(items, resumed, "resumed"), outcome(items, run_batch(items, {}, {}), "fresh"));
}

TEST_F(BatchTest, a_journal_cut_or_damaged_anywhere_gives_the_same_result) {
  const auto items = make(12);
  const std::string expected =
      outcome(items, run_batch(items, {.jobs = 1, .journal = at("journal")}, {}), "fresh");
  const std::string journal = read_whole_file(at("journal"));
  std::mt19937 random(kSeed);
  for (int trial = 0; trial < 40; ++trial) {
    std::string damaged = journal;
    if (trial % 2)
      damaged.resize(random() % journal.size());
    else
      damaged[random() % journal.size()] ^= static_cast<char>(1 + random() % 255);
    testing_io::write_quickly(at("journal"), damaged);
    ASSERT_EQ(outcome(items, run_batch(items, {.jobs = 1, .journal = at("journal")}, {}), "again"),
              expected)
        << "trial " << trial << " seed " << kSeed;
  }
}

TEST_F(BatchTest, only_changed_recordings_are_read_again) {
  auto items = make(20);
  run_batch(items, {.jobs = 2, .journal = at("journal")}, {});
  const auto reused = [&] {
    std::vector<std::size_t> fresh;
    const auto results = run_batch(items, {.jobs = 2, .journal = at("journal")}, {});
    for (std::size_t i = 0; i < results.size(); ++i)
      if (!results[i].is_reused) fresh.push_back(i);
    return fresh;
  };
  EXPECT_TRUE(reused().empty());
  write_recording(items[3].file, 4, kSeed);
  items[5].signal.rows = 20;
  EXPECT_EQ(reused(), (std::vector<std::size_t>{3, 5}));
}

TEST_F(BatchTest, a_stop_keeps_what_is_done) {
  const auto items = make(40);
  std::atomic<std::size_t> done{0};
  Progress progress;
  progress.step = [&](std::size_t n, std::size_t, const std::string&) { done = n; };
  progress.is_stopped = [&] { return done >= 10; };
  const auto stopped = run_batch(items, {.jobs = 1, .journal = at("journal")}, progress);
  std::size_t finished = 0;
  for (const ItemResult& result : stopped) finished += result.is_done;
  EXPECT_EQ(finished, 10u);
  EXPECT_EQ(outcome(items, run_batch(items, {.jobs = 1, .journal = at("journal")}, {}), "resumed"),
            outcome(items, run_batch(items, {}, {}), "fresh"));
}

}  // namespace
}  // namespace palpate::recordings
