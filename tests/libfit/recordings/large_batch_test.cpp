// Ten thousand recordings. Its own program, labelled slow.

#include <sys/resource.h>

#include <chrono>
#include <cstdio>

#include "tests/libfit/recordings/batches.hpp"

namespace palpate::recordings {
namespace {

TEST_F(BatchTest, of_ten_thousand_recordings_none_is_lost) {
  const int count = 10000;
  const auto items = make(count);
  const auto begin = std::chrono::steady_clock::now();
  const auto results = run_batch(items, {.jobs = 2}, {});
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  check(items, results);
  EXPECT_EQ(outcome(items, run_batch(items, {.jobs = 1}, {}), "one"),
            outcome(items, results, "two"));
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  std::printf("%d recordings: %.1f s on 2 threads, %.0f per second; largest memory %.0f MB\n",
              count, seconds, count / seconds, static_cast<double>(usage.ru_maxrss) / 1024);
}

}  // namespace
}  // namespace palpate::recordings
