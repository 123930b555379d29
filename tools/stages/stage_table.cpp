#include "tools/stages/stage_table.hpp"

#include <nlohmann/json.hpp>

#include "libfit/assets/exporters.hpp"
#include "libfit/io/atomic_file.hpp"
#include "libfit/io/files/files.hpp"
#include "tools/console.hpp"
#include "tools/scene/canonical.hpp"
#include "tools/stages/body/open_scene.hpp"
#include "tools/stages/body/prepare.hpp"
#include "tools/stages/fingerprint.hpp"
#include "tools/stages/import.hpp"
#include "tools/stages/refine.hpp"
#include "tools/stages/samples/experiment_table.hpp"
#include "tools/stages/samples/placement.hpp"
#include "tools/stages/samples/simulate.hpp"
#include "tools/stages/validate.hpp"

namespace palpate::tools {
namespace {

namespace fs = std::filesystem;

constexpr const char* kCurvesToAsset = "fit, refine, export";

Attributes inputs_of(const std::string& fingerprint) {
  return fingerprint.empty() ? Attributes{} : Attributes{{kInputsAttribute, fingerprint}};
}

template <fs::path StageFiles::*file>
std::optional<std::string> stored_in(const Pipeline& p) {
  return stored_in_hdf5(p.files.*file);
}

// The body with the test points that were simulated.
fs::path placed_body(const Pipeline& p) {
  return p.scene.experiments.placement ? p.files.samples.parent_path() / "placed.h5" : p.files.body;
}

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

void make_recorded_body(Pipeline& p, const std::string& fingerprint) {
  const Body body = body_of_recordings(p.manifest, read_samples(p.files.samples));
  if (!p.manifest.surface)
    write_file_atomically(fs::path(p.files.body).replace_extension(".obj"), obj_text(body.surface));
  write_body(p.files.body, body, inputs_of(fingerprint));
}

// Where points placed themselves: whether a press of another tool buys more than one more point.
void say_worth(const Pipeline& p, const fit::RadiusReport& radius) {
  if (!p.scene.experiments.placement || (p.scene.stated.empty() && radius.points == 0)) return;
  const double point_p95 = last_predicted_p95(p.files.samples.parent_path() / "placement.csv");
  if (radius.points == 0)
    return say(
        "  worth    points are predicted to {} (p95), and the other {} by theory alone: a "
        "few presses of one ([[experiments.probe]]) show how far it holds",
        percent(point_p95), counted(std::ssize(p.scene.stated), "tool", "tools"));
  const bool is_tool = radius.left_out.p95 > point_p95;
  say("  worth    points are predicted to {} (p95), presses of another tool at points where it "
      "was not pressed to {}: {}",
      percent(point_p95), percent(radius.left_out.p95),
      is_tool ? "a larger `points` of [[experiments.probe]] lowers the error more than test points"
              : "more test points lower the error more than presses of the other tool");
}
void make_curves(Pipeline& p, const std::string& fingerprint) {
  fit::RadiusReport radius;
  const FittedCurves curves =
      fit_samples(read_samples(p.files.samples), p.fit, p.jobs, p.fit_choices, &radius);
  say_worth(p, radius);
  write_curves(p.files.curves, curves, inputs_of(fingerprint));
}

std::string wanted_model(const Pipeline& p) {
  return model_fingerprint(p.files.curves, placed_body(p),
                           p.manifest.items.empty() ? p.files.samples : fs::path());
}
void make_model(Pipeline& p, const std::string& fingerprint) {
  const Body body = read_body(placed_body(p));
  const bool is_of_scene = !body.scene.empty();
  const Scene scene = is_of_scene ? scene_of(body, placed_body(p)) : Scene();
  const FittedCurves curves = read_curves(p.files.curves);
  const bool is_measured = p.files.samples.empty() || !p.manifest.items.empty();
  const Model model =
      refine_body(curves, body, is_measured ? Samples() : read_known(p.files.samples),
                  is_of_scene ? &scene : nullptr);
  write_model(p.files.model, model, model_attributes(curves, fingerprint));
}

std::optional<std::string> stored_asset(const Pipeline& p) {
  return fs::exists(p.files.picture) && fs::is_directory(p.files.engine)
             ? stored_in_asset(p.files.asset)
             : std::nullopt;
}
void make_asset(Pipeline& p, const std::string& fingerprint) {
  const Model model = read_model(p.files.model);
  if (!p.files.picture.empty()) export_model(model, p.files.picture, "vtu", {});
  const ExportRequest request{
      .fingerprint = fingerprint,
      .map_depth_m = p.map_depth_m,
      .engine = p.files.engine,
      .tools = played_tools(p.scene),
      .guessed_points = stored_in_hdf5(p.files.model, kGuessedAttribute).value_or("")};
  p.exported = export_model(model, p.files.asset,
                            p.exported_format.empty() ? "palp" : p.exported_format, request);
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
  FittedCurves curves;
  Model model;
  if (!p.files.curves.empty()) {
    request.curves = &(curves = read_curves(p.files.curves));
    request.model = &(model = read_model(p.files.model));
  }
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
          .picture = folder / "stiffness.vtu",
          .engine = folder / "engine",
          .rows = folder / "validation.csv",
          .reference = folder};
}

const StageRow kPrepareStage{"prepare",
                             "prepare",
                             &StageFiles::body,
                             [](const Pipeline& p) { return body_fingerprint(p.scene); },
                             stored_in<&StageFiles::body>,
                             make_body,
                             nullptr,
                             load_prepared};
const StageRow kSimulateStage{
    "simulate",           "simulate",
    &StageFiles::samples, [](const Pipeline& p) { return samples_fingerprint(p.scene, p.body); },
    stored_samples,       make_samples,
    say_simulated};
const StageRow kFitStage{
    "fit",
    kCurvesToAsset,
    &StageFiles::curves,
    [](const Pipeline& p) { return curves_fingerprint(p.fit, p.files.samples); },
    stored_in<&StageFiles::curves>,
    make_curves};
const StageRow kRefineStage{
    "refine",  kCurvesToAsset, &StageFiles::model, wanted_model, stored_in<&StageFiles::model>,
    make_model};
const StageRow kExportStage{
    "export",           kCurvesToAsset,
    &StageFiles::asset, [](const Pipeline& p) { return asset_fingerprint(p.files.model); },
    stored_asset,       make_asset};
const StageRow kValidateStage{"validate",
                              "validate",
                              &StageFiles::statement,
                              [](const Pipeline& p) {
                                return statement_fingerprint(
                                    p.scene, stored_in_asset(p.files.asset).value_or(""),
                                    p.files.body);
                              },
                              stored_statement,
                              make_statement};
const StageRow kImportStage{
    "import",
    "import",
    &StageFiles::samples,
    [](const Pipeline& p) { return recorded_samples_fingerprint(p.import); },
    stored_recordings,
    make_recorded_samples,
    nullptr,
    load_imported};
const StageRow kRecordedBodyStage{"prepare",
                                  "prepare",
                                  &StageFiles::body,
                                  [](const Pipeline& p) {
                                    return recorded_body_fingerprint(p.files.samples,
                                                                     p.manifest.surface);
                                  },
                                  stored_in<&StageFiles::body>,
                                  make_recorded_body};
const StageRow kRecordedValidateStage{"validate",
                                      "validate",
                                      &StageFiles::statement,
                                      [](const Pipeline& p) {
                                        return recorded_statement_fingerprint(
                                            stored_in_asset(p.files.asset).value_or(""),
                                            p.files.samples);
                                      },
                                      stored_statement,
                                      make_recorded_statement};

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

}  // namespace palpate::tools
