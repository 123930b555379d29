#include "libfit/core/units.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "libfit/core/closest_point.hpp"
#include "libfit/core/error.hpp"
#include "libfit/core/text.hpp"

namespace palpate {
namespace {

struct UnitRow {
  std::string_view name;
  Dimension dimension;
  double factor;
};

constexpr std::array<UnitRow, 38> kUnits{{
    {"m", Dimension::length, 1},
    {"dm", Dimension::length, 1e-1},
    {"cm", Dimension::length, 1e-2},
    {"mm", Dimension::length, 1e-3},
    {"um", Dimension::length, 1e-6},
    {"nm", Dimension::length, 1e-9},
    {"in", Dimension::length, 0.0254},
    {"Pa", Dimension::pressure, 1},
    {"kPa", Dimension::pressure, 1e3},
    {"MPa", Dimension::pressure, 1e6},
    {"GPa", Dimension::pressure, 1e9},
    {"N/mm2", Dimension::pressure, 1e6},
    {"N", Dimension::force, 1},
    {"kN", Dimension::force, 1e3},
    {"mN", Dimension::force, 1e-3},
    {"uN", Dimension::force, 1e-6},
    {"nN", Dimension::force, 1e-9},
    {"pN", Dimension::force, 1e-12},
    {"gf", Dimension::force, 9.80665e-3},
    {"g", Dimension::force, 9.80665e-3},  // what a balance under the body shows
    {"kgf", Dimension::force, 9.80665},
    {"kg", Dimension::force, 9.80665},
    {"s", Dimension::time, 1},
    {"ms", Dimension::time, 1e-3},
    {"us", Dimension::time, 1e-6},
    {"ns", Dimension::time, 1e-9},
    {"min", Dimension::time, 60},
    {"Nm", Dimension::torque, 1},
    {"N m", Dimension::torque, 1},
    {"N*m", Dimension::torque, 1},
    {"Nmm", Dimension::torque, 1e-3},
    {"mNm", Dimension::torque, 1e-3},
    {"m/s", Dimension::speed, 1},
    {"cm/s", Dimension::speed, 1e-2},
    {"mm/s", Dimension::speed, 1e-3},
    {"um/s", Dimension::speed, 1e-6},
    {"rad", Dimension::angle, 1},
    {"deg", Dimension::angle, 0.017453292519943295},
}};

constexpr double kFarTooLong = 10;  // in bodies

}  // namespace

std::optional<double> unit_factor(std::string_view name, Dimension dimension) {
  for (const UnitRow& row : kUnits)
    if (row.dimension == dimension && row.name == name) return row.factor;
  return std::nullopt;
}

std::optional<double> parse_quantity(std::string_view text, Dimension dimension) {
  text = trimmed(text);
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  double number = 0;
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (failure != std::errc() || !std::isfinite(number)) return std::nullopt;
  const auto rest = static_cast<std::size_t>(end - text.data());
  const auto factor = unit_factor(trimmed(text.substr(rest)), dimension);
  if (!factor) return std::nullopt;
  return number * *factor;
}

double mesh_unit_m(const std::string& unit, const std::string& where) {
  const auto named = unit_factor(unit, Dimension::length);
  const auto metres = named ? named : parse_quantity(unit, Dimension::length);
  if (!metres || !(*metres > 0))
    throw Error(where, "\"" + unit + "\" is no length",
                "Use one of " + known_units(Dimension::length) +
                    ", or a length such as \"110 mm\" for one unit of the mesh.");
  return *metres;
}

std::string_view dimension_name(Dimension dimension) {
  constexpr std::string_view kNames[]{"length", "pressure", "force", "time",
                                      "angle",  "torque",   "speed"};
  return kNames[static_cast<int>(dimension)];
}

std::string known_units(Dimension dimension) {
  std::string names;
  for (const UnitRow& row : kUnits)
    if (row.dimension == dimension) names += (names.empty() ? "" : ", ") + std::string(row.name);
  return names;
}

std::optional<std::string_view> misread_unit(const Points& places_m, const Surface& body) {
  if (places_m.rows() == 0 || body.triangles.rows() == 0) return std::nullopt;
  const double size_m = extent_m(body.vertices).norm();
  const Eigen::Array3d low = body.vertices.colwise().minCoeff(),
                       high = body.vertices.colwise().maxCoeff();
  const auto is_within = [&](double sizes, const Vec3& place) {
    return (place.array() >= low - sizes * size_m).all() &&
           (place.array() <= high + sizes * size_m).all();
  };
  for (const auto& place : places_m.rowwise())
    if (is_within(kFarTooLong, place)) return std::nullopt;
  const BoxTree boxes = triangle_boxes(body);
  std::optional<std::string_view> unit;
  double best = kInfinity;
  // About 500 places of a path are looked at.
  const Eigen::Index stride = std::max<Eigen::Index>(1, places_m.rows() / 500);
  for (const std::string_view name : {"mm", "cm", "um"})
    for (Eigen::Index i = 0; i < places_m.rows(); i += stride) {
      const Vec3 place = *unit_factor(name, Dimension::length) * places_m.row(i);
      if (!is_within(1, place)) continue;
      const double off = closest_point(body, boxes, place)->distance_m / place.norm();
      if (off < best) best = off, unit = name;
    }
  return unit;
}

std::optional<std::string_view> misread_unit(double length_m, const Vec3& extent_m) {
  if (length_m < kFarTooLong * extent_m.maxCoeff()) return std::nullopt;
  for (const std::string_view name : {"mm", "um"})
    if (length_m * *unit_factor(name, Dimension::length) <= extent_m.maxCoeff()) return name;
  return std::nullopt;
}

}  // namespace palpate
