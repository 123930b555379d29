#pragma once

#include <cstdint>
#include <vector>

#include "libfem/solve/simulate.hpp"
#include "libfit/core/body.hpp"
#include "libfit/runtime/view.hpp"

namespace palpate::tools {

/// Experiments that no fit saw, for validation.
struct HeldOut {
  TestPoints points;  ///< contact points on the asset's facets, engine's inward normals
  std::vector<fem::ProbePath> paths;  ///< one per point
};

struct HeldOutRange {
  double depth_m = 0;          ///< deepest press; paths reach 0.5 to 0.95 of it
  double drag_distance_m = 0;  ///< longest drag; drags reach 0.5 to 1 of it
};

/// Contact points uniform by area over triangles whose three vertices are covered, each with one
/// path: straight press, oblique press (20 to 45 degrees off the normal) or press and drag in turn,
/// in a random tangential direction. Seeded: the same asset and seed give the same experiments.
/// Throws Error when no triangle is covered.
HeldOut draw_held_out(const runtime::AssetView& asset, const HeldOutRange& range, int points,
                      std::uint64_t seed);

}  // namespace palpate::tools
