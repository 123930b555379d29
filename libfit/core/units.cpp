#include "libfit/core/units.hpp"

#include <array>
#include <charconv>
#include <cmath>

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

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

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

std::string_view dimension_name(Dimension dimension) {
  switch (dimension) {
    case Dimension::length:
      return "length";
    case Dimension::pressure:
      return "pressure";
    case Dimension::force:
      return "force";
    case Dimension::time:
      return "time";
    case Dimension::angle:
      return "angle";
    case Dimension::torque:
      return "torque";
    case Dimension::speed:
      return "speed";
  }
  return "quantity";
}

std::string known_units(Dimension dimension) {
  std::string names;
  for (const UnitRow& row : kUnits)
    if (row.dimension == dimension) names += (names.empty() ? "" : ", ") + std::string(row.name);
  return names;
}

}  // namespace palpate
