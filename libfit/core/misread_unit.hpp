#pragma once

#include <optional>
#include <string_view>

#include "libfit/core/geometry.hpp"

namespace palpate {

/// The unit that places were likely meant in, "mm", "cm" or "um": the one in which they lie at the
/// body's surface best, by their distance from it over that from the origin. Nothing where a place
/// is no farther from its bounding box as it is than ten times that is long, or in none of these
/// units one is within one length of it. places_m: # x 3, read as metres.
std::optional<std::string_view> misread_unit(const Points& places_m, const Surface& body);

/// The same of a length, "mm" or "um": of one that is ten times the body or more, and in that unit
/// no longer than it.
std::optional<std::string_view> misread_unit(double length_m, const Vec3& extent_m);

}  // namespace palpate
