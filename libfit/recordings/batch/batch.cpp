#include "libfit/recordings/batch/batch.hpp"

#include <fmt/core.h>

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <mutex>
#include <numeric>

#include "libfit/core/statistics.hpp"
#include "libfit/core/text.hpp"
#include "libfit/core/units.hpp"
#include "libfit/io/atomic_file.hpp"
#include "libfit/recordings/contact_point/contact_point.hpp"
#include "libfit/recordings/formats/importers.hpp"

namespace palpate::recordings {
namespace {

// Of the recordings of a file, by name, where their contacts are known by now.
using KnownContacts = std::map<std::string, FoundContact>;

// The recordings of one file's content.
void condition_all(const BatchItem& item, const Mat3& body_from_rig, const KnownContacts& known,
                   std::string bytes, ItemResult& result) {
  const std::string content = importers::unpacked(item.file, std::move(bytes), item.read.max_bytes);
  std::optional<Vec3> inward;
  if (item.normal) inward = body_from_rig.transpose() * *item.normal;
  std::vector<importers::RawRecording> recordings;
  for (const auto& raw : importers::read_recordings(item.file, content, item.read)) {
    auto places = split_places(raw, item.signal, inward);
    if (places.size() > 1 && item.position_m)
      throw Error(item.place.empty() ? item.file.string() : item.place,
                  fmt::format("has one `position`, and the tool of {} presses at {} places",
                              item.file.string(), places.size()),
                  "Leave `position` out: the recording says where they are. Or cut the file.");
    std::ranges::move(places, std::back_inserter(recordings));
  }
  for (const auto& raw : recordings) {
    SignalTrace trace;
    try {
      if (raw.unread) throw *raw.unread;
      SignalSettings signal = item.signal;
      if (const auto contact = known.find(raw.name); contact != known.end())
        signal.known_contact = contact->second;
      const std::string shown = item.file.string() + (raw.name.empty() ? "" : "#" + raw.name);
      if (signal.kind == ExperimentKind::scan)
        std::ranges::move(condition_scan(raw, signal, inward, shown),
                          std::back_inserter(result.recordings));
      else
        result.recordings.push_back(condition(raw, signal, inward, shown, &trace));
    } catch (const Error& error) {
      result.refused.push_back({recordings.size() == 1 ? "" : raw.name, error, std::move(trace)});
    }
  }
}

ItemResult import_item(const BatchItem& item, const Mat3& body_from_rig,
                       const KnownContacts& known) {
  ItemResult result;
  const auto fail = [&](const Error& error) {
    result.recordings.clear();
    result.refused = {{"", error, {}}};
  };
  try {
    std::string bytes = importers::read_bytes(item.file, item.read.max_bytes);
    result.hash = ContentHash().add(bytes).hex();
    condition_all(item, body_from_rig, known, std::move(bytes), result);
  } catch (const Error& error) {
    fail(error);
  } catch (const std::bad_alloc&) {
    fail({item.file.string(), "needs more memory than there is",
          "Use fewer --jobs, or cut the file into several."});
  } catch (const std::exception& error) {  // one recording never stops the rest
    fail({item.file.string(), std::string("could not be read: ") + error.what(),
          "Please report this with the file."});
  }
  result.is_done = true;
  return result;
}

// A recording's contact as a place on the body, and the travel from it to the surface.
struct OffSurface {
  std::size_t item = 0;
  const Conditioned* recording = nullptr;
  double off_m = 0;
};

// Deviation of a surface and its registration, by which contacts lie off it beyond their own
// deviations s_i: sum off_i^2 / (s_i^2 + d^2) = n - sqrt(2 n). The right side is one deviation of
// chi squared below n, so that luck of few contacts is not taken for a better surface, and d is at
// least the root mean square of off_i over sqrt(n), where the s_i are stated too wide. Source:
// Paule and Mandel (1982), doi:10.6028/jres.087.022.
double surface_deviation_m(const std::vector<OffSurface>& contacts) {
  const auto n = static_cast<double>(contacts.size());
  double squares_m2 = 0;
  for (const OffSurface& c : contacts) squares_m2 += c.off_m * c.off_m;
  double most_m = std::sqrt(squares_m2), least_m = most_m / n;
  for (int halved = 0; halved < 50; ++halved) {
    const double tried_m = (least_m + most_m) / 2;
    double sum = 0;
    for (const OffSurface& c : contacts)
      sum +=
          c.off_m * c.off_m / (std::pow(c.recording->contact.deviation_m, 2) + tried_m * tried_m);
    (sum > n - std::sqrt(2 * n) ? least_m : most_m) = tried_m;
  }
  return most_m;
}

// Contacts that are less sure than the surface is are weighted means of both.
void weigh_with_surface(const std::vector<ItemResult>& results, const BatchOptions& options,
                        std::vector<KnownContacts>& known) {
  constexpr std::size_t kMinContacts = 6;  // that a registration takes
  std::vector<OffSurface> contacts;
  for (std::size_t i = 0; i < results.size(); ++i)
    for (const Conditioned& r : results[i].recordings)
      if (!r.is_axial && r.contact_m && r.inward && r.contact.deviation_m > 0)
        contacts.push_back({i, &r});
  if (contacts.size() < kMinContacts) return;
  Points places(contacts.size(), 3);
  for (std::size_t k = 0; k < contacts.size(); ++k)
    places.row(k) = *contacts[k].recording->contact_m;
  RigidMotion motion = options.motion.value_or(RigidMotion{});
  if (options.fits_to_surface)
    motion = register_to_surface(places, *options.surface, motion).motion;
  for (auto place : places.rowwise()) place = motion(place.transpose()).transpose();
  const auto nearest = project(places, *options.surface);
  std::vector<OffSurface> near;
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    if (!nearest[k]) continue;
    const double cosine = nearest[k]->inward.dot(motion.rotation * *contacts[k].recording->inward);
    if (cosine < 0.5) continue;  // between press and normal: the travel is twice the gap
    const Vec3 gap_m = nearest[k]->position_m - Vec3(places.row(k));
    near.push_back(contacts[k]);
    near.back().off_m = nearest[k]->inward.dot(gap_m) / cosine;
  }
  if (near.size() < kMinContacts) return;
  const double surface_m = surface_deviation_m(near);
  for (const OffSurface& c : near) {
    const FoundContact& own = c.recording->contact;
    if (own.deviation_m <= surface_m) continue;
    const double both_m = std::hypot(own.deviation_m, surface_m);
    known[c.item][c.recording->name] = {
        own.travel_m + std::pow(own.deviation_m / both_m, 2) * c.off_m,
        own.deviation_m * surface_m / both_m, own.estimator + ", surface"};
  }
}

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
std::optional<Error> question(const BatchItem& item, const Conditioned& recording,
                              double median_Pa) {
  const SignalSettings& s = item.signal;
  const importers::UnitNames& units = item.read.units;
  const double found_Pa = recording.apparent_Pa;
  const bool is_alone =  // a prefix is 1000
      std::isfinite(median_Pa) && std::abs(std::log10(found_Pa / median_Pa)) > std::log10(100.);
  const bool is_implausible = !(found_Pa >= s.min_young_Pa && found_Pa <= s.max_young_Pa);
  if (!is_alone && !is_implausible) return std::nullopt;
  const double expected_Pa =
      std::isfinite(median_Pa) && median_Pa >= s.min_young_Pa && median_Pa <= s.max_young_Pa
          ? median_Pa
          : 1e4;  // a soft tissue
  const importers::UnitNames& read = recording.source.units;
  const auto unit =
      likely_unit(found_Pa, expected_Pa, units.force.empty() ? read.force : units.force,
                  units.position.empty() ? read.position : units.position, s.radius_m > 0);
  const std::string against = is_implausible
                                  ? ", which no soft body is made of"
                                  : ", where the other recordings have " + in_pascal(median_Pa);
  return Error(item.file.string() + (recording.name.empty() ? "" : "#" + recording.name),
               "its stiffness is that of a body of " + in_pascal(found_Pa) + against +
                   (unit ? ": is a unit wrong?" : ""),
               (unit ? remedy_of(*unit, units, read) : std::string("Check the units. ")) +
                   "If it is right, widen `plausible` in the manifest.");
}

}  // namespace

std::string point_of(const BatchItem& item, const std::string& recording) {
  const std::string point = item.point.empty() ? item.file.stem().string() : item.point;
  return recording.empty() ? point : point + "#" + recording;
}

std::vector<ItemResult> run_batch(const std::vector<BatchItem>& items, const BatchOptions& options,
                                  const Progress& progress) {
  std::vector<ItemResult> results(items.size());
  const Mat3 body_from_rig = options.motion.value_or(RigidMotion{}).rotation;
  std::mutex reporting;
  std::size_t done = 0;
  tbb::task_arena arena(options.jobs > 0 ? options.jobs : tbb::task_arena::automatic);
  const auto import = [&](const std::vector<std::size_t>& which,
                          const std::vector<KnownContacts>& known) {
    arena.execute([&] {
      tbb::parallel_for(
          tbb::blocked_range<std::size_t>(0, which.size(), 1),
          [&](const tbb::blocked_range<std::size_t>& range) {
            for (std::size_t k = range.begin(); k < range.end(); ++k) {
              if (progress.stopped()) return;
              const std::size_t i = which[k];
              results[i] = import_item(items[i], body_from_rig, known[i]);
              const std::lock_guard<std::mutex> lock(reporting);
              progress.report(std::min(++done, items.size()), items.size(), items[i].shown);
            }
          },
          tbb::simple_partitioner());
    });
  };
  std::vector<std::size_t> all(items.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  import(all, std::vector<KnownContacts>(items.size()));
  if (!progress.stopped()) {
    std::vector<KnownContacts> known(items.size());
    if (options.surface) weigh_with_surface(results, options, known);
    std::erase_if(all, [&](std::size_t i) { return known[i].empty(); });
    import(all, known);
  }
  return results;
}

std::optional<LikelyUnit> likely_unit(double found_Pa, double expected_Pa,
                                      const std::string& force_unit, const std::string& length_unit,
                                      bool has_radius) {
  const double force = unit_factor(force_unit, Dimension::force).value_or(1);
  const double length = unit_factor(length_unit, Dimension::length).value_or(1e-3);
  const double power = has_radius ? 1.5 : 2;
  std::optional<LikelyUnit> best;
  double least = std::log10(30.);  // bodies differ by this much; prefixes by 1000
  const auto consider = [&](double modulus_Pa, const std::string& key, std::string_view unit) {
    const double off = std::abs(std::log10(modulus_Pa / expected_Pa));
    if (off < least - 1e-9) {
      least = off;
      best = LikelyUnit{key, std::string(unit)};
    }
  };
  for (const std::string_view unit : {"N", "mN", "uN", "nN", "kN", "gf"})
    if (const double factor = *unit_factor(unit, Dimension::force); factor != force)
      consider(found_Pa * factor / force, "units.force", unit);
  for (const std::string_view unit : {"mm", "m", "um", "nm", "cm"})
    if (const double factor = *unit_factor(unit, Dimension::length); factor != length)
      consider(found_Pa * std::pow(length / factor, power), "units.position", unit);
  return best;
}

std::vector<std::vector<std::optional<Error>>> question_stiffness(
    const std::vector<BatchItem>& items, const std::vector<ItemResult>& results) {
  std::map<std::string, std::vector<double>> moduli;
  for (std::size_t i = 0; i < results.size(); ++i)
    for (const Conditioned& recording : results[i].recordings)
      if (std::isfinite(recording.apparent_Pa))
        moduli[rig_of(items[i])].push_back(recording.apparent_Pa);
  std::map<std::string, double> median_Pa;
  for (const auto& [rig, of_rig] : moduli)
    median_Pa[rig] = of_rig.size() >= 5 ? upper_median(of_rig) : kNan;
  std::vector<std::vector<std::optional<Error>>> failures(results.size());
  for (std::size_t i = 0; i < results.size(); ++i) {
    const auto of_rig = median_Pa.find(rig_of(items[i]));
    const bool is_compared = of_rig != median_Pa.end() && !items[i].signal.is_range_given;
    for (const Conditioned& recording : results[i].recordings)
      failures[i].push_back(
          items[i].signal.kind == ExperimentKind::scan  // its depth is not known
              ? std::nullopt
              : question(items[i], recording, is_compared ? of_rig->second : kNan));
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
    const auto at = std::find_if(begin, end, [&, &b = items[i]](const auto& other) {
      const BatchItem& a = items[other.second];
      return a.read == b.read && a.signal == b.signal && a.normal == b.normal;
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
