#pragma once

#include <optional>
#include <string>

#include "libfit/core/closest_point.hpp"

namespace palpate {

/// Why a surface bounds no volume, as a sentence's end ("3 edges lie on a border"), or nothing when
/// it is closed, 2-manifold, consistently oriented and points outward in all. By surface_facts;
/// self-intersection is not looked for. Safe on anything.
std::optional<std::string> why_not_closed(const Surface& surface);

/// True where triangles of a surface that passed `why_not_closed` meet anywhere but in what they
/// share.
bool is_self_intersecting(const Surface& surface);

/// The triangles that do, with all vertices.
Surface crossing_part(const Surface& surface);

/// Largest distance [m] between two surfaces, both ways, sampled at vertices, edge midpoints and
/// triangle centres of each: a lower bound of their Hausdorff distance, close to it when the
/// sampled features are no larger than the triangles. boxes_of_a: triangle_boxes(a).
double deviation_m(const Surface& a, const BoxTree& boxes_of_a, const Surface& b);

}  // namespace palpate
