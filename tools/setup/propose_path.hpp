#pragma once

#include "libfit/core/geometry.hpp"
#include "libfit/io/csv/tables.hpp"
#include "libfit/runtime/engine.hpp"

namespace palpate::tools {

/// A path of the tip to replay on an asset, and what it does.
struct ProposedPath {
  PosePath tip;                 ///< 1 kHz, in the asset's own coordinates
  Vec3 touched = Vec3::Zero();  ///< where it comes down on the surface [m]
  double depth_m = 0;           ///< below the surface, along the way that it comes down
  double slide_m = 0;           ///< across; 0 where the window is too narrow for a slide
};

/// A path that comes down on the middle of the window (the measured vertex that lies farthest from
/// the window's border along the surface, or the middle of the largest measured triangle), presses
/// to 0.6 of the depth that curves were fitted to, slides at that depth below the surface the way
/// that has most room, four depths at most, and lifts. Every way begins and ends at rest.
/// Deterministic. Throws Error where no triangle of the asset has measured corners alone.
ProposedPath propose_path(const runtime::AssetView& asset);

}  // namespace palpate::tools
