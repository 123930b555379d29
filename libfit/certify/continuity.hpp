#pragma once

#include <cstdint>
#include <vector>

#include "libfit/runtime/engine.hpp"

namespace palpate::certify {

struct ContinuityOptions {
  double radius_m = 0;
  double step_m = 5e-5;  ///< of a tick: 50 mm/s at 1 kHz
  int walks = 400;
  std::uint64_t seed = 1;
};

/// Largest change of the force in a tick of step_m [N], by what happened at that tick. Sampled, not
/// bounded.
struct Continuity {
  double touch_N = 0, release_N = 0;
  double edge_N = 0;         ///< the contact point went to another triangle
  double knot_N = 0;         ///< the depth went over a knot of the normal curves
  double range_end_N = 0;    ///< or over the end of what was fitted
  double held_N = 0;         ///< the guard bore a share of the force
  double inside_N = 0;       ///< nothing of that
  double stiffness_N_m = 0;  ///< largest of all over step_m: K at a tick's scale
  double force_N = 0;        ///< largest
  double seen_m = 0;  ///< longest step of the tool that the law sees, x - C f of a body that sways
  std::int64_t ticks = 0;  ///< in contact
};

/// Random presses, drags and lifts that begin on the given triangles, within their depths.
/// Deterministic for a seed.
Continuity measure_continuity(const runtime::AssetView& asset, const std::vector<int>& triangles,
                              const ContinuityOptions& options);

}  // namespace palpate::certify
