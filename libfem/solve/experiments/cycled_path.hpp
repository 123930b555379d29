#pragma once

#include "libfit/core/samples.hpp"

namespace palpate::fem {

/// A straight press in cycles, from first touch along the inward normal: to half the depth, nearly
/// out, in to all of it, nearly out and in again.
ToolPath cycled_press(int point, const Vec3& inward, double depth_m);

/// The path after a straight press to preload_m and out again.
ToolPath after_press(const ToolPath& path, const Vec3& inward, double preload_m);

}  // namespace palpate::fem
