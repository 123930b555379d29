#include <filesystem>
#include <optional>

#include "libfit/assets/exporters.hpp"
#include "libfit/io/atomic_file.hpp"
#include "libfit/io/files/body_file.hpp"
#include "libfit/io/files/curves_file.hpp"
#include "libfit/io/files/model_file.hpp"
#include "libfit/io/files/samples_file.hpp"
#include "tools/command.hpp"
#include "tools/console.hpp"
#include "tools/stages/check.hpp"
#include "tools/stages/export.hpp"
#include "tools/stages/fingerprint.hpp"
#include "tools/stages/fit.hpp"
#include "tools/stages/placement.hpp"
#include "tools/stages/prepare.hpp"
#include "tools/stages/refine.hpp"
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
  }

  int run() override {
    scene_ = read_scene(scene_path_);
    check_choices(scene_);
    prepare();
    simulate();
    fit();
    refine();
    export_asset();
    validate();
    return done();
  }

 private:
  fs::path file(const char* name) const { return fs::path(folder_) / name; }

  // Whether a stage must be done; says so either way.
  bool is_stale(const char* stage, const fs::path& output,
                const std::optional<std::string>& carried, const std::string& inputs) {
    const bool is_fresh = !force_ && carried == inputs;
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
    const std::string inputs = body_inputs(scene_);
    if (!is_stale("prepare", output, inputs_of_hdf5(output), inputs)) {
      check_experiments(scene_, read_body(output));
      return;
    }
    const Body body = prepare_body(scene_, false);
    check_experiments(scene_, body);
    fs::create_directories(folder_);
    write_body(output, body, {{kInputsAttribute, inputs}});
  }

  void simulate() {
    const fs::path output = file("samples.h5");
    const std::string inputs = samples_inputs(scene_, file("body.h5"));
    const bool is_placed =
        !scene_.experiments.placement || inputs_of_hdf5(file("placed.h5")) == inputs;
    if (!is_stale("simulate", output, is_placed ? inputs_of_hdf5(output) : std::nullopt, inputs))
      return;
    Body body = read_body(file("body.h5"));
    const std::string points = point_inputs(scene_, body);
    const SimulateRequest request{
        .jobs = jobs_, .output = output, .inputs = points, .resume = !force_};
    Samples samples;
    if (scene_.experiments.placement) {
      Placement placement = place_and_simulate(scene_, body, request);
      samples = std::move(placement.samples);
      body.test_points = std::move(placement.points);
      write_body(file("placed.h5"), body, {{kInputsAttribute, inputs}});
      write_rounds(file("placement.csv"), placement.rounds);
    } else {
      samples = simulate_body(scene_, body, request);
    }
    write_samples(output, samples, {{kInputsAttribute, inputs}, {kPointInputsAttribute, points}});
    remove_partial(output);
    say_force_errors(samples, scene_.experiments.force_tolerance);
    bad_experiments_ = list_bad_experiments(samples);
  }

  // The body with the test points that were simulated.
  fs::path placed_body() const {
    return file(scene_.experiments.placement ? "placed.h5" : "body.h5");
  }

  void fit() {
    const fs::path output = file("curves.h5");
    const std::string inputs = curves_inputs(scene_, file("samples.h5"));
    if (!is_stale("fit", output, inputs_of_hdf5(output), inputs)) return;
    const Samples samples = read_samples(file("samples.h5"));
    const Body body = read_body(placed_body());
    const FittedCurves curves =
        fit_samples(samples, scene_.fit, scene_.probe.spec.friction, jobs_, &body);
    write_curves(output, curves, {{kInputsAttribute, inputs}});
  }

  void refine() {
    const fs::path output = file("model.h5");
    const std::string inputs = model_inputs(file("curves.h5"), placed_body());
    if (!is_stale("refine", output, inputs_of_hdf5(output), inputs)) return;
    const Model model = refine_body(read_curves(file("curves.h5")), read_body(placed_body()));
    write_model(output, model, {{kInputsAttribute, inputs}});
  }

  void export_asset() {
    const fs::path output = file("asset.palp"), picture = file("stiffness.vtu");
    const std::string inputs = asset_inputs(scene_, file("model.h5"));
    const auto carried = fs::exists(picture) && fs::is_directory(file("engine"))
                             ? inputs_of_asset(output)
                             : std::nullopt;
    if (!is_stale("export", output, carried, inputs)) return;
    const Model model = read_model(file("model.h5"));
    export_model(model, picture, "vtu", {});
    export_model(model, output, "palp",
                 {.guard = scene_.export_.guard,
                  .inputs = inputs,
                  .statement = {},
                  .engine = file("engine")});
  }

  void validate() {
    const fs::path output = file("statement.json"), asset = file("asset.palp");
    const std::string made_from = asset_inputs(scene_, file("model.h5"));
    const std::string inputs = statement_inputs(scene_, made_from, file("body.h5"));
    const auto carried = has_statement(asset) ? inputs_of_json(output) : std::nullopt;
    if (!is_stale("validate", output, carried, inputs)) return;
    const Model model = read_model(file("model.h5"));
    const FittedCurves curves = read_curves(file("curves.h5"));
    Statement statement = validate_asset(asset, scene_, read_body(file("body.h5")),
                                         {.points = scene_.validate.points,
                                          .seed = scene_.validate.seed,
                                          .jobs = jobs_,
                                          .has_causes = scene_.validate.causes,
                                          .rows_csv = file("validation.csv"),
                                          .reference = folder_,
                                          .resume = !force_,
                                          .curves = &curves,
                                          .model = &model});
    export_model(model, asset, "palp",
                 {.guard = scene_.export_.guard,
                  .inputs = made_from,
                  .statement = to_asset_json(statement),
                  .engine = {}});
    statement.asset_bytes = fs::file_size(asset);
    write_file_atomically(output, to_json(statement, inputs));
  }

  int done() {
    if (stages_done_ == 0) say("nothing to do: everything in {} is up to date", folder_);
    const fs::path output = file("statement.json");
    const Statement statement = parse_statement(read_whole_file(output), output.string());
    fmt::print("{}\n", in_words(statement));
    if (!bad_experiments_)
      bad_experiments_ = list_bad_experiments(read_samples(file("samples.h5")));
    const std::size_t failed = *bad_experiments_ + list_bad_points(read_curves(file("curves.h5")));
    return failed || statement.reference_failures ? kSomeFailed : kDone;
  }

  std::string scene_path_, folder_;
  int jobs_ = 0;
  bool force_ = false;
  Scene scene_;
  int stages_done_ = 0;
  std::optional<std::size_t> bad_experiments_;  // listed already, while simulating
};

}  // namespace

std::unique_ptr<Command> declare_run(Arguments& arguments) {
  return std::make_unique<Run>(arguments);
}

}  // namespace palpate::tools
