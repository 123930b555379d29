#include <malloc.h>

#include <filesystem>
#include <map>

#include "libfem/mesh/read/read.hpp"
#include "libfem/mesh/repair/mend.hpp"
#include "libfit/core/text.hpp"
#include "libfit/io/content_hash.hpp"
#include "libfit/io/files/files.hpp"
#include "libfit/io/files/signals_file.hpp"
#include "libfit/recordings/placing/assemble.hpp"
#include "tools/command.hpp"
#include "tools/console.hpp"
#include "tools/manifest/manifest.hpp"
#include "tools/stages/fingerprint.hpp"

namespace palpate::tools {
namespace {

constexpr NamedOutput kBeside[] = {{".signals.h5", kSignalsSchema.name},
                                   {".import.csv", "file,line,recording"},
                                   {".import.json", "{\"files\":"},
                                   {".import.journal", "palpate-journal"},
                                   {".relaxation.import.csv", "file,point,time_s"}};

namespace fs = std::filesystem;
using namespace recordings;

constexpr std::size_t kListed = 20;  // failures on the screen; all are in the summary

// "out/samples.h5" -> "out/samples.import.csv"
fs::path beside(const fs::path& output, const char* extension) {
  return output.parent_path() / (output.stem().string() + ".import" + extension);
}

class Import final : public Command {
 public:
  explicit Import(Arguments& arguments) {
    arguments.positional("manifest", manifest_,
                         "Manifest of the recordings and how to read them, manifest.toml");
    arguments.output("-o,--output", output_,
                     "samples.h5 to write, with samples.signals.h5, samples.import.csv, .json and "
                     ".journal beside it",
                     {kSamplesSchema.name});
    arguments.named_outputs(output_, kBeside);
    arguments.option("--jobs", jobs_,
                     "Number of threads; 0 uses all cores; results do not depend on it");
    arguments.flag("--drop-invalid", drop_invalid_,
                   "Leave out rows that are not numbers or go back in time, and count them");
    arguments.flag("--force", force_,
                   "Read every recording again, ignore the journal, and replace files beside the "
                   "output that Palpate did not write");
  }

  int run(Reply& reply) override {
    // Arrays come and go by the megabyte: what is freed is used again instead of handed back.
    ::mallopt(M_MMAP_THRESHOLD, 1 << 30), ::mallopt(M_TRIM_THRESHOLD, 1 << 30);
    ::mallopt(M_TOP_PAD, 1 << 26);
    Manifest manifest = read_manifest(manifest_);
    for (BatchItem& item : manifest.items) item.read.drop_invalid |= drop_invalid_;
    const auto surface = read_surface_of(manifest);
    const AssembleOptions options = place_options(manifest, surface);
    const auto results = read_all(manifest, options);
    Assembled assembled = assemble(manifest.items, results, options);
    std::vector<ProbeSpec> probes = probes_of(manifest, assembled.tips);
    assembled.samples.probe = probes.front();
    assembled.samples.other_probes.assign(probes.begin() + 1, probes.end());
    assembled.samples.poisson = poisson_of(manifest);
    write_summary(beside(output_, ".csv"), beside(output_, ".json"), manifest.items, results,
                  assembled);
    if (assembled.relaxation)
      write_relaxation(fs::path(output_).replace_extension(".relaxation.import.csv"),
                       *assembled.relaxation);
    reply.json = nlohmann::ordered_json::parse(summary_json(manifest.items, results, assembled));
    report(manifest, results, assembled);
    if (assembled.samples.rows() == 0)
      throw Error(manifest_,
                  "none of its " + std::to_string(assembled.outcomes.size()) +
                      " recordings could be imported; " + output_ + " was not written",
                  "See the list above, or " + beside(output_, ".csv").string() + ".");
    const Attributes fingerprint{{"inputs_hash", inputs_hash(manifest, results)}};
    write_samples(output_, assembled.samples, fingerprint);
    write_signals(signals_path(output_), signals_of(manifest.items, results, assembled),
                  fingerprint);
    say("wrote {}: {} rows at {} points", output_, assembled.samples.rows(),
        assembled.samples.points());
    return assembled.failed() > 0 ? kSomeFailed : kDone;
  }

 private:
  std::optional<Surface> read_surface_of(const Manifest& manifest) const {
    if (!manifest.surface) return std::nullopt;
    // Mended as `prepare` does, so that normals point where the body's do.
    MendOptions options;
    options.allow_open = true;
    Mended mended = mend_surface(read_surface(*manifest.surface, manifest.length_unit_m), options,
                                 manifest.surface->string());
    for (const std::string& change : mended.changes) say("  mended: {}", change);
    return std::move(mended.surface);
  }

  AssembleOptions place_options(const Manifest& manifest,
                                const std::optional<Surface>& surface) const {
    AssembleOptions options;
    options.surface = surface ? &*surface : nullptr;
    options.motion = manifest.motion;
    if (manifest.rig_landmarks_m.rows() > 0) {
      const Registration landmarks =
          register_landmarks(manifest.rig_landmarks_m, manifest.body_landmarks_m);
      say("landmarks: {} pairs, residual {:.3g} mm rms, {:.3g} mm at most",
          manifest.rig_landmarks_m.rows(), 1e3 * landmarks.rms_m, 1e3 * landmarks.largest_m);
      options.motion = landmarks.motion;
    }
    options.fits_to_surface = manifest.fits_to_surface;
    options.place_tolerance_m = manifest.place_tolerance_m;
    options.pools_repeats = manifest.pools_repeats;
    options.relaxation = manifest.relaxation;
    return options;
  }

  std::vector<ItemResult> read_all(const Manifest& manifest, const AssembleOptions& options) const {
    const fs::path journal = beside(output_, ".journal");
    if (std::error_code ignored; force_) fs::remove(journal, ignored);
    ConsoleProgress progress("import");
    BatchOptions batch{
        .jobs = job_count(jobs_), .journal = journal, .program = import_fingerprint()};
    if (options.motion) batch.body_from_rig = options.motion->rotation;
    const auto results = run_batch(manifest.items, batch, progress.progress());
    const auto done = static_cast<std::size_t>(std::count_if(
        results.begin(), results.end(), [](const ItemResult& r) { return r.is_done; }));
    if (done < results.size())
      throw Interrupted(
          fmt::format("{} of {} recordings are kept in {}; the same command goes on from there",
                      done, results.size(), journal.string()));
    return results;
  }

  void report(const Manifest& manifest, const std::vector<ItemResult>& results,
              const Assembled& assembled) const {
    const auto reused = std::count_if(results.begin(), results.end(),
                                      [](const ItemResult& r) { return r.is_reused; });
    if (reused > 0)
      say("{} of {} files are unchanged and were not read again", reused, results.size());
    if (assembled.registration)
      say("surface: residual {:.3g} mm rms, {:.3g} mm at most, after {} steps",
          1e3 * assembled.registration->rms_m, 1e3 * assembled.registration->largest_m,
          assembled.registration->iterations);
    report_formats(manifest, results);
    report_distance(assembled);
    for (std::size_t i = 0; i < assembled.notes.size() && i < kListed; ++i)
      say("note: {}", assembled.notes[i]);
    std::size_t listed = 0;
    for (const Outcome& outcome : assembled.outcomes)
      if (outcome.failure && ++listed <= kListed)
        say_failed("refused: {}: {}\n  {}", outcome.failure->where, outcome.failure->what,
                   outcome.failure->remedy);
    if (listed > kListed) say("and {} more", listed - kListed);
    if (listed > 0)
      say("{} of {} recordings were refused; {} lists all", listed, assembled.outcomes.size(),
          beside(output_, ".csv").string());
    report_grades(assembled);
    (void)manifest;
  }

  // What the files were recognised as; with --verbose what was taken from each.
  static void report_formats(const Manifest& manifest, const std::vector<ItemResult>& results) {
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

  static void report_distance(const Assembled& assembled) {
    double squares = 0, largest = 0;
    std::size_t n = 0;
    for (const Outcome& outcome : assembled.outcomes)
      if (!outcome.failure && outcome.surface_distance_m >= 0) {
        squares += outcome.surface_distance_m * outcome.surface_distance_m;
        largest = std::max(largest, outcome.surface_distance_m);
        ++n;
      }
    if (n > 0)
      say("{} recordings lie {:.3g} mm rms from the surface, {:.3g} mm at most", n,
          1e3 * std::sqrt(squares / static_cast<double>(n)), 1e3 * largest);
  }

  static void report_grades(const Assembled& assembled) {
    const auto& grades = assembled.samples.recordings.grade;
    const auto count = [&](int grade) { return std::count(grades.begin(), grades.end(), grade); };
    say("{} recordings: {} good, {} fair, {} poor", grades.size(), count(0), count(1), count(2));
  }

  std::string inputs_hash(const Manifest& manifest, const std::vector<ItemResult>& results) const {
    ContentHash hash;
    hash.add_file(manifest.path);
    if (manifest.surface) hash.add_file(*manifest.surface);
    for (const ItemResult& result : results) hash.add(result.hash);
    return hash.hex();
  }

  std::string manifest_, output_;
  int jobs_ = 0;
  bool drop_invalid_ = false, force_ = false;
};

}  // namespace

std::unique_ptr<Command> declare_import(Arguments& arguments) {
  return std::make_unique<Import>(arguments);
}

}  // namespace palpate::tools
