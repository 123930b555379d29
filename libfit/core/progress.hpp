#pragma once

#include <cstddef>
#include <functional>
#include <string>

namespace palpate {

/// Callbacks by which long work reports itself and learns that it must stop. Libraries never print.
/// `step` is called with items done and in all, and a short word on the latest one; it may come
/// from any thread, one at a time. `is_stopped` is polled often (at least once a second) and makes
/// the work return early with what is finished. Both may be empty.
struct Progress {
  std::function<void(std::size_t done, std::size_t total, const std::string& latest)> step;
  std::function<bool()> is_stopped;

  void report(std::size_t done, std::size_t total, const std::string& latest = {}) const {
    if (step) step(done, total, latest);
  }
  bool stopped() const { return is_stopped && is_stopped(); }
};

}  // namespace palpate
