#pragma once

#include "libfit/core/geometry.hpp"

namespace palpate {

/// A point strictly inside each cavity of a closed surface: one per connected piece that points
/// inward by itself (negative volume). # x 3 [m].
Points cavity_points(const Surface& closed);

}  // namespace palpate
