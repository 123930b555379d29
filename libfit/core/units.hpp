#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "libfit/core/geometry.hpp"

namespace palpate {

/// Dimension of a quantity; inside the program everything is in the SI unit beside it.
enum class Dimension {
  length,    ///< m
  pressure,  ///< Pa
  force,     ///< N
  time,      ///< s
  angle,     ///< rad
  torque,    ///< N m
  speed,     ///< m/s
};

inline constexpr double to_millimetres(double x_m) { return x_m * 1e3; }

/// SI value of one unit ("mm" of a length is 1e-3); nothing when the name is not a unit of it.
std::optional<double> unit_factor(std::string_view name, Dimension dimension);

/// SI value of a number with its unit, such as "12 mm" or "5e3 Pa"; nothing when it is not a finite
/// number followed by a unit of the dimension. A bare number is refused: the caller decides
/// whether plain SI numbers are welcome.
std::optional<double> parse_quantity(std::string_view text, Dimension dimension);

/// Metres of one unit of a mesh: the name of a unit of length, or a length such as "110 mm". Error
/// of `where` for anything else.
double mesh_unit_m(const std::string& unit, const std::string& where);

/// "length", "pressure", ...
std::string_view dimension_name(Dimension dimension);

/// Names of the dimension's units for an error's remedy: "m, cm, mm, um, nm".
std::string known_units(Dimension dimension);

/// The unit that places were likely meant in, "mm", "cm" or "um": the one in which they lie at the
/// body's surface best, by their distance from it over that from the origin. Nothing where a place
/// is no farther from its bounding box as it is than ten times that is long, or in none of these
/// units one is within one length of it. places_m: # x 3, read as metres.
std::optional<std::string_view> misread_unit(const Points& places_m, const Surface& body);

/// The same of a length, "mm" or "um": of one that is ten times the body or more, and in that unit
/// no longer than it.
std::optional<std::string_view> misread_unit(double length_m, const Vec3& extent_m);

}  // namespace palpate
