#pragma once

#include <optional>
#include <string>

#include "libfit/core/surface.hpp"

namespace palpate {

/// Why a surface bounds no volume, as a sentence's end ("3 edges lie on a border"), or nothing when
/// it is closed, 2-manifold, consistently oriented and points outward in all. By surface_facts;
/// self-intersection is not looked for. Safe on anything.
std::optional<std::string> why_not_closed(const Surface& surface);

/// Whether triangles of a surface that passed `why_not_closed` meet anywhere but in what they
/// share.
bool is_self_intersecting(const Surface& surface);

}  // namespace palpate
