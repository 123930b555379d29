#pragma once

#include "libfit/core/samples.hpp"

namespace palpate::fem {

/// Rows of a hold, the last at its end, evenly in the logarithm of time over two decades.
inline constexpr int kHoldRows = 5;

/// The path at a constant speed from first touch, with the time of each row, and a hold of hold_s
/// at its end; 0: none. Rows that stand still where they were are left out: a row takes time.
ToolPath in_time(const ToolPath& path, double speed_m_s, double hold_s);

}  // namespace palpate::fem
