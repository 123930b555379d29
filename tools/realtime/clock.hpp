#pragma once

#include <sched.h>

#include <string>
#include <vector>

namespace palpate::tools {

/// Paces ticks by the machine's monotonic clock and measures them. The calling thread runs under
/// SCHED_FIFO with locked memory for as long as the clock lives, where that is permitted.
class RealtimeClock {
 public:
  /// ticks: the most that are played. Throws Error unless the rate is within 1 Hz to 100 kHz.
  RealtimeClock(double rate_Hz, std::size_t ticks);
  ~RealtimeClock();
  RealtimeClock(const RealtimeClock&) = delete;
  RealtimeClock& operator=(const RealtimeClock&) = delete;

  double period_s() const { return 1e-9 * period_ns_; }
  /// Sleeps until the next tick is due.
  void wait();
  /// Ends the tick.
  void done();

  /// Missed deadlines, refused privileges and histograms of jitter and tick time, for people.
  std::vector<std::string> report() const;
  int ticks() const { return static_cast<int>(tick_ns_.size()); }
  int missed() const { return missed_; }
  const std::vector<double>& jitter_ns() const { return jitter_ns_; }

 private:
  double period_ns_, due_ns_, began_ns_ = 0;
  std::vector<double> jitter_ns_, tick_ns_;  ///< how late each tick began, how long it took
  int missed_ = 0;                           ///< ticks that were not done when the next was due
  std::string remark_;                       ///< privileges that were refused
  bool is_fifo_, is_locked_;
  int policy_ = 0;
  sched_param parameters_{};
};

}  // namespace palpate::tools
