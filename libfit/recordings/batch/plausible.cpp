#include "libfit/recordings/batch/plausible.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <string_view>

#include "libfit/core/statistics.hpp"
#include "libfit/core/text.hpp"
#include "libfit/core/units.hpp"

namespace palpate::recordings {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kOutlier = 100;          // of the median modulus of a batch: a prefix is 1000
constexpr std::size_t kMinToCompare = 5;  // recordings
constexpr std::array<std::string_view, 6> kForces{"N", "mN", "uN", "nN", "kN", "gf"};
constexpr std::array<std::string_view, 5> kLengths{"mm", "m", "um", "nm", "cm"};
constexpr double kNear = 30;         // bodies differ by this much; prefixes by 1000
constexpr double kTypical_Pa = 1e4;  // a soft tissue, when there is nothing to compare with

std::string in_pascal(double pressure_Pa) { return number(pressure_Pa, 2) + " Pa"; }

// By the way they were made: a batch may hold several rigs.
std::string rig_of(const BatchItem& item) {
  return fmt::format("{}|{}|{}{}", item.read.format, item.signal.radius_m,
                     static_cast<int>(item.signal.kind),
                     item.signal.is_range_given ? "|given" : "|");
}

// A unit of the header is corrected there, or columns are named by number, without the header.
std::string remedy_of(const LikelyUnit& unit, const importers::UnitNames& given,
                      const importers::UnitNames& read) {
  const bool is_force = unit.key == "units.force";
  const std::string& in_file = is_force ? read.force : read.position;
  if (!(is_force ? given.force : given.position).empty() || in_file.empty())
    return unit.key + " should probably be \"" + unit.unit + "\". ";
  return fmt::format(
      "The file says {}, and it should probably be \"{}\": correct the header, or "
      "name `columns` by number and say {}. ",
      in_file, unit.unit, unit.key);
}

// median_Pa: of the recordings that were made like this one; NaN where it is not compared.
std::optional<Failure> question(const BatchItem& item, const Conditioned& recording,
                                double median_Pa) {
  const SignalSettings& s = item.signal;
  const importers::UnitNames& units = item.read.units;
  const double found_Pa = recording.apparent_Pa;
  const bool is_alone =
      std::isfinite(median_Pa) && std::abs(std::log10(found_Pa / median_Pa)) > std::log10(kOutlier);
  const bool is_implausible = !(found_Pa >= s.min_young_Pa && found_Pa <= s.max_young_Pa);
  if (!is_alone && !is_implausible) return std::nullopt;
  const double expected_Pa =
      std::isfinite(median_Pa) && median_Pa >= s.min_young_Pa && median_Pa <= s.max_young_Pa
          ? median_Pa
          : kTypical_Pa;
  const importers::UnitNames& read = recording.source.units;
  const auto unit =
      likely_unit(found_Pa, expected_Pa, units.force.empty() ? read.force : units.force,
                  units.position.empty() ? read.position : units.position, s.radius_m > 0);
  const std::string against = is_implausible
                                  ? ", which no soft body is made of"
                                  : ", where the other recordings have " + in_pascal(median_Pa);
  return Failure{item.file.string() + (recording.name.empty() ? "" : "#" + recording.name),
                 "its stiffness is that of a body of " + in_pascal(found_Pa) + against +
                     (unit ? ": is a unit wrong?" : ""),
                 (unit ? remedy_of(*unit, units, read) : std::string("Check the units. ")) +
                     "If it is right, widen `plausible` in the manifest."};
}

// Whether one content gives both the same result.
bool is_read_alike(const BatchItem& a, const BatchItem& b) {
  return a.read == b.read && a.signal == b.signal && a.normal == b.normal;
}

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

std::vector<std::vector<std::optional<Failure>>> question_stiffness(
    const std::vector<BatchItem>& items, const std::vector<ItemResult>& results) {
  std::map<std::string, std::vector<double>> moduli;
  for (std::size_t i = 0; i < results.size(); ++i)
    for (const Conditioned& recording : results[i].recordings)
      if (std::isfinite(recording.apparent_Pa))
        moduli[rig_of(items[i])].push_back(recording.apparent_Pa);
  std::map<std::string, double> median_Pa;
  for (const auto& [rig, of_rig] : moduli)
    median_Pa[rig] = of_rig.size() >= kMinToCompare ? upper_median(of_rig) : kNan;
  std::vector<std::vector<std::optional<Failure>>> failures(results.size());
  for (std::size_t i = 0; i < results.size(); ++i) {
    const auto of_rig = median_Pa.find(rig_of(items[i]));
    const bool is_compared = of_rig != median_Pa.end() && !items[i].signal.is_range_given;
    for (const Conditioned& recording : results[i].recordings)
      failures[i].push_back(question(items[i], recording, is_compared ? of_rig->second : kNan));
  }
  return failures;
}

std::vector<std::string> copy_notes(const std::vector<BatchItem>& items,
                                    const std::vector<ItemResult>& results) {
  std::vector<std::string> notes;
  std::multimap<std::string, std::size_t> first;  // of the items that are read alike, by content
  for (std::size_t i = 0; i < results.size(); ++i) {
    if (results[i].recordings.empty() || results[i].hash.empty()) continue;
    const auto [begin, end] = first.equal_range(results[i].hash);
    const auto at = std::find_if(begin, end, [&](const auto& other) {
      return is_read_alike(items[other.second], items[i]);
    });
    if (at == end) {
      first.emplace(results[i].hash, i);
      continue;
    }
    const BatchItem& one = items[at->second];
    notes.push_back(
        items[i].shown +
        (items[i].file == one.file ? " is named again" : " holds the bytes of " + one.shown) +
        (point_of(items[i], "") == point_of(one, "")
             ? ": its readings count twice"
             : ": points " + point_of(one, "") + " and " + point_of(items[i], "") +
                   " are one recording"));
  }
  return notes;
}

}  // namespace palpate::recordings
