#pragma once

#include <cstddef>
#include <functional>
#include <string>

namespace palpate {

/// Callbacks by which long work reports itself and learns that it must stop. Libraries never print.
/// `step` is called with items done and in all, and a short word on the latest one; it may come
/// from any thread, one at a time. `is_stopped` is polled often (at least once a second) and makes
/// the work return early with what is finished. `item` is called by the thread that begins one,
/// with its name, and with an empty name when it ends. All may be empty.
struct Progress {
  std::function<void(std::size_t done, std::size_t total, const std::string& latest)> step;
  std::function<bool()> is_stopped;
  std::function<void(const std::string& name)> item = {};

  void report(std::size_t done, std::size_t total, const std::string& latest = {}) const {
    if (step) step(done, total, latest);
  }
  bool stopped() const { return is_stopped && is_stopped(); }
  void begin(const std::string& name) const {
    if (item) item(name);
  }
  void end() const { begin({}); }
};

}  // namespace palpate
