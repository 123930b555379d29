#include "tools/stages/stage_table.hpp"

#include <nlohmann/json.hpp>

#include "libfit/io/atomic_file.hpp"
#include "libfit/io/files/files.hpp"
#include "tools/console.hpp"
#include "tools/outputs.hpp"
#include "tools/scene/canonical.hpp"
#include "tools/stages/body/prepare.hpp"
#include "tools/stages/fingerprint.hpp"
#include "tools/stages/import.hpp"
#include "tools/stages/model.hpp"
#include "tools/stages/samples/experiment_table.hpp"
#include "tools/stages/samples/placement.hpp"
#include "tools/stages/validate.hpp"

namespace palpate::tools {
namespace {

namespace fs = std::filesystem;

constexpr const char* kCurvesToAsset = "fit, refine, export";

Attributes inputs_of(const std::string& fingerprint) {
  return fingerprint.empty() ? Attributes{} : Attributes{{kInputsAttribute, fingerprint}};
}

// The body with the test points that were simulated.
fs::path placed_body(const Pipeline& p) {
  return p.scene.experiments.placement ? p.files.samples.parent_path() / "placed.h5" : p.files.body;
}

std::string wanted_body(const Pipeline& p) { return body_fingerprint(p.scene); }
void write_prepared(Pipeline& p, const std::string& fingerprint, bool is_new) {
  if (!p.surface_only) check_experiments(p.scene, p.body);
  if (p.before_writing) p.before_writing();
  // A body that is up to date still carries how experiments are made on it now.
  if (store_scene(p.scene, p.body) || is_new)
    write_body(p.files.body, p.body, inputs_of(fingerprint));
}
void make_body(Pipeline& p, const std::string& fingerprint) {
  p.body = prepare_body(p.scene, p.surface_only);
  write_prepared(p, fingerprint, true);
}
void load_prepared(Pipeline& p, const std::string& fingerprint) {
  p.body = read_body(p.files.body);
  write_prepared(p, fingerprint, false);
}

std::string wanted_samples(const Pipeline& p) { return samples_fingerprint(p.scene, p.body); }
std::optional<std::string> stored_samples(const Pipeline& p) {
  const auto stored = stored_in_hdf5(p.files.samples);
  const bool has_points =
      !p.scene.experiments.placement || stored_in_hdf5(placed_body(p)) == stored;
  const bool has_surface = surface_columns(p.scene, p.body) == 0 ||
                           stored_in_hdf5(surface_path(p.files.samples)) == stored;
  return has_points && has_surface ? stored : std::nullopt;
}
void make_samples(Pipeline& p, const std::string&) {
  p.samples = simulate_scene(
      p.scene, p.body,
      request_for(p.scene, p.body, Purpose::identify, p.jobs, p.files.samples, p.resume));
}
void say_simulated(Pipeline& p) {
  say_force_errors(p.samples, p.scene.experiments.force_tolerance);
  p.bad_experiments = list_bad_experiments(p.samples);
  p.samples = {};
}

std::string wanted_recordings(const Pipeline& p) {
  const Manifest& manifest = p.import.manifest;
  ContentHash hash;
  hash.add(import_fingerprint()).add_file(manifest.path);
  if (manifest.surface) hash.add_file(*manifest.surface);
  for (const recordings::BatchItem& item : manifest.items) {
    hash.add(item.shown);
    if (fs::is_regular_file(item.file)) hash.add_file(item.file);
  }
  return hash.add(p.import.holds_out ? "hold" : "").hex();
}
void make_recorded_samples(Pipeline& p, const std::string& fingerprint) {
  const ReadRecordings read = read_recordings(p.import);
  p.imported = write_recordings(p.import, read, fingerprint);
  p.bad_experiments = read.assembled.failed();
}
// Recordings that were refused when they were read stay refused until their files change.
void load_imported(Pipeline& p, const std::string&) {
  const fs::path summary = import_summary_path(p.files.samples);
  const auto json = nlohmann::json::parse(read_whole_file(summary), nullptr, false);
  p.bad_experiments = json.is_object() ? json.value("failed", std::size_t{0}) : 0;
  if (*p.bad_experiments > 0)
    say("{} refused; {} lists all",
        counted(static_cast<std::int64_t>(*p.bad_experiments), "recording was", "recordings were"),
        summary.string());
}
std::optional<std::string> stored_recordings(const Pipeline& p) {
  return fs::exists(import_summary_path(p.files.samples)) ? stored_in_hdf5(p.files.samples)
                                                          : std::nullopt;
}

std::string wanted_recorded_body(const Pipeline& p) {
  ContentHash hash = stage_hash("body").add_file(p.files.samples);
  if (p.import.manifest.surface) hash.add_file(*p.import.manifest.surface);
  return hash.hex();
}
void make_recorded_body(Pipeline& p, const std::string& fingerprint) {
  const fs::path scan_body = scan_body_path(p.files.samples);
  const Body body = fs::exists(scan_body)
                        ? read_body(scan_body)
                        : body_of_recordings(p.import.manifest, read_samples(p.files.samples));
  if (!p.import.manifest.surface)
    write_file_atomically(fs::path(p.files.body).replace_extension(".obj"), obj_text(body.surface));
  write_body(p.files.body, body, inputs_of(fingerprint));
}

std::string wanted_curves(const Pipeline& p) {
  return stage_hash("curves").add(canonical(p.fit)).add_file(p.files.samples).hex();
}
void make_curves(Pipeline& p, const std::string& fingerprint) {
  if (const fs::path scan = scan_curves_path(p.files.samples); fs::exists(scan)) {
    say("  the curves of a scan come with its surface: those that import found");
    return write_curves(p.files.curves, read_curves(scan), inputs_of(fingerprint));
  }
  const FittedCurves curves =
      fit_samples(read_samples(p.files.samples), p.fit, p.jobs, p.fit_choices);
  write_curves(p.files.curves, curves, inputs_of(fingerprint));
}

// Recordings say nothing of how contacts interact, nor of how the surface moves.
bool is_measured(const Pipeline& p) {
  return p.files.samples.empty() || !p.import.manifest.items.empty();
}
std::string wanted_model(const Pipeline& p) {
  ContentHash hash = stage_hash("model").add_file(p.files.curves).add_file(placed_body(p));
  if (is_measured(p)) return hash.hex();
  hash.add_file(p.files.samples);
  if (const auto surface = surface_path(p.files.samples); fs::exists(surface))
    hash.add_file(surface);
  return hash.hex();
}
void make_model(Pipeline& p, const std::string& fingerprint) {
  const Body body = read_body(placed_body(p));
  const bool is_of_scene = !body.scene.empty();
  const Scene scene = is_of_scene ? scene_of(body, placed_body(p)) : Scene();
  const FittedCurves curves = read_curves(p.files.curves);
  const Model model =
      refine_body(curves, body, is_measured(p) ? Samples() : read_known(p.files.samples),
                  is_of_scene ? &scene : nullptr);
  write_model(p.files.model, model, model_attributes(curves, fingerprint));
}

std::string wanted_asset(const Pipeline& p) {
  ContentHash hash = stage_hash("asset").add_file(p.files.model);
  if (const std::string changes = json_of(p.changes).dump(); changes != "null") hash.add(changes);
  return hash.hex();
}
std::optional<std::string> stored_asset(const Pipeline& p) {
  return fs::is_directory(p.files.engine) ? stored_in_json(p.files.asset) : std::nullopt;
}
void make_asset(Pipeline& p, const std::string& fingerprint) {
  Model model = read_model(p.files.model);
  change_model(model, p.changes);
  const ExportRequest request{
      .fingerprint = fingerprint,
      .engine = p.files.engine,
      .tools = played_tools(p.scene),
      .changes = p.changes,
      .guessed_points = stored_in_hdf5(p.files.model, kGuessedAttribute).value_or("")};
  p.exported = export_model(model, p.files.asset, request);
}

// The fingerprint of the asset counts, for its own bytes change when it gets its statement.
std::string asset_inputs(const Pipeline& p) { return stored_in_json(p.files.asset).value_or(""); }
std::string wanted_statement(const Pipeline& p) {
  const Scene& scene = p.scene;
  ContentHash hash = stage_hash("statement");
  hash.add(canonical(scene, Stage::validate)).add(canonical(scene, Stage::simulate));
  if (scene.tool) hash.add(std::to_string(scene.tool->held_out));
  for (const ToolSection& tool : scene.stated)
    hash.add(canonical(tool)).add(std::to_string(tool.held_out));
  return hash.add(asset_inputs(p)).add_file(p.files.body).hex();
}
std::string wanted_recorded_statement(const Pipeline& p) {
  ContentHash hash = stage_hash("statement").add(asset_inputs(p)).add_file(p.files.samples);
  if (const auto held_out = held_out_path(p.files.samples); fs::exists(held_out))
    hash.add_file(held_out);
  return hash.hex();
}
std::optional<std::string> stored_statement(const Pipeline& p) {
  return has_statement(p.files.asset) ? stored_in_json(p.files.statement) : std::nullopt;
}
// The asset carries its statement from then on.
void write_statement(Pipeline& p, const std::string& fingerprint) {
  if (p.files.statement.empty()) return;
  put_statement(p.files.asset, to_asset_json(p.statement));
  p.statement.asset_bytes = fs::file_size(p.files.asset);
  write_file_atomically(p.files.statement, to_json(p.statement, fingerprint));
}
void make_statement(Pipeline& p, const std::string& fingerprint) {
  ValidateRequest request{p.jobs, p.files.rows, p.files.reference, p.resume};
  p.statement = validate_asset(p.files.asset, p.scene, p.body, request);
  write_statement(p, fingerprint);
}
void make_recorded_statement(Pipeline& p, const std::string& fingerprint) {
  ValidateRequest request{p.jobs, p.files.rows};
  FittedCurves curves;
  Body body;
  if (!p.files.curves.empty()) {
    request.curves = &(curves = read_curves(p.files.curves));
    body = read_body(p.files.body);
  }
  p.statement = validate_recordings(p.files.asset, read_recorded(p.files.samples), request,
                                    p.files.curves.empty() ? nullptr : &body);
  write_statement(p, fingerprint);
}

}  // namespace

StageFiles files_in(const fs::path& folder) {
  return {.body = folder / "body.h5",
          .samples = folder / "samples.h5",
          .curves = folder / "curves.h5",
          .model = folder / "model.h5",
          .asset = folder / "asset.palp",
          .statement = folder / "statement.json",
          .engine = folder / "engine",
          .rows = folder / "validation.csv",
          .reference = folder};
}

const StageRow kPrepareStage{"prepare", "prepare", &StageFiles::body, wanted_body,
                             make_body, nullptr,   nullptr,           load_prepared};
const StageRow kSimulateStage{"simulate",   "simulate",     &StageFiles::samples, wanted_samples,
                              make_samples, stored_samples, say_simulated};
const StageRow kFitStage{"fit", kCurvesToAsset, &StageFiles::curves, wanted_curves, make_curves};
const StageRow kRefineStage{"refine", kCurvesToAsset, &StageFiles::model, wanted_model, make_model};
const StageRow kExportStage{"export",     kCurvesToAsset, &StageFiles::asset,
                            wanted_asset, make_asset,     stored_asset};
const StageRow kValidateStage{"validate",       "validate",     &StageFiles::statement,
                              wanted_statement, make_statement, stored_statement};
const StageRow kImportStage{
    "import",          "import", &StageFiles::samples, wanted_recordings, make_recorded_samples,
    stored_recordings, nullptr,  load_imported};
const StageRow kRecordedBodyStage{"prepare", "prepare", &StageFiles::body, wanted_recorded_body,
                                  make_recorded_body};
const StageRow kRecordedValidateStage{"validate",
                                      "validate",
                                      &StageFiles::statement,
                                      wanted_recorded_statement,
                                      make_recorded_statement,
                                      stored_statement};

std::vector<const StageRow*> stages_of_scene() {
  return {&kPrepareStage, &kSimulateStage, &kFitStage,
          &kRefineStage,  &kExportStage,   &kValidateStage};
}
std::vector<const StageRow*> stages_of_recordings() {
  return {&kImportStage, &kRecordedBodyStage, &kFitStage,
          &kRefineStage, &kExportStage,       &kRecordedValidateStage};
}

void remake(const StageRow& stage, Pipeline& pipeline) {
  stage.make(pipeline, stage.wanted(pipeline));
}

void check_choices(const Scene& scene) {
  check_simulated(scene);
  check_pairs(scene);
  check_tools(scene);
}

namespace {

// Brings a stage's output up to date. Returns whether it was made.
bool bring_up_to_date(const StageRow& stage, Pipeline& pipeline, bool force) {
  const std::string output = (pipeline.files.*stage.output).string(),
                    wanted = stage.wanted(pipeline);
  const auto stored = stage.stored ? stage.stored(pipeline) : stored_in_hdf5(output);
  if (!force && stored == wanted) {
    say("{:<9}{} is up to date", stage.name, output);
    if (stage.load) stage.load(pipeline, wanted);
    return false;
  }
  say("{:<9}{}", stage.name, output);
  stage.make(pipeline, wanted);
  if (stage.say) stage.say(pipeline);
  return true;
}

// Returns how many stages were made. Stages with one summary share a line beside the log.
int run_stages(const std::vector<const StageRow*>& stages, Pipeline& pipeline, bool force,
               RunLog* log) {
  int done = 0;
  for (auto stage = stages.begin(); stage != stages.end();) {
    const char* const summary = (*stage)->summary;
    const int before = done;
    const double from_s = wall_seconds();
    for (; stage != stages.end() && (*stage)->summary == summary; ++stage)
      done += bring_up_to_date(**stage, pipeline, force);
    if (log != nullptr)
      log->say_summary(fmt::format(
          "{:<21}{}", summary, done == before ? "up to date" : in_words(wall_seconds() - from_s)));
  }
  return done;
}

}  // namespace

RunResult run(const RunRequest& request, RunLog* log) {
  const bool is_of_recordings = is_manifest(request.scene);
  if (is_of_recordings && request.quick)
    throw Error("--quick", "is of scenes, and " + request.scene + " is a manifest of recordings",
                "Leave it out: recordings are not simulated, and a run of them takes a minute.");
  OutputFolder folder(request.folder);
  Pipeline pipeline{
      .files = files_in(request.folder), .jobs = request.jobs, .resume = !request.force};
  const auto open_folder = [&] {
    folder.claim();
    if (log) log->open(fs::path(request.folder) / kRunLog, "palpate run " + request.scene);
  };
  if (is_of_recordings) {
    pipeline.import = {read_manifest(request.scene), pipeline.files.samples, request.jobs, true};
    check_recordings_exist(pipeline.import.manifest);
    pipeline.fit = pipeline.import.manifest.fit;
    open_folder();
  } else {
    pipeline.scene = open_scene(request.scene);
    if (request.quick) make_quick(pipeline.scene);
    check_choices(pipeline.scene);
    pipeline.fit = pipeline.scene.fit;
    pipeline.before_writing = open_folder;
  }
  RunResult result;
  result.stages_done = run_stages(is_of_recordings ? stages_of_recordings() : stages_of_scene(),
                                  pipeline, request.force, log);
  if (result.stages_done == 0) say("nothing to do: everything in {} is up to date", request.folder);
  const StageFiles& files = pipeline.files;
  result.statement =
      validation::parse_statement(read_whole_file(files.statement), files.statement.string());
  if (!pipeline.bad_experiments)
    pipeline.bad_experiments = list_bad_experiments(read_samples(files.samples));
  result.items_failed =
      *pipeline.bad_experiments + list_bad_points(read_curves(files.curves), request.quick);
  if (!is_of_recordings) result.items_failed += result.statement.reference_failures;
  return result;
}

}  // namespace palpate::tools
