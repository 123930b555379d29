#include "libfit/recordings/placing/place.hpp"

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

void refuse(Candidate& candidate, const std::vector<BatchItem>& items, const std::string& what,
            const std::string& remedy) {
  const BatchItem& item = items[candidate.item];
  candidate.failure =
      Failure{item.file.string() +
                  (candidate.recording->name.empty() ? "" : "#" + candidate.recording->name),
              what, remedy};
}

// Contact points that the rig itself measured, in its frame.
Points measured_contacts(const std::vector<Candidate>& candidates) {
  std::vector<Vec3> points;
  for (const Candidate& c : candidates)
    if (!c.failure && c.recording->contact_m && !c.recording->is_axial)
      points.push_back(*c.recording->contact_m);
  Points out(static_cast<Eigen::Index>(points.size()), 3);
  for (std::size_t i = 0; i < points.size(); ++i) out.row(static_cast<Eigen::Index>(i)) = points[i];
  return out;
}

// Position before projection: the manifest's, which is the body's, else where the rig touched.
bool find_position(const BatchItem& item, const RigidMotion& motion, const AssembleOptions& options,
                   const std::vector<BatchItem>& items, Candidate& c) {
  const auto& contact = c.recording->contact_m;
  if (!item.position_m && !contact) {
    refuse(c, items, "has no position",
           "Say `position` in the manifest: where on the body it was recorded.");
    return false;
  }
  c.position_m = item.position_m ? *item.position_m : motion(*contact);
  if (item.position_m && contact && !c.recording->is_axial) {
    const double off_m = (motion(*contact) - *item.position_m).norm();
    if (off_m > options.place_tolerance_m) {
      refuse(c, items,
             "touches " + millimetres(off_m) +
                 " from the position that the manifest names: it is a recording of another point",
             "Correct `position`, or raise place_tolerance (" +
                 millimetres(options.place_tolerance_m) + ").");
      return false;
    }
  }
  return true;
}

}  // namespace

std::string shown(const std::vector<BatchItem>& items, const Candidate& c) {
  return items[c.item].shown + (c.recording->name.empty() ? "" : "#" + c.recording->name);
}

std::optional<Registration> place_on_body(const std::vector<BatchItem>& items,
                                          const AssembleOptions& options,
                                          std::vector<Candidate>& candidates) {
  std::optional<Registration> registration;
  RigidMotion motion = options.motion.value_or(RigidMotion{});
  if (options.fits_to_surface && options.surface) {
    registration = register_to_surface(measured_contacts(candidates), *options.surface, motion);
    motion = registration->motion;
  }
  Points wanted(static_cast<Eigen::Index>(candidates.size()), 3);
  wanted.setZero();
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    Candidate& c = candidates[i];
    c.surface_distance_m = kNan;
    if (c.failure || !find_position(items[c.item], motion, options, items, c)) continue;
    wanted.row(static_cast<Eigen::Index>(i)) = c.position_m;
    if (items[c.item].normal)
      c.inward = *items[c.item].normal;
    else if (c.recording->inward)
      c.inward = motion.rotation * *c.recording->inward;
    else if (!options.surface)
      refuse(c, items, "has no normal",
             "Say `normal`, the inward direction, or `surface` in the manifest.");
    c.to_body = motion.rotation;
  }
  if (options.surface) {
    const auto places = project(wanted, *options.surface);
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      Candidate& c = candidates[i];
      if (c.failure) continue;
      if (!places[i] || places[i]->distance_m > options.place_tolerance_m) {
        refuse(c, items,
               "lies " + (places[i] ? millimetres(places[i]->distance_m) : std::string("nowhere")) +
                   " from the surface",
               "Register the rig to the body ([registration] of the manifest), or raise "
               "place_tolerance (" +
                   millimetres(options.place_tolerance_m) + ").");
        continue;
      }
      c.surface_distance_m = places[i]->distance_m;
      c.position_m = places[i]->position_m;
      if (!items[c.item].normal) c.inward = places[i]->inward;
    }
  }
  for (Candidate& c : candidates)  // one-axis signals lie along the first axis
    if (!c.failure && c.recording->is_axial) c.to_body = c.inward * Vec3::UnitX().transpose();
  return registration;
}

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

void question_stiffness(const std::vector<BatchItem>& items, std::vector<Candidate>& candidates) {
  // By the way they were made: a batch may hold several rigs.
  const auto rig_of = [&](const Candidate& c) {
    const BatchItem& item = items[c.item];
    return fmt::format("{}|{}|{}{}", item.read.format, item.signal.radius_m,
                       static_cast<int>(item.signal.kind),
                       item.signal.is_range_given ? "|given" : "|");
  };
  std::map<std::string, std::vector<double>> sizes;
  for (const Candidate& c : candidates)
    if (!c.failure && std::isfinite(c.recording->apparent_Pa))
      sizes[rig_of(c)].push_back(c.recording->apparent_Pa);
  for (Candidate& c : candidates) {
    if (c.failure) continue;
    const SignalSettings& s = items[c.item].signal;
    const importers::UnitNames& units = items[c.item].read.units;
    const double found_Pa = c.recording->apparent_Pa;
    const std::vector<double>& moduli = sizes[rig_of(c)];
    const double median_Pa =
        moduli.size() >= kMinToCompare && !s.is_range_given ? upper_median(moduli) : kNan;
    const bool is_alone = std::isfinite(median_Pa) &&
                          std::abs(std::log10(found_Pa / median_Pa)) > std::log10(kOutlier);
    const bool is_implausible = !(found_Pa >= s.min_young_Pa && found_Pa <= s.max_young_Pa);
    if (!is_alone && !is_implausible) continue;
    const double expected_Pa =
        std::isfinite(median_Pa) && median_Pa >= s.min_young_Pa && median_Pa <= s.max_young_Pa
            ? median_Pa
            : kTypical_Pa;
    const auto unit =
        likely_unit(found_Pa, expected_Pa, units.force, units.position, s.radius_m > 0);
    const std::string against = is_implausible
                                    ? ", which no soft body is made of"
                                    : ", where the other recordings have " + in_pascal(median_Pa);
    refuse(c, items,
           "its stiffness is that of a body of " + in_pascal(found_Pa) + against +
               (unit ? ": is a unit wrong?" : ""),
           (unit ? unit->key + " should probably be \"" + unit->unit + "\". "
                 : std::string("Check the units. ")) +
               "If it is right, widen `plausible` in the manifest.");
  }
}

}  // namespace palpate::recordings
