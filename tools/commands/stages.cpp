#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "libfit/assets/asset_file.hpp"
#include "libfit/core/error.hpp"
#include "libfit/core/stated_error.hpp"
#include "libfit/core/units.hpp"
#include "libfit/io/atomic_file.hpp"
#include "libfit/io/files/files.hpp"
#include "tools/command.hpp"
#include "tools/console.hpp"
#include "tools/stages/body/prepare.hpp"
#include "tools/stages/import.hpp"
#include "tools/stages/model.hpp"
#include "tools/stages/stage_table.hpp"

namespace palpate::tools {
namespace {

// Marks the nuisance parameters that are estimated (FitOptions). names: with commas between.
std::array<bool, 3> nuisances_named(const std::string& names) {
  std::array<bool, 3> choice{};
  for (const std::string& name : parts_of_list(names)) {
    const auto row = std::ranges::find(kNuisanceNames, name);
    if (row == kNuisanceNames.end())
      throw Error("--free", "there is nothing called \"" + name + "\" to free",
                  "Use contact, bias, drift, or several with commas between.");
    choice[row - kNuisanceNames.begin()] = true;
  }
  return choice;
}

class Fit final : public Command {
 public:
  explicit Fit(Arguments& arguments) {
    arguments.positional("samples", samples_, "Samples to fit, samples.h5");
    arguments.output("-o,--output", output_, "curves.h5 to write", {kCurvesSchema.name});
    FitSection& section = stage_.fit;
    arguments.option("--degree", section.degree, "Degree of the curves, 1 to 4");
    arguments.option(
        "--pieces", section.pieces,
        "Number of pieces of every curve; 0 takes the fewest that held-out rows support");
    arguments.option("--family NAME", section.family,
                     "Curve family of docs/method.md, sections 2 and 17: rings or separable");
    arguments.option("--warm-start", warm_start_,
                     "Earlier curves.h5 whose bases and family are kept");
    arguments.option(
        "--free NAMES", frees_,
        "Nuisance parameters to estimate for each recording: any of contact,bias,drift");
    arguments.jobs(stage_.jobs);
  }

  int run(Reply& reply) override {
    const FitSection& section = stage_.fit;
    if (section.degree < 1 || section.degree > 4)
      throw Error("--degree", fmt::format("{} is no degree of a curve", section.degree),
                  "Use 1 to 4.");
    if (section.pieces < 0 || section.pieces > 256)
      throw Error("--pieces", fmt::format("there cannot be {} pieces", section.pieces),
                  "Use 1 to 256, or 0 to have the number chosen.");
    say("fit {}", samples_);
    std::optional<FittedCurves> earlier;
    if (!warm_start_.empty()) earlier = read_curves(warm_start_);
    stage_.files = {.samples = samples_, .curves = output_};
    stage_.fit_choices.warm_start = earlier ? &*earlier : nullptr;
    stage_.fit_choices.estimates = nuisances_named(frees_);
    kFitStage.make(stage_, !earlier && frees_.empty() ? kFitStage.wanted(stage_) : "");
    say("wrote {}", output_);
    const FittedCurves curves = read_curves(output_);
    const std::size_t bad = list_bad_points(curves);
    reply.json = nlohmann::ordered_json{{"points", curves.position.rows()},
                                        {"family", name_of(curves.curves.family)},
                                        {"without_curves_of_their_own", bad}};
    return bad ? kSomeFailed : kDone;
  }

 private:
  std::string samples_, output_, warm_start_, frees_;
  Pipeline stage_;
};

class Prepare final : public Command {
 public:
  explicit Prepare(Arguments& arguments) {
    arguments.positional("scene", scene_, "Scene to read, scene.toml");
    arguments.output("-o,--output", output_, "body.h5 to write", {kBodySchema.name});
    arguments.flag("--surface-only", stage_.surface_only,
                   "Make no volume mesh, which is enough for measured data and for open surfaces");
  }

  int run(Reply& reply) override {
    stage_.scene = open_scene(scene_);
    stage_.files.body = output_;
    say("prepare {}", scene_);
    kPrepareStage.make(stage_, stage_.surface_only ? "" : kPrepareStage.wanted(stage_));
    say("wrote {}", output_);
    const Body& body = stage_.body;
    reply.json = nlohmann::ordered_json{{"vertices", body.surface.vertices.rows()},
                                        {"tets", body.volume.tets.rows()},
                                        {"test_points", body.test_points.position.rows()}};
    return kDone;
  }

 private:
  std::string scene_, output_;
  Pipeline stage_;
};

constexpr NamedOutput kBeside[] = {{".held_out.h5", kSamplesSchema.name},
                                   {".signals.h5", kSignalsSchema.name},
                                   {".import.csv", "file,line,recording"},
                                   {".import.json", "{\"files\":"}};

class Import final : public Command {
 public:
  explicit Import(Arguments& arguments) {
    arguments.positional("manifest", manifest_,
                         "Manifest of the recordings and how to read them, manifest.toml");
    arguments.output(
        "-o,--output", output_,
        "samples.h5 to write, with samples.signals.h5, samples.import.csv and .json beside it",
        {kSamplesSchema.name});
    arguments.named_outputs(output_, kBeside);
    arguments.jobs(stage_.import.jobs);
    arguments.flag("--force", force_, "Replace files beside the output that Palpate did not write");
  }

  int run(Reply& reply) override {
    stage_.import.manifest = read_manifest(manifest_);
    stage_.import.output = output_;
    remake(kImportStage, stage_);
    reply.json = stage_.imported;
    return *stage_.bad_experiments > 0 ? kSomeFailed : kDone;
  }

 private:
  std::string manifest_, output_;
  bool force_ = false;  // Arguments looks for the second one
  Pipeline stage_;
};

class Refine final : public Command {
 public:
  explicit Refine(Arguments& arguments) {
    arguments.positional("curves", curves_, "Curves to interpolate, curves.h5");
    arguments.option("--body", body_, "body.h5 whose surface the curves are interpolated onto",
                     true);
    arguments.option("--samples", samples_,
                     "samples.h5 of the curves: what tells how contacts feel each other, and with "
                     "samples.surface.h5 beside it how the surface moves");
    arguments.output("-o,--output", output_, "model.h5 to write", {kModelSchema.name});
  }

  int run(Reply& reply) override {
    say("refine {}", curves_);
    Pipeline stage;
    stage.files = {.body = body_, .samples = samples_, .curves = curves_, .model = output_};
    remake(kRefineStage, stage);
    say("wrote {}", output_);
    const Model model = read_model(output_);
    const auto covered = std::count(model.is_covered.begin(), model.is_covered.end(), 1);
    reply.json =
        nlohmann::ordered_json{{"vertices", model.is_covered.size()}, {"covered", covered}};
    return kDone;
  }

 private:
  std::string curves_, body_, samples_, output_;
};

class Export final : public Command {
 public:
  explicit Export(Arguments& arguments) {
    arguments.positional("model", model_, "Model to export, model.h5; with --visual also an asset");
    arguments.output("-o,--output", output_, "asset.palp to write", {"palp"});
    arguments.option("--engine DIR", engine_, "Folder to copy the engine and its example into");
    arguments.option("--scene", scene_, "scene.toml whose [tool] is taken, as run takes it");
    arguments.option("--scale-stiffness FACTOR", stiffness_,
                     "Factor on all moduli of the body: forces go with it exactly");
    arguments.option("--scale-to", press_,
                     "Recorded press, t_s,x_m,y_m,z_m,force_N, to whose forces the stiffness is "
                     "scaled (least squares)");
    arguments.option("--friction MU", friction_,
                     "Friction of the tool in place of the probe's; see docs/after-a-run.md for "
                     "the error");
    arguments.option("--visual MESH", visual_,
                     "Mesh to draw in place of the surface: the asset moves its vertices, in their "
                     "order (palpate_place_visual)");
    arguments.option("--unit UNIT", unit_,
                     "Length unit of MESH, such as mm or \"110 mm\"; without it m, cm or mm, which "
                     "makes it as large as the body");
  }

  int run(Reply& reply) override {
    if (std::filesystem::path(output_).extension() != ".palp")
      throw Error(output_, "is no name of an asset, which is what export writes",
                  "Let it end in .palp.");
    Pipeline stage{.files = {.model = model_, .asset = output_, .engine = engine_}};
    if (!scene_.empty()) stage.scene = open_scene(scene_);
    if (visual_.empty() && !unit_.empty())
      throw Error("--unit", "is of a mesh", "Give --visual, too.");
    if (is_asset_file(model_)) return add_visual(model_, reply);
    if (std::error_code none; !engine_.empty() && std::filesystem::exists(engine_, none) &&
                              !std::filesystem::is_directory(engine_, none))
      throw Error("--engine", engine_ + " is a file", "Name a folder.");
    if (!friction_.empty()) stage.changes.friction = number("--friction", friction_, 0, 10);
    if (!stiffness_.empty())
      stage.changes.stiffness = number("--scale-stiffness", stiffness_, 1e-6, 1e6);
    if (!press_.empty()) stage.changes.stiffness = stiffness_of(press_, stage.changes);
    remake(kExportStage, stage);
    const ExportReport& report = stage.exported;
    reply.json = nlohmann::ordered_json{{"vertices", report.vertices},
                                        {"triangles", report.triangles},
                                        {"mean_vertices", report.mean_vertices},
                                        {"remarks", report.remarks}};
    if (const auto changes = json_of(stage.changes); !changes.is_null())
      reply.json["changed"] = changes;
    return visual_.empty() ? kDone : add_visual(output_, reply);
  }

 private:
  int add_visual(const std::string& asset, Reply& reply) const {
    if (asset == model_ &&
        (visual_.empty() || !(engine_ + scene_ + stiffness_ + press_ + friction_).empty()))
      throw Error(model_, "is an asset, which takes --visual alone",
                  "Export the model.h5 that it was made from.");
    reply.json["visual"] = put_visual(asset, visual_, output_, unit_);
    return kDone;
  }
  static double number(const char* option, const std::string& text, double low, double high) {
    double value = low - 1;
    const char* end = text.data() + text.size();
    if (const auto read = std::from_chars(text.data(), end, value);
        read.ptr != end || !(value >= low && value <= high))
      throw Error(option, "\"" + text + "\" is not in range",
                  fmt::format("Give a number from {:g} to {:g}.", low, high));
    return value;
  }
  double stiffness_of(const std::string& press, const ModelChanges& others) const {
    if (!stiffness_.empty())
      throw Error("--scale-to", "does not go with --scale-stiffness", "Give one of the two.");
    const PosePath path = read_pose_path(press);
    if (path.force_N.empty() || path.tools > 1 || path.orientation.rows() > 0)
      throw Error(press, "is no press of a tip with its forces",
                  "Give the columns t_s,x_m,y_m,z_m,force_N.");
    Model model = read_model(model_);
    change_model(model, others);
    const StiffnessFit fit = stiffness_of_press(model, path);
    say("  forces times {:.4g} +- {:.2g}; those of the press are then off by {} (rms)", fit.factor,
        fit.deviation, percent(fit.misfit));
    return fit.factor;
  }
  std::string model_, output_, engine_, scene_, stiffness_, press_, friction_, visual_, unit_;
};

class SurfaceCommand final : public Command {
 public:
  explicit SurfaceCommand(Arguments& arguments) {
    arguments.positional("samples", samples_,
                         "Samples whose contact points lie on the surface, samples.h5");
    arguments.output("-o,--output", output_, "Surface to write, body.obj, in mm",
                     {"# palpate surface"});
  }

  int run(Reply& reply) override {
    say("surface {}", samples_);
    if (const auto scan = scan_body_path(samples_); std::filesystem::exists(scan)) {
      const Surface found = read_body(scan).surface;  // found with the curves
      write_file_atomically(output_, obj_text(found));
      say("wrote {}: the surface that import found with the curves", output_);
      reply.json = nlohmann::ordered_json{{"vertices", found.vertices.rows()},
                                          {"triangles", found.triangles.rows()}};
      return kDone;
    }
    const ContactSurface made = surface_of_contacts(read_samples(samples_));
    write_file_atomically(output_, obj_text(made.surface));
    say("wrote {}", output_);
    std::vector<double> off_m;
    for (const double m : made.left_out_m)
      if (std::isfinite(m)) off_m.push_back(std::abs(m));
    reply.json = nlohmann::ordered_json{{"contacts", made.left_out_m.size()},
                                        {"is_height_field", made.is_height_field},
                                        {"vertices", made.surface.vertices.rows()},
                                        {"triangles", made.surface.triangles.rows()},
                                        {"spacing_m", made.spacing_m},
                                        {"reach_spacings", made.reach},
                                        {"uses_normals", made.uses_normals},
                                        {"left_out",
                                         {{"contacts", off_m.size()},
                                          {"median_m", stated_quantile(off_m, 0.5)},
                                          {"p95_m", stated_quantile(off_m, 0.95)},
                                          {"max_m", stated_quantile(off_m, 1)}}}};
    return kDone;
  }

 private:
  std::string samples_, output_;
};

}  // namespace

const CommandRow kFitCommand{"fit", "Identify response curves at the test points", declared<Fit>,
                             "Stages of a run", "fit samples.h5 -o curves.h5"};
const CommandRow kPrepareCommand{
    "prepare", "Repair a surface, place test points on it and fill it with tetrahedra",
    declared<Prepare>, "Stages of a run", "prepare organ.toml -o body.h5"};
const CommandRow kImportCommand{"import", "Turn the recordings that a manifest names into samples",
                                declared<Import>, "Recordings",
                                "import manifest.toml -o samples.h5"};
const CommandRow kRefineCommand{
    "refine", "Interpolate the curves onto every vertex of the fine surface", declared<Refine>,
    "Stages of a run", "refine curves.h5 --body body.h5 -o model.h5"};
const CommandRow kExportCommand{"export", "Write a model as a runtime asset", declared<Export>,
                                "Stages of a run", "export model.h5 -o asset.palp --engine engine"};
const CommandRow kSurfaceCommand{"surface", "Make a surface from where recordings touched the body",
                                 declared<SurfaceCommand>, "Recordings",
                                 "surface samples.h5 -o body.obj"};

}  // namespace palpate::tools
