#pragma once

#include <optional>
#include <string>

#include "libfit/core/surface.hpp"

namespace palpate {

/// Why a surface bounds no volume, as a sentence's end ("3 edges lie on a border"), or nothing when
/// it is closed, 2-manifold, consistently oriented and points outward in all.
/// Checks, in this order: triangles present, indices in range, finite coordinates, each directed
/// edge once and with its opposite, one fan of triangles per vertex, volume > 0. Not checked:
/// self-intersection (`is_self_intersecting`). Safe on anything.
std::optional<std::string> why_not_closed(const Surface& surface);

}  // namespace palpate
