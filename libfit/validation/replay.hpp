#pragma once

#include <functional>
#include <vector>

#include "libfit/core/curves.hpp"
#include "libfit/core/samples.hpp"
#include "libfit/experiments/follow.hpp"
#include "libfit/validation/statement.hpp"

namespace palpate::validation {

/// Experiments that an asset is compared with, none of which a fit saw.
struct Reference {
  Samples paths;  ///< held-out paths of the asset's own probe, each at a place of its own
  Samples own;    ///< presses and drags at the same places; empty unless wanted
  Samples all;    ///< these and every other kind
};

/// The experiments of one point with given curves: the law of section 4 on the local quadric
/// (docs/method.md, M11), as the fit sees it. row: of `curves`. Answers the point's good rows; of a
/// drag or path those before its first row that is not.
void replay_point(const Samples& samples, std::int32_t point, const CurveSet& curves,
                  Eigen::Index row, Replayed& replayed);

/// Time of a tick on this machine over repeated replays of all paths [ns] (tick_time.hpp).
double time_ticks_ns(const runtime::AssetView& asset, const Samples& paths, double depth_m,
                     const PlayedAs& played_as = {});

}  // namespace palpate::validation
