#pragma once

#include <cstdint>
#include <vector>

#include "libfit/assets/asset_surface.hpp"
#include "libfit/runtime/asset/format.hpp"

namespace palpate {

inline constexpr int kCheckPathTicks = 64;  ///< one place's approach, press, drag and lift

/// Tips of a path that presses, drags and lifts at places drawn by `seed` among vertices of solid
/// triangles; forces are left zero for the engine to fill. depth_m: how deep it presses.
std::vector<runtime::CheckTick> make_check_path(const AssetSurface& surface, double depth_m,
                                                std::uint64_t seed);

}  // namespace palpate
