#pragma once

#include "libfit/core/samples.hpp"

namespace palpate::fem {

/// A straight press in cycles, from first touch along the inward normal: to half the depth, nearly
/// out, in to all of it, nearly out and in again.
ToolPath cycled_press(int point, const Vec3& inward, double depth_m);

/// The path after a straight press to preload_m and out again.
ToolPath after_press(const ToolPath& path, const Vec3& inward, double preload_m);

/// Rows of a hold, the last at its end, evenly in the logarithm of time over two decades.
inline constexpr int kHoldRows = 5;

/// The path at a constant speed from first touch, with the time of each row, and a hold of hold_s
/// at its end; 0: none. Rows that stand still where they were are left out: a row takes time.
ToolPath in_time(const ToolPath& path, double speed_m_s, double hold_s);

}  // namespace palpate::fem
