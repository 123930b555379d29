#include "tools/stages/run.hpp"

#include <filesystem>
#include <optional>

#include "libfit/assets/exporters.hpp"
#include "libfit/core/text.hpp"
#include "libfit/io/atomic_file.hpp"
#include "libfit/io/files/files.hpp"
#include "tools/console.hpp"
#include "tools/crash_report.hpp"
#include "tools/outputs.hpp"
#include "tools/scene/canonical.hpp"
#include "tools/stages/body/open_scene.hpp"
#include "tools/stages/body/prepare.hpp"
#include "tools/stages/check_choices.hpp"
#include "tools/stages/export.hpp"
#include "tools/stages/fingerprint.hpp"
#include "tools/stages/fit.hpp"
#include "tools/stages/import.hpp"
#include "tools/stages/recorded_body.hpp"
#include "tools/stages/refine.hpp"
#include "tools/stages/samples/compound.hpp"
#include "tools/stages/samples/placement.hpp"
#include "tools/stages/samples/simulate.hpp"
#include "tools/stages/validate.hpp"

namespace palpate::tools {
namespace {

using namespace validation;

namespace fs = std::filesystem;

// A folder with the files of stages.
class FolderRun {
 protected:
  FolderRun(const RunRequest& request, RunLog* log)
      : request_(request), output_(request.folder), log_(log) {}

  fs::path file(const char* name) const { return fs::path(request_.folder) / name; }

  // A line beside the log: how long stages took, or that there was nothing to do.
  template <class Work>
  void timed(const char* stages, Work&& work) {
    const int done = result_.stages_done;
    const double began_s = wall_seconds();
    work();
    if (log_ != nullptr)
      log_->say_summary(fmt::format(
          "{:<21}{}", stages,
          result_.stages_done == done ? "up to date" : in_words(wall_seconds() - began_s)));
  }

  // Whether a stage must be done; says so either way.
  bool is_stale(const char* stage, const fs::path& output, const std::optional<std::string>& stored,
                const std::string& wanted) {
    set_stage(stage);
    const bool is_fresh = !request_.force && stored == wanted;
    if (is_fresh) {
      say("{:<9}{} is up to date", stage, output.string());
    } else {
      say("{:<9}{}", stage, output.string());
      ++result_.stages_done;
    }
    return !is_fresh;
  }

  void refine_and_write(const Body& body, const Samples& samples, const Scene* scene,
                        const std::string& wanted) {
    const FittedCurves curves = read_curves(file("curves.h5"));
    const Model model = refine_body(curves, body, samples, scene);
    write_model(file("model.h5"), model, model_attributes(curves, wanted));
  }

  // tools: of the scene, put into the asset.
  void export_asset(std::vector<NamedTool> tools) {
    const fs::path output = file("asset.palp"), picture = file("stiffness.vtu");
    const std::string wanted = asset_fingerprint(file("model.h5"));
    const auto stored = fs::exists(picture) && fs::is_directory(file("engine"))
                            ? stored_in_asset(output)
                            : std::nullopt;
    if (!is_stale("export", output, stored, wanted)) return;
    const Model model = read_model(file("model.h5"));
    export_model(model, picture, "vtu", {});
    ExportRequest request{.fingerprint = wanted, .engine = file("engine")};
    request.guessed_points = stored_in_hdf5(file("model.h5"), kGuessedAttribute).value_or("");
    request.tools = std::move(tools);
    export_model(model, output, "palp", request);
  }

  void read_result() {
    if (result_.stages_done == 0)
      say("nothing to do: everything in {} is up to date", request_.folder);
    const fs::path output = file("statement.json");
    result_.statement = parse_statement(read_whole_file(output), output.string());
  }

  RunRequest request_;
  OutputFolder output_;
  RunLog* log_;
  RunResult result_;
};

class StageRun : FolderRun {
 public:
  StageRun(const RunRequest& request, RunLog* log) : FolderRun(request, log) {}

  RunResult run() {
    timed("prepare", [&] {
      scene_ = open_scene(request_.scene);
      if (request_.quick) make_quick(scene_);
      check_choices(scene_);
      prepare();
    });
    timed("simulate", [&] { simulate(); });
    timed("fit, refine, export", [&] {
      fit();
      refine();
      export_asset(played_tools(scene_));
    });
    timed("validate", [&] { validate(); });
    return result();
  }

 private:
  void prepare() {
    const fs::path output = file("body.h5");
    const std::string wanted = body_fingerprint(scene_);
    const bool is_new = is_stale("prepare", output, stored_in_hdf5(output), wanted);
    body_ = is_new ? prepare_body(scene_, false) : read_body(output);
    check_experiments(scene_, body_);
    output_.claim();
    if (log_) log_->open(file(kRunLog), "palpate run " + request_.scene);
    // A body that is up to date still says how experiments are made on it now.
    if (!store_scene(scene_, body_) && !is_new) return;
    write_body(output, body_, {{kInputsAttribute, wanted}});
  }

  void simulate() {
    const fs::path output = file("samples.h5");
    const std::string wanted = samples_fingerprint(scene_, body_);
    const Eigen::Index columns = surface_columns(scene_, body_);
    const bool is_whole =
        (!scene_.experiments.placement || stored_in_hdf5(file("placed.h5")) == wanted) &&
        (columns == 0 || stored_in_hdf5(surface_path(output)) == wanted);
    if (!is_stale("simulate", output, is_whole ? stored_in_hdf5(output) : std::nullopt, wanted))
      return;
    const SimulateRequest request{.jobs = request_.jobs,
                                  .output = output,
                                  .fingerprint = point_fingerprint(scene_, body_),
                                  .tool = tool_fingerprint(scene_, scene_.pressed),
                                  .resume = !request_.force,
                                  .surface_columns = columns};
    const Samples samples = simulate_scene(scene_, body_, request);
    say_force_errors(samples, scene_.experiments.force_tolerance);
    bad_experiments_ = list_bad_experiments(samples);
  }

  // The body with the test points that were simulated.
  fs::path placed_body() const {
    return file(scene_.experiments.placement ? "placed.h5" : "body.h5");
  }

  void fit() {
    const fs::path output = file("curves.h5"), samples = file("samples.h5");
    const std::string wanted = curves_fingerprint(scene_.fit, samples);
    if (!is_stale("fit", output, stored_in_hdf5(output), wanted)) return;
    const Body body = read_body(placed_body());
    fit::RadiusReport radius;
    const FittedCurves curves =
        fit_samples(read_samples(samples), scene_.fit, request_.jobs, {}, {}, nullptr, &radius);
    say_worth(radius);
    write_curves(output, curves, {{kInputsAttribute, wanted}});
  }

  // Where points placed themselves: whether a press of another tool buys more than one more point.
  void say_worth(const fit::RadiusReport& radius) const {
    if (!scene_.experiments.placement || (scene_.stated.empty() && radius.points == 0)) return;
    const double point_p95 = last_predicted_p95(file("placement.csv"));
    if (radius.points == 0)
      return say(
          "  worth    points are predicted to {} (p95), and the other {} by theory alone: a "
          "few presses of one ([[experiments.probe]]) show how far it holds",
          percent(point_p95),
          counted(static_cast<std::int64_t>(scene_.stated.size()), "tool", "tools"));
    const bool is_tool = radius.left_out.p95 > point_p95;
    say("  worth    points are predicted to {} (p95), presses of another tool at points where it "
        "was not pressed to {}: {}",
        percent(point_p95), percent(radius.left_out.p95),
        is_tool
            ? "a larger `points` of [[experiments.probe]] lowers the error more than test points"
            : "more test points lower the error more than presses of the other tool");
  }

  void refine() {
    const fs::path output = file("model.h5"), samples = file("samples.h5");
    const std::string wanted = model_fingerprint(file("curves.h5"), placed_body(), samples);
    if (!is_stale("refine", output, stored_in_hdf5(output), wanted)) return;
    refine_and_write(read_body(placed_body()), read_known(samples), &scene_, wanted);
  }

  void validate() {
    const fs::path output = file("statement.json"), asset = file("asset.palp");
    const std::string made_from = asset_fingerprint(file("model.h5"));
    const std::string wanted = statement_fingerprint(scene_, made_from, file("body.h5"));
    const auto stored = has_statement(asset) ? stored_in_json(output) : std::nullopt;
    if (!is_stale("validate", output, stored, wanted)) return;
    const Model model = read_model(file("model.h5"));
    const FittedCurves curves = read_curves(file("curves.h5"));
    state_asset(asset, scene_, body_,
                {.settings = scene_.validate,
                 .jobs = request_.jobs,
                 .rows_csv = file("validation.csv"),
                 .reference = request_.folder,
                 .resume = !request_.force,
                 .curves = &curves,
                 .model = &model},
                file("body.h5"), output);
  }

  RunResult result() {
    read_result();
    if (!bad_experiments_)
      bad_experiments_ = list_bad_experiments(read_samples(file("samples.h5")));
    result_.items_failed = *bad_experiments_ + result_.statement.reference_failures +
                           list_bad_points(read_curves(file("curves.h5")), request_.quick);
    return result_;
  }

  Scene scene_;
  Body body_;
  std::optional<std::size_t> bad_experiments_;  // listed already, while simulating
};

class RecordingsRun : FolderRun {
 public:
  RecordingsRun(const RunRequest& request, RunLog* log) : FolderRun(request, log) {}

  RunResult run() {
    // What is wrong is said before the folder is made.
    if (request_.quick)
      throw Error("--quick", "is of scenes, and " + request_.scene + " is a manifest of recordings",
                  "Leave it out: recordings are not simulated, and a run of them takes a minute.");
    manifest_ = read_manifest(request_.scene);
    check_recordings_exist(manifest_);
    output_.claim();
    if (log_) log_->open(file(kRunLog), "palpate run " + request_.scene);
    timed("import", [&] { import(); });
    timed("prepare", [&] { prepare(); });
    timed("fit, refine, export", [&] {
      fit();
      refine();
      export_asset({});
    });
    timed("validate", [&] { validate(); });
    read_result();
    result_.items_failed = refused_ + list_bad_points(read_curves(file("curves.h5")));
    return result_;
  }

 private:
  void import() {
    const ImportRequest request{.manifest = request_.scene,
                                .output = file("samples.h5"),
                                .jobs = request_.jobs,
                                .holds_out = true};
    const ReadRecordings read = read_recordings(request);
    refused_ = read.assembled.failed();
    const std::string wanted = recorded_samples_fingerprint(read);
    if (is_stale("import", request.output, stored_in_hdf5(request.output), wanted))
      write_recordings(request, read);
  }

  void prepare() {
    const fs::path output = file("body.h5");
    const std::string wanted = recorded_body_fingerprint(file("samples.h5"), manifest_.surface);
    if (!is_stale("prepare", output, stored_in_hdf5(output), wanted)) return;
    const Body body = body_of_recordings(manifest_, read_samples(file("samples.h5")));
    if (!manifest_.surface) write_file_atomically(file("body.obj"), obj_text(body.surface));
    write_body(output, body, {{kInputsAttribute, wanted}});
  }

  void fit() {
    const fs::path output = file("curves.h5"), samples = file("samples.h5");
    const std::string wanted = curves_fingerprint(manifest_.fit, samples);
    if (!is_stale("fit", output, stored_in_hdf5(output), wanted)) return;
    write_curves(output, fit_samples(read_samples(samples), manifest_.fit, request_.jobs),
                 {{kInputsAttribute, wanted}});
  }

  void refine() {
    const fs::path output = file("model.h5");
    const std::string wanted = model_fingerprint(file("curves.h5"), file("body.h5"), {});
    if (is_stale("refine", output, stored_in_hdf5(output), wanted))
      refine_and_write(read_body(file("body.h5")), {}, nullptr, wanted);
  }

  void validate() {
    const fs::path output = file("statement.json"), asset = file("asset.palp");
    const std::string wanted =
        recorded_statement_fingerprint(asset_fingerprint(file("model.h5")), file("samples.h5"));
    const auto stored = has_statement(asset) ? stored_in_json(output) : std::nullopt;
    if (!is_stale("validate", output, stored, wanted)) return;
    const FittedCurves curves = read_curves(file("curves.h5"));
    const Body body = read_body(file("body.h5"));
    ValidateRequest request;
    request.jobs = request_.jobs;
    request.rows_csv = file("validation.csv");
    request.curves = &curves;
    state_recordings(asset, file("samples.h5"), request, &body, output);
  }

  Manifest manifest_;
  std::size_t refused_ = 0;
};

}  // namespace

RunResult run_stages(const RunRequest& request, RunLog* log) {
  return StageRun(request, log).run();
}
RunResult run_recordings(const RunRequest& request, RunLog* log) {
  return RecordingsRun(request, log).run();
}

}  // namespace palpate::tools
