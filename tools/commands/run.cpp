#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "libfit/assets/exporters.hpp"
#include "libfit/io/atomic_file.hpp"
#include "libfit/io/files/files.hpp"
#include "tools/command.hpp"
#include "tools/console.hpp"
#include "tools/outputs.hpp"
#include "tools/report/contents.hpp"
#include "tools/report/page.hpp"
#include "tools/scene/settings.hpp"
#include "tools/stages/export.hpp"
#include "tools/stages/fingerprint.hpp"
#include "tools/stages/fit.hpp"
#include "tools/stages/placement.hpp"
#include "tools/stages/prepare.hpp"
#include "tools/stages/shape.hpp"
#include "tools/stages/simulate.hpp"
#include "tools/stages/validate.hpp"

namespace palpate::tools {
namespace {

using namespace validation;

namespace fs = std::filesystem;

class Run final : public Command {
 public:
  explicit Run(Arguments& arguments) {
    arguments.positional("scene", scene_path_, "Scene to read, scene.toml");
    arguments.option("-o,--output", folder_, "Folder for all files of the run", true);
    arguments.option("--jobs", jobs_,
                     "Number of threads; 0 uses all cores; results do not depend on it");
    arguments.flag("--force", force_,
                   "Repeat every stage, also those whose inputs have not changed");
    arguments.flag("--quick", quick_,
                   "A first answer within minutes: few points and rows, and a statement of what "
                   "that is worth");
  }

  int run(Reply& reply) override {
    scene_ = open_scene(scene_path_);
    if (quick_) make_quick(scene_);
    check_choices(scene_);
    output_.emplace(folder_);
    prepare();
    simulate();
    fit();
    refine();
    export_asset();
    validate();
    return done(reply);
  }

 private:
  fs::path file(const char* name) const { return fs::path(folder_) / name; }

  // Whether a stage must be done; says so either way.
  bool is_stale(const char* stage, const fs::path& output, const std::optional<std::string>& stored,
                const std::string& wanted) {
    const bool is_fresh = !force_ && stored == wanted;
    if (is_fresh) {
      say("{:<9}{} is up to date", stage, output.string());
    } else {
      say("{:<9}{}", stage, output.string());
      ++stages_done_;
    }
    return !is_fresh;
  }

  void prepare() {
    const fs::path output = file("body.h5");
    const std::string wanted = body_fingerprint(scene_);
    const bool is_new = is_stale("prepare", output, stored_in_hdf5(output), wanted);
    body_ = is_new ? prepare_body(scene_, false) : read_body(output);
    check_experiments(scene_, body_);
    output_->claim();
    // A body that is up to date still says how experiments are made on it now.
    const Settings settings = settings_of(scene_);
    const ProbeSpec& probe = scene_.probe.spec;
    if (!is_new && canonical(settings) == canonical(body_.settings) && body_.probe &&
        canonical(probe) == canonical(*body_.probe))
      return;
    body_.settings = settings;
    body_.probe = probe;
    write_body(output, body_, {{kInputsAttribute, wanted}});
  }

  void simulate() {
    const fs::path output = file("samples.h5");
    const std::string wanted = samples_fingerprint(scene_, body_);
    const bool has_surface = keeps_surface(scene_, body_);
    const bool is_whole =
        (!scene_.experiments.placement || stored_in_hdf5(file("placed.h5")) == wanted) &&
        (!has_surface || stored_in_hdf5(surface_path(output)) == wanted);
    if (!is_stale("simulate", output, is_whole ? stored_in_hdf5(output) : std::nullopt, wanted))
      return;
    const SimulateRequest request{.jobs = jobs_,
                                  .output = output,
                                  .fingerprint = point_fingerprint(scene_, body_),
                                  .resume = !force_,
                                  .has_surface = has_surface};
    const Samples samples = simulate_scene(scene_, body_, request);
    say_force_errors(samples, scene_.experiments.force_tolerance);
    bad_experiments_ = list_bad_experiments(samples);
  }

  // The body with the test points that were simulated.
  fs::path placed_body() const {
    return file(scene_.experiments.placement ? "placed.h5" : "body.h5");
  }

  void fit() {
    const fs::path output = file("curves.h5");
    const std::string wanted = curves_fingerprint(scene_.fit, file("samples.h5"));
    if (!is_stale("fit", output, stored_in_hdf5(output), wanted)) return;
    const Body body = read_body(placed_body());
    const FittedCurves curves =
        fit_samples(read_samples(file("samples.h5")), scene_.fit, jobs_, &body);
    write_curves(output, curves, {{kInputsAttribute, wanted}});
  }

  void refine() {
    const fs::path output = file("model.h5");
    const fs::path samples = file("samples.h5");
    const bool has_surface = keeps_surface(scene_, body_);
    const std::string wanted = model_fingerprint(file("curves.h5"), placed_body(),
                                                 has_surface ? surface_path(samples) : fs::path());
    if (!is_stale("refine", output, stored_in_hdf5(output), wanted)) return;
    Model model = refine_body(read_curves(file("curves.h5")), read_body(placed_body()));
    if (has_surface) add_shape(model, read_with_surface(samples));
    write_model(output, model, {{kInputsAttribute, wanted}});
  }

  void export_asset() {
    const fs::path output = file("asset.palp"), picture = file("stiffness.vtu");
    const std::string wanted = asset_fingerprint(scene_.export_, file("model.h5"));
    const auto stored = fs::exists(picture) && fs::is_directory(file("engine"))
                            ? stored_in_asset(output)
                            : std::nullopt;
    if (!is_stale("export", output, stored, wanted)) return;
    const Model model = read_model(file("model.h5"));
    export_model(model, picture, "vtu", {});
    export_model(model, output, "palp",
                 {.settings = scene_.export_,
                  .fingerprint = wanted,
                  .statement = {},
                  .engine = file("engine")});
  }

  void validate() {
    const fs::path output = file("statement.json"), asset = file("asset.palp");
    const std::string made_from = asset_fingerprint(scene_.export_, file("model.h5"));
    const std::string wanted = statement_fingerprint(scene_, made_from, file("body.h5"));
    const auto stored = has_statement(asset) ? stored_in_json(output) : std::nullopt;
    if (!is_stale("validate", output, stored, wanted)) return;
    const Model model = read_model(file("model.h5"));
    const FittedCurves curves = read_curves(file("curves.h5"));
    Statement statement = validate_asset(asset, scene_, body_,
                                         {.settings = scene_.validate,
                                          .jobs = jobs_,
                                          .rows_csv = file("validation.csv"),
                                          .reference = folder_,
                                          .resume = !force_,
                                          .curves = &curves,
                                          .model = &model});
    export_model(model, asset, "palp",
                 {.settings = scene_.export_,
                  .fingerprint = made_from,
                  .statement = to_asset_json(statement),
                  .engine = {}});
    statement.asset_bytes = fs::file_size(asset);
    write_file_atomically(output, to_json(statement, wanted));
  }

  // The page to look at, where it is installed.
  void report() {
    const fs::path output = file("report.html");
    if (find_page()) {
      write_page(output, contents_of_folders({folder_}));
      say("open {} in a browser: errors, curves, and the body to poke", output.string());
    } else {
      say("`palpate report {} -o report.html` makes a page of it, once the page is built", folder_);
    }
  }

  int done(Reply& reply) {
    if (stages_done_ == 0) say("nothing to do: everything in {} is up to date", folder_);
    const fs::path output = file("statement.json");
    const Statement statement = parse_statement(read_whole_file(output), output.string());
    report();
    if (!bad_experiments_)
      bad_experiments_ = list_bad_experiments(read_samples(file("samples.h5")));
    const std::size_t failed =
        *bad_experiments_ + list_bad_points(read_curves(file("curves.h5")), quick_);
    reply.text = in_words(statement);
    reply.json =
        nlohmann::ordered_json{{"folder", folder_},
                               {"stages_done", stages_done_},
                               {"items_failed", failed + statement.reference_failures},
                               {"statement", nlohmann::ordered_json::parse(to_json(statement))}};
    return failed || statement.reference_failures ? kSomeFailed : kDone;
  }

  std::string scene_path_, folder_;
  int jobs_ = 0;
  bool force_ = false, quick_ = false;
  std::optional<OutputFolder> output_;
  Scene scene_;
  Body body_;
  int stages_done_ = 0;
  std::optional<std::size_t> bad_experiments_;  // listed already, while simulating
};

}  // namespace

std::unique_ptr<Command> declare_run(Arguments& arguments) {
  return std::make_unique<Run>(arguments);
}

}  // namespace palpate::tools
