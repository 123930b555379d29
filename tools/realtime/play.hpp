#pragma once

#include <string>
#include <vector>

#include "libfit/core/geometry.hpp"
#include "libfit/runtime/engine.hpp"

namespace palpate::tools {

/// Result of a real-time replay.
struct RealtimeReport {
  bool is_fifo = false;           ///< the force thread ran under SCHED_FIFO
  bool is_locked = false;         ///< memory was locked, so no page fault could delay a tick
  std::string remark;             ///< why not, for people; empty when both
  std::size_t ticks = 0;          ///< played; fewer than the path's when interrupted
  std::size_t missed = 0;         ///< ticks that were not done when the next was due
  std::size_t touches = 0;        ///< contacts that the search thread found
  int worst_touch_delay = 0;      ///< ticks between a touch and its force
  std::vector<double> jitter_ns;  ///< how late each tick began
  std::vector<double> tick_ns;    ///< how long each took
};

/// Output of one tick.
struct PlayedTick {
  runtime::Status status = runtime::Status::ok;
  runtime::Output out;
};

/// Plays one tip per tick at rate_Hz on the machine's monotonic clock, in the paper's arrangement
/// of two threads: the force thread computes the contact at every tick; while the tip is in the air
/// it hands its ways to a search thread, which sweeps them and hands back the first touch. So a
/// contact begins at the same point as in a plain replay, but its force comes one tick late or more
/// (worst_touch_delay); until then it is zero. All else is the same engine on the same tips.
/// tip_m: # x 3 [m]. Fills played, # ticks. Stops early when is_interrupted() says so.
/// Throws Error when the rate is not within 1 Hz to 100 kHz or no thread can be made.
RealtimeReport play_in_real_time(const runtime::AssetView& asset, const Points& tip_m,
                                 double rate_Hz, std::vector<PlayedTick>& played,
                                 bool (*is_interrupted)());

/// "median 2.1 us, p99 8.0, worst 31" and bars by powers of two, for people.
std::string histogram(const std::string& what, std::vector<double> ns);

}  // namespace palpate::tools
