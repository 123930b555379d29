// Ten thousand recordings, killed in the middle. Its own program, labelled slow.

#include <sys/resource.h>

#include <chrono>
#include <cstdio>

#include "tests/libfit/recordings/batches.hpp"

namespace palpate::recordings {
namespace {

TEST_F(BatchTest, ten_thousand_recordings_survive_a_kill_and_none_is_lost) {
  const int count = 10000;
  const auto items = make(count);
  run_and_kill(items, {.jobs = 2, .journal = at("journal")}, count / 2);
  const auto resumed = run_batch(items, {.jobs = 2, .journal = at("journal")}, {});
  const auto begin = std::chrono::steady_clock::now();
  const auto fresh = run_batch(items, {.jobs = 2, .journal = at("journal2")}, {});
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  const auto again_begin = std::chrono::steady_clock::now();
  run_batch(items, {.jobs = 2, .journal = at("journal2")}, {});
  const double again =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - again_begin).count();
  check(items, fresh);
  const std::string bytes = outcome(items, fresh, "fresh");
  EXPECT_EQ(outcome(items, resumed, "resumed"), bytes);
  EXPECT_EQ(outcome(items, run_batch(items, {.jobs = 1, .journal = {}}, {}), "one"), bytes);
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  std::printf(
      "%d recordings: %.1f s on 2 threads, %.0f per second; unchanged again: %.1f s; largest "
      "memory %.0f MB\n",
      count, seconds, count / seconds, again, static_cast<double>(usage.ru_maxrss) / 1024);
}

}  // namespace
}  // namespace palpate::recordings
