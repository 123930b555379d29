#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <ctime>
#include <vector>

#include "libfit/core/statistics.hpp"

namespace palpate::validation {

/// Time that the processor spent on this thread.
struct ProcessorClock {
  using duration = std::chrono::nanoseconds;
  using time_point = std::chrono::time_point<ProcessorClock, duration>;
  static time_point now() {
    timespec time;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return time_point(std::chrono::seconds(time.tv_sec) + duration(time.tv_nsec));
  }
};

/// Time of a tick on this machine [ns]: the lower quartile over batches of equal work, so that what
/// else the machine does in the meantime hardly counts. pass: does a batch, returns its ticks.
template <class Clock = ProcessorClock, class Pass>
double tick_ns(const Pass& pass) {
  constexpr std::size_t kMinTicks = 200000, kMinBatches = 8;
  std::vector<double> batch_ns;
  for (std::size_t ticks = 0; ticks < kMinTicks || batch_ns.size() < kMinBatches;) {
    const auto started = Clock::now();
    const std::size_t done = pass();
    if (done == 0) return 0;
    const std::chrono::duration<double, std::nano> spent = Clock::now() - started;
    batch_ns.push_back(spent.count() / static_cast<double>(done));
    ticks += done;
  }
  return quantile(std::move(batch_ns), 0.25);
}

}  // namespace palpate::validation
