#include "libfit/recordings/placing/plausible.hpp"

#include <array>
#include <cmath>
#include <string_view>

#include "libfit/core/units.hpp"

namespace palpate::recordings {
namespace {

constexpr std::array<std::string_view, 6> kForces{"N", "mN", "uN", "nN", "kN", "gf"};
constexpr std::array<std::string_view, 5> kLengths{"mm", "m", "um", "nm", "cm"};
constexpr double kNear = 30;  // bodies differ by this much; prefixes by 1000

}  // namespace

std::optional<LikelyUnit> likely_unit(double found_Pa, double expected_Pa,
                                      const std::string& force_unit, const std::string& length_unit,
                                      bool has_radius) {
  const double force = unit_factor(force_unit, Dimension::force).value_or(1);
  const double length = unit_factor(length_unit, Dimension::length).value_or(1e-3);
  const double power = has_radius ? 1.5 : 2;
  std::optional<LikelyUnit> best;
  double least = std::log10(kNear);
  const auto consider = [&](double modulus_Pa, const std::string& key, std::string_view unit) {
    const double off = std::abs(std::log10(modulus_Pa / expected_Pa));
    if (off < least - 1e-9) {
      least = off;
      best = LikelyUnit{key, std::string(unit)};
    }
  };
  for (const auto unit : kForces)
    if (const double factor = *unit_factor(unit, Dimension::force); factor != force)
      consider(found_Pa * factor / force, "units.force", unit);
  for (const auto unit : kLengths)
    if (const double factor = *unit_factor(unit, Dimension::length); factor != length)
      consider(found_Pa * std::pow(length / factor, power), "units.position", unit);
  return best;
}

}  // namespace palpate::recordings
