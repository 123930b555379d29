#pragma once

#include <vector>

#include "libfit/runtime/engine.hpp"
#include "libfit/validation/paths.hpp"

namespace palpate::validation {

/// What an engine answered along a path, a row per deflection.
struct Followed {
  Points force;                  ///< ON THE BODY [N]
  std::vector<char> is_sliding;  ///< the last tick of the row slipped
};

/// Every held-out path with the engine: the tip comes from a tenth of the depth outside and moves
/// 20 um a tick (20 mm/s at 1 kHz). A status but ok answers with zero force.
std::vector<Followed> follow_paths(const runtime::AssetView& asset, const HeldOut& held_out,
                                   double depth_m);

/// Mean wall time of a tick over repeated replays of all paths [ns].
double time_ticks_ns(const runtime::AssetView& asset, const HeldOut& held_out, double depth_m);

}  // namespace palpate::validation
