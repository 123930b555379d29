#pragma once

#include <optional>
#include <string>

#include "libfit/recordings/signal/settings.hpp"

namespace palpate::recordings {

/// A unit that would bring an implausible modulus to where it belongs.
struct LikelyUnit {
  std::string key;   ///< "units.force", "units.position"
  std::string unit;  ///< what the manifest should probably say
};

/// The unit of force or length that brings `found_Pa` nearest to `expected_Pa`, of those that bring
/// it within a factor of 30; nothing when none does. factor steps are those of SI prefixes. given:
/// the manifest's units, "N" and "mm" where empty.
std::optional<LikelyUnit> likely_unit(double found_Pa, double expected_Pa,
                                      const std::string& force_unit, const std::string& length_unit,
                                      bool has_radius);

}  // namespace palpate::recordings
