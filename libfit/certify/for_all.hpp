#pragma once

#include <algorithm>
#include <atomic>
#include <mutex>
#include <thread>
#include <vector>

#include "libfit/core/progress.hpp"

namespace palpate::certify {

/// act(i) for all i below count, on several threads.
template <class Act>
void for_all(int count, int threads, const Progress& progress, const Act& act) {
  constexpr int kChunk = 16;  // that a thread takes at a time
  std::atomic<int> next{0}, done{0};
  std::mutex speaking;
  const auto work = [&] {
    for (int from; (from = next.fetch_add(kChunk)) < count && !progress.stopped();) {
      const int to = std::min(from + kChunk, count);
      for (int i = from; i < to; ++i) act(i);
      const int sum = done += to - from;
      const std::lock_guard<std::mutex> lock(speaking);
      progress.report(static_cast<std::size_t>(sum), static_cast<std::size_t>(count));
    }
  };
  std::vector<std::thread> others;
  for (int i = 1; i < threads; ++i) others.emplace_back(work);
  work();
  for (std::thread& thread : others) thread.join();
}

}  // namespace palpate::certify
