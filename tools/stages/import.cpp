#include "tools/stages/import.hpp"

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>
#include <sstream>

#include "libfem/mesh/read/read.hpp"
#include "libfem/mesh/repair/mend.hpp"
#include "libfit/assets/asset_file.hpp"
#include "libfit/core/error.hpp"
#include "libfit/core/stated_error.hpp"
#include "libfit/core/text.hpp"
#include "libfit/io/atomic_file.hpp"
#include "libfit/io/files/files.hpp"
#include "libfit/recordings/formats/importers.hpp"
#include "libfit/scan/scan.hpp"
#include "tools/console.hpp"
#include "tools/manifest/manifest.hpp"
#include "tools/stages/fingerprint.hpp"
#include "tools/stages/validate.hpp"

namespace palpate::tools {
namespace {

namespace fs = std::filesystem;
using namespace recordings;

constexpr std::size_t kListed = 20;  // failures on the screen; all are in the summary

// "out/samples.h5" -> "out/samples.import.csv"
fs::path beside(const fs::path& output, const char* extension) {
  return output.parent_path() / (output.stem().string() + ".import" + extension);
}

BatchOptions batch_options(const ImportRequest& request, const Manifest& manifest,
                           const std::optional<Surface>& surface) {
  BatchOptions options = manifest.options;
  options.jobs = job_count(request.jobs);
  if (!manifest.items.front().signal.is_pass && surface)  // else places lie on no surface yet
    options.surface = &*surface;
  if (manifest.rig_landmarks_m.rows() > 0) {
    const Registration landmarks =
        register_landmarks(manifest.rig_landmarks_m, manifest.body_landmarks_m);
    say("landmarks: {} pairs, residual {:.3g} mm rms, {:.3g} mm at most",
        manifest.rig_landmarks_m.rows(), 1e3 * landmarks.rms_m, 1e3 * landmarks.largest_m);
    options.motion = landmarks.motion;
  }
  return options;
}

// A key of [defaults] that no recording's format reads is an error, as it is in an entry.
void check_defaults(const Manifest& manifest, const std::vector<ItemResult>& results) {
  std::set<std::string> formats;
  for (const ItemResult& result : results)
    for (const Conditioned& r : result.recordings) formats.insert(r.source.format);
  if (formats.empty()) return;
  for (const importers::SaidKey& said : manifest.said_by_default) {
    const importers::FormatKey& key = *importers::format_key(said.name);
    if (std::ranges::none_of(formats,
                             [&](const auto& of) { return importers::has_word(key.formats, of); }))
      throw Error(said.where,
                  fmt::format("`{}` does nothing for these recordings, which are read as {}",
                              said.name, listed(std::vector(formats.begin(), formats.end()))),
                  std::string(key.remedy));
  }
}

std::vector<ItemResult> read_all(const Manifest& manifest, const BatchOptions& options) {
  ConsoleProgress progress("import");
  const auto results = run_batch(manifest.items, options, progress.progress());
  const auto done = static_cast<std::size_t>(
      std::count_if(results.begin(), results.end(), [](const ItemResult& r) { return r.is_done; }));
  if (done < results.size())
    throw Interrupted(fmt::format(
        "{} of {} recordings were read and nothing was written; the same command begins again",
        done, results.size()));
  check_defaults(manifest, results);
  return results;
}

// What the files were recognised as; with --verbose what was taken from each.
void report_formats(const Manifest& manifest, const std::vector<ItemResult>& results) {
  std::map<std::string, int> formats;
  for (std::size_t i = 0; i < results.size(); ++i)
    for (const Conditioned& r : results[i].recordings) {
      ++formats[r.source.format];
      if (is_verbose())
        say("{}{}: {}; {}", manifest.items[i].shown, r.name.empty() ? "" : "#" + r.name,
            r.source.format, listed(r.source.taken, "; "));
    }
  for (const auto& [format, count] : formats)
    say("{} read as {}", counted(count, "recording", "recordings"), format);
}

void report_distance(const Assembled& assembled) {
  double squares = 0, largest = 0;
  std::size_t n = 0;
  for (const PlacedRecording& outcome : assembled.outcomes)
    if (!outcome.failure && outcome.surface_distance_m >= 0) {
      squares += outcome.surface_distance_m * outcome.surface_distance_m;
      largest = std::max(largest, outcome.surface_distance_m);
      ++n;
    }
  if (n > 0)
    say("{} recordings lie {:.3g} mm rms from the surface, {:.3g} mm at most", n,
        1e3 * std::sqrt(squares / static_cast<double>(n)), 1e3 * largest);
}

void report_grades(const Assembled& assembled) {
  const auto& grades = assembled.samples.recordings.grade;
  const auto count = [&](int grade) { return std::count(grades.begin(), grades.end(), grade); };
  say("{} recordings: {} good, {} fair, {} poor", grades.size(), count(0), count(1), count(2));
}

void report(const ImportRequest& request, const std::vector<ItemResult>& results,
            const Assembled& assembled) {
  if (assembled.registration)
    say("surface: residual {:.3g} mm rms, {:.3g} mm at most, after {} steps",
        1e3 * assembled.registration->rms_m, 1e3 * assembled.registration->largest_m,
        assembled.registration->iterations);
  report_formats(request.manifest, results);
  report_distance(assembled);
  for (std::size_t i = 0; i < assembled.notes.size() && i < kListed; ++i)
    say("note: {}", assembled.notes[i]);
  std::size_t listed = 0;
  for (const PlacedRecording& outcome : assembled.outcomes)
    if (outcome.failure && ++listed <= kListed)
      say_failed("refused: {}: {}\n  {}", outcome.failure->where(), outcome.failure->fact(),
                 outcome.failure->remedy());
  if (listed > kListed) say("and {} more", listed - kListed);
  if (listed > 0)
    say("{} of {} recordings were refused{}", listed, assembled.outcomes.size(),
        request.output.empty() ? ""
                               : "; " + beside(request.output, ".csv").string() + " lists all");
  report_grades(assembled);
}

// Numbers of the rig that an import of scans to samples.h5 found, and its motion onto the mesh;
// none where it was of no scans.
std::pair<scan::Recording, RigidMotion> recording_of(const fs::path& samples) {
  std::pair<scan::Recording, RigidMotion> out;
  const fs::path curves = scan_curves_path(samples);
  if (samples.empty() || !fs::exists(curves)) return out;
  std::istringstream text(stored_in_hdf5(curves, kRecordingAttribute).value_or(""));
  for (double& number : out.first.number) text >> number;
  for (double& number : out.second.rotation.reshaped()) text >> number;
  for (double& number : out.second.translation_m) text >> number;
  if (!text)
    throw Error(curves.string(), "does not say how its recordings were corrected",
                "Import the scans again.");
  return out;
}

void move(const RigidMotion& motion, Samples& samples) {
  for (Points* vectors : {&samples.point_normal, &samples.deflection, &samples.force})
    *vectors *= motion.rotation.transpose();
  for (auto place : samples.point_position.rowwise()) place = motion(place.transpose()).transpose();
}

// Moves a scan onto the mesh of its body, by the points that it found on its surface.
void register_scan(const ImportRequest& request, const Surface& mesh, const Points& found,
                   ReadRecordings& read) {
  const Registration registration = register_to_surface(found, mesh, {});
  if (!(registration.rms_m <= request.manifest.options.place_tolerance_m))
    throw Error(request.manifest.path.string(),
                fmt::format("the scan's surface lies {:.2g} mm (rms) from the mesh, where it fits "
                            "best from this start",
                            1e3 * registration.rms_m),
                "Say where the scan was: [registration], with three landmarks; or raise "
                "place_tolerance.");
  move(registration.motion, read.assembled.samples);
  read.motion = registration.motion;
  read.assembled.registration = registration;
}

// Corrects scans by the numbers of an earlier recording.
void compare_scans(const ImportRequest& request, ReadRecordings& read) {
  Samples& samples = read.assembled.samples;
  const Surface surface = palpate::surface_of(*request.asset);
  Eigen::Index rows = 0;
  const auto [earlier, motion] = recording_of(request.earlier);
  move(motion, samples);
  // A tenth of the curves' depth: the body repeats its heights to a few tenths of a millimetre.
  const scan::Recording recording =
      scan::later_recording(samples, surface, earlier, 0.1 * request.asset->max_fitted_m, &rows);
  const auto bias = recording.number.segment<3>(scan::kBias);
  read.assembled.notes.push_back(
      rows < 10
          ? fmt::format("scan: {} rows are out of contact, too few for a bias of its own", rows)
          : fmt::format("scan: bias of the force {:.3g}, {:.3g}, {:.3g} N by {} rows out of "
                        "contact",
                        bias[0], bias[1], bias[2], rows));
  samples = scan::corrected(samples, surface, recording);
}

// Finds surface and curves of scans, and takes what belongs to their recordings off all rows.
void identify_scans(const ImportRequest& request, const std::optional<Surface>& surface,
                    ReadRecordings& read) {
  Samples& samples = read.assembled.samples;
  if (!request.manifest.items.front().signal.is_pass || samples.rows() == 0) return;
  if (!samples.other_probes.empty())
    throw Error(request.manifest.path.string(), "has recordings of several tips beside a scan",
                "Import those of each tip by a manifest of their own.");
  if (request.asset != nullptr) return compare_scans(request, read);
  ConsoleProgress progress("scan");
  if (surface) {
    const Points found = scan::points_on_surface(rows_at(samples, read.is_held_out, false),
                                                 job_count(request.jobs), progress.progress());
    if (!progress.progress().stopped()) register_scan(request, *surface, found, read);
  }
  scan::ScanFit fit =
      scan::identify(rows_at(samples, read.is_held_out, false), job_count(request.jobs),
                     progress.progress(), surface ? &*surface : nullptr);
  if (progress.progress().stopped()) throw Interrupted("import: nothing was written");
  fit.curves.probe = samples.probe;
  for (const std::string& note : fit.notes) read.assembled.notes.push_back("scan: " + note);
  samples = scan::corrected(samples, fit.surface, fit.recording);
  read.scan = std::make_shared<const scan::ScanFit>(std::move(fit));
}

// Points of samples, with the smallest deviation of the contacts found at each; 0: unknown.
Contacts contacts_of(const Samples& samples) {
  Contacts out{samples.point_position, samples.point_normal,
               Eigen::VectorXd::Zero(samples.points())};
  const MeasuredRecordings& recordings = samples.recordings;
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    const auto row = std::ranges::find(samples.experiment, recordings.experiment[r]);
    if (row == samples.experiment.end()) continue;
    const auto at = static_cast<std::size_t>(row - samples.experiment.begin());
    double& deviation_m = out.deviation_m[samples.point[at]];
    const double found_m = recordings.contact_deviation_m[r];
    if (found_m > 0 && (deviation_m == 0 || found_m < deviation_m)) deviation_m = found_m;
  }
  return out;
}

}  // namespace

std::optional<Surface> surface_of(const Manifest& manifest) {
  if (!manifest.surface) return std::nullopt;
  // Mended as `prepare` does, so that normals point where the body's do.
  MendOptions options;
  options.allow_open = true;
  Mended mended = mend_surface(read_surface(*manifest.surface, manifest.length_unit_m), options,
                               manifest.surface->string());
  for (const std::string& change : mended.changes) say("  mended: {}", change);
  return std::move(mended.surface);
}

ContactSurface surface_of_contacts(const Samples& samples) {
  const ContactSurface made = surface_from_contacts(contacts_of(samples));
  std::vector<double> off_m;
  for (const double m : made.left_out_m)
    if (std::isfinite(m)) off_m.push_back(std::abs(m));
  say("  {} through {} contacts, {:.3g} mm apart (median): {} triangles",
      made.is_height_field ? "height field" : "surface around the body", made.left_out_m.size(),
      1e3 * made.spacing_m, made.surface.triangles.rows());
  if (off_m.empty())
    say("  contacts are too few to leave any out: how well the surface fits is not known");
  else
    say("  contacts left out lie {:.3g} mm off the surface of the others (median), {:.3g} mm "
        "(p95), {:.3g} mm at most; quadrics reach {:g} spacings{}",
        1e3 * stated_quantile(off_m, 0.5), 1e3 * stated_quantile(off_m, 0.95),
        1e3 * stated_quantile(off_m, 1), made.reach,
        made.uses_normals ? ", normals count" : ", normals do not count");
  return made;
}

std::string obj_text(const Surface& surface) {
  std::string text = "# palpate surface, length_unit = \"mm\"\n";
  for (Eigen::Index v = 0; v < surface.vertices.rows(); ++v)
    text += fmt::format("v {:.9g} {:.9g} {:.9g}\n", 1e3 * surface.vertices(v, 0),
                        1e3 * surface.vertices(v, 1), 1e3 * surface.vertices(v, 2));
  for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t)
    text += fmt::format("f {} {} {}\n", surface.triangles(t, 0) + 1, surface.triangles(t, 1) + 1,
                        surface.triangles(t, 2) + 1);
  return text;
}

fs::path scan_body_path(fs::path samples) { return samples.replace_extension(".scan_body.h5"); }
fs::path scan_curves_path(fs::path samples) { return samples.replace_extension(".scan_curves.h5"); }

Body body_of_recordings(const Manifest& manifest, const Samples& samples) {
  Body body;
  auto given = surface_of(manifest);
  body.surface = given ? std::move(*given) : surface_of_contacts(samples).surface;
  const auto vertices = static_cast<std::size_t>(body.surface.vertices.rows());
  body.in_region.assign(vertices, 1);
  body.is_reachable.assign(vertices, 1);
  body.test_points.position = samples.point_position;
  body.test_points.normal = samples.point_normal;
  body.test_points.name = samples.point_name;
  body.probe = samples.probe;
  return body;
}

fs::path import_summary_path(const fs::path& samples) { return beside(samples, ".json"); }

void check_recordings_exist(const Manifest& manifest) {
  if (std::ranges::any_of(manifest.items,
                          [](const BatchItem& item) { return fs::exists(item.file); }))
    return;
  const std::string first = manifest.items.front().shown;
  throw Error(manifest.path.string(),
              manifest.items.size() == 1
                  ? "names the recording " + first + ", and there is no such file"
                  : fmt::format("names {} recordings, of which no file is there, such as {}",
                                manifest.items.size(), first),
              "Correct the names in the manifest; they start at its folder.");
}

ReadRecordings read_recordings(const ImportRequest& request) {
  const Manifest& manifest = request.manifest;
  check_recordings_exist(manifest);
  const auto surface = surface_of(manifest);
  const BatchOptions options = batch_options(request, manifest, surface);
  ReadRecordings out;
  out.results = read_all(manifest, options);
  out.assembled = assemble(manifest.items, out.results, options);
  Samples& samples = out.assembled.samples;
  std::vector<ProbeSpec> probes = probes_of(manifest, out.assembled.tips);
  samples.probe = probes.front();
  samples.other_probes.assign(probes.begin() + 1, probes.end());
  samples.poisson = manifest.items.front().signal.poisson;
  out.is_held_out = held_out_points(manifest, samples, request.holds_out);
  identify_scans(request, surface, out);
  report(request, out.results, out.assembled);
  return out;
}

nlohmann::ordered_json write_recordings(const ImportRequest& request, const ReadRecordings& read,
                                        const std::string& inputs) {
  const Assembled& assembled = read.assembled;
  write_summary(beside(request.output, ".csv"), beside(request.output, ".json"), assembled);
  if (assembled.samples.rows() == 0)
    throw Error(request.manifest.path.string(),
                "none of its " + std::to_string(assembled.outcomes.size()) +
                    " recordings could be imported; " + request.output.string() +
                    " was not written",
                "See the list above, or " + beside(request.output, ".csv").string() + ".");
  const Attributes fingerprint{{kInputsAttribute, inputs}};
  const Samples held_out = rows_at(assembled.samples, read.is_held_out, true),
                fitted = held_out.rows() == 0 ? assembled.samples
                                              : rows_at(assembled.samples, read.is_held_out, false);
  write_samples(request.output, fitted, fingerprint);
  const fs::path beside_it = held_out_path(request.output);
  if (held_out.rows() > 0)
    write_samples(beside_it, held_out, fingerprint);
  else
    fs::remove(beside_it);
  if (read.scan) {
    Body body;
    body.surface = read.scan->surface;
    body.in_region = body.is_reachable = read.scan->is_covered;
    body.test_points = {read.scan->curves.position, read.scan->curves.normal,
                        read.scan->curves.name, body.surface.triangles};
    body.probe = read.scan->curves.probe;
    write_body(scan_body_path(request.output), body, fingerprint);
    Attributes with_recording = fingerprint;
    std::string& numbers = with_recording[kRecordingAttribute];
    for (const double number : read.scan->recording.number) numbers += fmt::format("{} ", number);
    for (const double number : read.motion.rotation.reshaped())
      numbers += fmt::format("{} ", number);
    for (const double number : read.motion.translation_m) numbers += fmt::format("{} ", number);
    write_curves(scan_curves_path(request.output), read.scan->curves, with_recording);
  } else {
    fs::remove(scan_body_path(request.output));
    fs::remove(scan_curves_path(request.output));
  }
  write_signals(signals_path(request.output), signals_of(assembled), fingerprint);
  say("wrote {}: {} rows at {} points", request.output.string(), fitted.rows(), fitted.points());
  if (held_out.rows() > 0)
    say("wrote {}: {} rows at {} points, held out of the fit for the error statement",
        beside_it.string(), held_out.rows(), held_out.points());
  return nlohmann::ordered_json::parse(summary_json(assembled));
}

}  // namespace palpate::tools
