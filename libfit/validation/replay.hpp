#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <ctime>
#include <functional>
#include <map>
#include <vector>

#include "libfit/core/statistics.hpp"
#include "libfit/experiments/follow.hpp"
#include "libfit/refine/interpolation.hpp"
#include "libfit/validation/statement.hpp"

namespace palpate::validation {

/// Experiments that an asset is compared with, none of which a fit saw.
struct Reference {
  Samples paths;  ///< held-out paths of the asset's own probe, each at a place of its own
  Samples own;    ///< presses and drags at the same places; empty unless wanted
  Samples all;    ///< these and every other kind
};

/// The experiments of one point by curves of its own: the law of section 4 on the local quadric
/// (docs/method.md, M11), as the fit sees it. row: of `curves`. Answers the point's good rows; of a
/// drag or path those before its first row that is not.
void replay_point(const Samples& samples, std::int32_t point, const CurveSet& curves,
                  Eigen::Index row, Replayed& replayed);

/// Time of a tick on this machine over repeated replays of all paths [ns], by tick_ns().
double time_ticks_ns(const runtime::AssetView& asset, const Samples& paths, double depth_m,
                     const PlayedAs& played_as = {});

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

// Recordings against an asset that was made of others: baselines beside it, and places where it
// answers at all.

/// The loading of a press, ever deeper from first touch on: depths [m] and forces along the inward
/// normal [N].
struct PressTable {
  std::vector<double> depth_m{0}, push_N{0};

  /// Straight between rows, and beyond the last as between the last two; of two rows or more.
  double at(double depth_m) const;
};
/// The presses of the good rows of samples, by the points that have any.
std::map<std::int32_t, std::vector<PressTable>> presses_of(const Samples& samples);

/// Answers to the good rows of scans in `asked`: the mean force of the fitted rows that are nearest
/// in place and in velocity times 0.05 s, in which a tool of 2 Hz crosses its stroke.
Replayed neighbouring_rows(const Samples& fitted, const Samples& asked, int neighbours);

/// Answers to the good rows of presses in `asked`: what the presses of the nearest `neighbours`
/// points of `fitted` met at that depth, weighted with distance to the power -2 (Shepard 1968),
/// along the asked normal. Between rows a press is straight, and beyond its last it goes on as
/// between the last two. A point never answers for its own place, so that `asked` may be `fitted`.
/// Other rows are not answered.
Replayed neighbouring_presses(const Samples& fitted, const Samples& asked, int neighbours);

/// The same by what refine() found by leaving points out: rows of those points alone.
Replayed left_out_presses(const FittedCurves& curves, const InterpolationChoice& found,
                          const Samples& asked);

/// Places of samples on the surface of an asset, P each.
struct PlacedPoints {
  Points position;               ///< the nearest place of the surface [m]
  Eigen::VectorXd distance_m;    ///< from the sample's own place
  std::vector<char> is_covered;  ///< whether the asset has curves of its own there
};
PlacedPoints placed_points(const runtime::AssetView& asset, const Samples& samples);

}  // namespace palpate::validation
