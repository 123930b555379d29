// Batches: nothing bad stops the rest or disappears, and results do not depend on how they were
// made.

#include <atomic>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <functional>
#include <thread>

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

// A ruled strip through the places of the recordings, and off_m(number) off them.
Surface strip_through(int count, const std::function<double(int)>& off_m) {
  Surface strip{Points(2 * count, 3), Triangles(2 * (count - 1), 3)};
  for (int i = 0; i < count; ++i) {
    const Vec3 place = truth_of(i, kSeed).position_m + Vec3(0, 0, off_m(i));
    strip.vertices.row(2 * i) = place - Vec3(0, 0.02, 0);
    strip.vertices.row(2 * i + 1) = place + Vec3(0, 0.02, 0);
    if (i == 0) continue;
    strip.triangles.row(2 * i - 2) << 2 * i - 2, 2 * i, 2 * i + 1;
    strip.triangles.row(2 * i - 1) << 2 * i - 2, 2 * i + 1, 2 * i - 1;
  }
  return strip;
}

TEST_F(BatchTest, a_contact_less_sure_than_the_surface_is_weighed_with_it) {
  constexpr int kCount = 30;
  const double noise_N = 0.06;
  std::vector<BatchItem> items;
  for (int i = 0; i < kCount; ++i) {
    if (truth_of(i, kSeed).bad >= 0) continue;
    items.push_back(item_of(folder_, i, kSeed));
    write_recording(items.back().file, i, kSeed, noise_N);
  }
  struct Found {
    double rms_mm = 0;
    int within_two_deviations = 0, weighed = 0, all = 0;
  };
  const auto found = [&](const Surface* surface) {
    Found out;
    BatchOptions options;
    options.surface = surface;
    const auto results = run_batch(items, options, {});
    for (std::size_t k = 0; k < items.size(); ++k)
      for (const Conditioned& r : results[k].recordings) {
        const double off_m = r.contact.travel_m + items[k].position_m->z();  // travel is -z
        out.rms_mm += 1e6 * off_m * off_m;
        out.within_two_deviations += std::abs(off_m) <= 2 * r.contact.deviation_m;
        out.weighed += r.contact.estimator.ends_with(", surface");
        ++out.all;
      }
    out.rms_mm = std::sqrt(out.rms_mm / out.all);
    std::printf("contacts %.3f mm rms off, %d of %d within two deviations, %d weighed\n",
                out.rms_mm, out.within_two_deviations, out.all, out.weighed);
    return out;
  };
  const Found alone = found(nullptr);
  std::mt19937 random(kSeed);
  std::normal_distribution<double> normal(0, 1);
  const auto strip = [&](double deviation_m) {
    return strip_through(kCount, [&](int) { return deviation_m * normal(random); });
  };
  const Surface fine = strip(0.05e-3), rough = strip(3e-3);
  const Found with_fine = found(&fine), with_rough = found(&rough);
  EXPECT_LT(with_fine.rms_mm, 0.5 * alone.rms_mm);
  EXPECT_GE(with_fine.within_two_deviations, 0.9 * with_fine.all);
  EXPECT_EQ(with_rough.weighed, 0);
  EXPECT_EQ(with_rough.rms_mm, alone.rms_mm);
}

// Bytes that this process has read so far.
std::size_t bytes_read() {
  std::ifstream io("/proc/self/io");
  std::string name;
  std::size_t value = 0;
  while (io >> name >> value)
    if (name == "rchar:") return value;
  return 0;
}

TEST_F(BatchTest, what_another_program_kept_is_not_taken) {
  const auto items = make(12);
  const auto reused_by = [&](const char* program) {
    std::size_t reused = 0;
    for (const ItemResult& result :
         run_batch(items, {.jobs = 1, .journal = at("journal"), .program = program}, {}))
      reused += result.is_reused;
    return reused;
  };
  EXPECT_EQ(reused_by("1.0"), 0u);
  EXPECT_GT(reused_by("1.0"), 6u);
  EXPECT_EQ(reused_by("1.1"), 0u);
}

TEST_F(BatchTest, files_that_nobody_touched_are_not_opened_and_any_touch_is_noticed) {
  if (bytes_read() == 0) GTEST_SKIP() << "no /proc/self/io";
  const auto items = make(30);
  std::size_t size = 0;
  for (const BatchItem& item : items)
    if (std::error_code none; std::filesystem::exists(item.file, none))
      size += std::filesystem::file_size(item.file);
  std::this_thread::sleep_for(std::chrono::milliseconds(3100));  // else they may change unseen
  const BatchOptions options{.jobs = 1, .journal = at("journal")};
  run_batch(items, options, {});
  const std::size_t before = bytes_read();
  for (const ItemResult& result : run_batch(items, options, {}))
    EXPECT_TRUE(result.is_reused || !result.failure->what.find("no such file"));
  const std::size_t journal = std::filesystem::file_size(at("journal"));
  EXPECT_LT(bytes_read() - before, journal + size / 10);

  // The same size and date as before, other content.
  const auto date = std::filesystem::last_write_time(items[3].file);
  std::string bytes = read_whole_file(items[3].file);
  bytes[bytes.size() / 2] = bytes[bytes.size() / 2] == '1' ? '2' : '1';
  testing_io::write_quickly(items[3].file, bytes);
  std::filesystem::last_write_time(items[3].file, date);
  const auto results = run_batch(items, options, {});
  EXPECT_FALSE(results[3].is_reused);
  EXPECT_TRUE(results[4].is_reused);
}

TEST_F(BatchTest, a_journal_forgets_what_is_not_asked_for_any_more) {
  auto items = make(20);
  const BatchOptions options{.jobs = 2, .journal = at("journal")};
  std::uintmax_t largest = 0;
  for (int rows = 40; rows > 30; --rows) {
    for (BatchItem& item : items) item.signal.rows = rows;
    run_batch(items, options, {});
    largest = std::max(largest, std::filesystem::file_size(at("journal")));
  }
  run_batch({items[0]}, options, {});
  EXPECT_LT(std::filesystem::file_size(at("journal")), largest / 4);
  for (BatchItem& item : items) item.signal.rows = 40;
  run_batch(items, options, {});
  EXPECT_LT(largest, 3 * std::filesystem::file_size(at("journal")));
  EXPECT_EQ(outcome(items, run_batch(items, options, {}), "kept"),
            outcome(items, run_batch(items, {}, {}), "fresh"));
}

}  // namespace
}  // namespace palpate::recordings
