#pragma once

// Times of single ticks, for `palpate_bench tick`.

#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <vector>

#include "libfit/core/statistics.hpp"
#include "tools/workshop/bench/tick_work.hpp"

namespace palpate::tools {

struct TickSpread {
  double median_ns = 0, p99_ns = 0, p999_ns = 0, worst_ns = 0;
};

inline TickSpread spread_of(const std::vector<double>& ns) {
  return {quantile(ns, 0.5), quantile(ns, 0.99), quantile(ns, 0.999), quantile(ns, 1)};
}

inline double now_ns() {
  return static_cast<double>(std::chrono::duration_cast<std::chrono::nanoseconds>(
                                 std::chrono::steady_clock::now().time_since_epoch())
                                 .count());
}

/// What two looks at the clock take; taken off every measured tick.
inline double clock_ns() {
  std::vector<double> ns;
  for (int i = 0; i < 10000; ++i) {
    const double started = now_ns();
    ns.push_back(now_ns() - started);
  }
  return spread_of(std::move(ns)).median_ns;
}

/// Says whether the system took the processor away since the last question: a tick that it
/// interrupts has not used the time that passed.
class SwitchWatch {
 public:
  bool was_switched() {
    rusage now;
    getrusage(RUSAGE_THREAD, &now);
    const long before = switches_;
    switches_ = now.ru_nivcsw + now.ru_nvcsw;
    return switches_ != before;
  }

 private:
  long switches_ = -1;
};

/// Writes over a block larger than the caches of a core, so that the next tick finds nothing there.
class CacheFlush {
 public:
  void operator()() {
    for (std::size_t i = 0; i < block_.size(); i += 64)
      block_[i] = static_cast<unsigned char>(++round_);
  }

 private:
  std::vector<unsigned char> block_ = std::vector<unsigned char>(std::size_t{32} << 20);
  unsigned round_ = 0;
};

/// Times tick(tip) one by one along a kind's way, as a force thread would call it; `flush` (or
/// null) goes before each. Ticks while the system took the processor away are left out, with the
/// hundred around them where caches stay warm.
template <class Tick>
std::vector<double> time_ticks(const TickKind& kind, std::size_t ticks, CacheFlush* flush,
                               double overhead_ns, Tick tick) {
  constexpr long kFirst = 300;  // begins in contact, as a warm loop does
  for (long i = 0; i < kFirst; ++i) tick(kind.tip(i));
  std::vector<double> ns;
  ns.reserve(ticks);
  const std::size_t batch = flush != nullptr ? 1 : 100;
  SwitchWatch watch;
  for (std::size_t i = 0; i < ticks; ++i) {
    const Vec3 tip = kind.tip(kFirst + static_cast<long>(i));
    if (flush != nullptr) (*flush)();
    if (i % batch == 0) watch.was_switched();
    const double started = now_ns();
    tick(tip);
    ns.push_back(std::max(0.0, now_ns() - started - overhead_ns));
    if ((i + 1) % batch == 0 && watch.was_switched()) ns.resize(ns.size() - batch);
  }
  return ns;
}

}  // namespace palpate::tools
