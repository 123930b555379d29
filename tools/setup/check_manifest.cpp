#include <fmt/format.h>

#include <algorithm>

#include "libfit/core/error.hpp"
#include "libfit/core/text.hpp"
#include "libfit/recordings/placing/assemble.hpp"
#include "tools/console.hpp"
#include "tools/setup/check.hpp"
#include "tools/stages/import.hpp"

namespace palpate::tools {
namespace {

using namespace recordings;

constexpr std::size_t kListed = 40;  // recordings on the screen; JSON has all

struct Deepest {
  double depth_m = 0, force_N = 0;
};

Deepest deepest(const Conditioned& r) {
  const Vec3 inward = r.is_axial ? Vec3(Vec3::UnitX()) : r.inward.value_or(Vec3::Zero());
  Deepest out;
  for (Eigen::Index i = 0; i < r.deflection_m.rows(); ++i)
    if (const double depth_m = r.deflection_m.row(i).dot(inward); depth_m > out.depth_m)
      out = {depth_m, r.force_N.row(i).dot(inward)};
  return out;
}

std::string line_of(const std::string& shown, std::string_view kind, const Conditioned& r) {
  const Deepest at = deepest(r);
  return fmt::format("{}: {}, {}, {} N at {} mm, contact {} +- {} mm ({}), {}{}{}\n", shown,
                     r.source.format, kind, number(at.force_N), number(1e3 * at.depth_m),
                     number(1e3 * r.contact.travel_m), number(1e3 * r.contact.deviation_m, 2),
                     r.contact.estimator, kRecordingGradeNames[static_cast<std::size_t>(r.grade)],
                     r.reasons.empty() ? "" : ": ", listed(r.reasons, "; "));
}

nlohmann::ordered_json json_of(const std::string& shown, std::string_view kind,
                               const Conditioned& r) {
  const Deepest at = deepest(r);
  return {{"recording", shown},
          {"format", r.source.format},
          {"taken", r.source.taken},
          {"kind", kind},
          {"depth_m", at.depth_m},
          {"force_N", at.force_N},
          {"contact_m", r.contact.travel_m},
          {"contact_deviation_m", r.contact.deviation_m},
          {"grade", kRecordingGradeNames[static_cast<std::size_t>(r.grade)]},
          {"reasons", r.reasons}};
}

// Where curves are going to lie; says what keeps `run` from making a surface of the contacts.
std::string surface_in_words(const Manifest& manifest, const ReadRecordings& read) {
  if (read.scan) return "the surface is found with the curves";
  if (manifest.surface) return "on the surface " + manifest.surface->string();
  try {
    surface_of_contacts(rows_at(read.assembled.samples, read.is_held_out, false));
  } catch (const Error& e) {
    warn("`run` makes no surface of the contacts: {}; name the body's with `surface`", e.fact());
    return "without a surface";
  }
  return "the surface is made from the contacts of the others";
}

}  // namespace

CheckedManifest check_manifest(const std::filesystem::path& manifest, int jobs) {
  const ImportRequest request{read_manifest(manifest), {}, jobs, true};
  const ReadRecordings read = read_recordings(request);
  const auto& items = request.manifest.items;
  CheckedManifest out;
  out.json = nlohmann::ordered_json::parse(summary_json(read.assembled));
  out.json["recordings"] = nlohmann::ordered_json::array();
  out.refused = read.assembled.failed();
  std::size_t listed_ones = 0;
  for (std::size_t i = 0; i < items.size(); ++i)
    for (const Conditioned& r : read.results[i].recordings) {
      const std::string shown = items[i].shown + (r.name.empty() ? "" : "#" + r.name);
      const auto kind = kExperimentKindNames[static_cast<std::size_t>(items[i].signal.kind)];
      if (items[i].signal.kind != ExperimentKind::scan && ++listed_ones <= kListed)
        out.text += line_of(shown, kind, r);
      out.json["recordings"].push_back(json_of(shown, kind, r));
    }
  if (listed_ones > kListed) out.text += fmt::format("and {} more\n", listed_ones - kListed);
  const Samples& samples = read.assembled.samples;
  if (samples.rows() == 0)
    throw Error(
        manifest.string(),
        read.assembled.outcomes.size() == 1
            ? "its recording cannot be used"
            : fmt::format("none of its {} recordings can be used", read.assembled.outcomes.size()),
        "Correct what is said of each above.");
  const auto held_out = std::ranges::count(read.is_held_out, 1);
  out.json["points"] = samples.points();
  out.json["held_out_points"] = held_out;
  out.text += fmt::format("{}, {} of them held out for the error statement; {}",
                          counted(samples.points(), "point", "points"), held_out,
                          surface_in_words(request.manifest, read));
  return out;
}

}  // namespace palpate::tools
