#pragma once

#include <optional>
#include <string>
#include <vector>

#include "libfit/recordings/batch/batch.hpp"

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

/// Why recordings are refused whose apparent modulus no body has (outside their `plausible`), or is
/// a prefix away from that of the others that were made like them. By item and recording of
/// `results`; nothing where a recording is plausible.
std::vector<std::vector<std::optional<Failure>>> question_stiffness(
    const std::vector<BatchItem>& items, const std::vector<ItemResult>& results);

/// A sentence on every item whose file holds the bytes of an earlier one and is read as that is:
/// repeats that are none make errors too small, and points that were never pressed.
std::vector<std::string> copy_notes(const std::vector<BatchItem>& items,
                                    const std::vector<ItemResult>& results);

}  // namespace palpate::recordings
