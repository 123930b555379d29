#include <fmt/core.h>

#include "libfit/assets/asset_file.hpp"
#include "libfit/core/error.hpp"
#include "libfit/io/files/files.hpp"
#include "tools/command.hpp"
#include "tools/console.hpp"
#include "tools/outputs.hpp"
#include "tools/stages/body/prepare.hpp"
#include "tools/stages/import.hpp"
#include "tools/stages/stage_table.hpp"
#include "tools/stages/validate.hpp"

namespace palpate::tools {
namespace {

using namespace validation;

constexpr NamedOutput kReference[] = {{"reference.h5", kSamplesSchema.name}};

class Validate final : public Command {
 public:
  explicit Validate(Arguments& arguments) {
    arguments.positional("asset", asset_, "Asset to validate, asset.palp");
    arguments.positional("scene", scene_,
                         "Scene that the reference simulates, scene.toml; or samples.h5 of "
                         "recordings, some of which were held out of the fit; or manifest.toml of "
                         "recordings that the asset was not made from");
    arguments.option("--points", points_,
                     "Number of held-out contact points; 0: as the scene's [validate] has it");
    arguments.option("--seed", seed_,
                     "Seed of the contact points and paths; 0: as the scene's [validate] has it");
    arguments.jobs(stage_.jobs);
    arguments.option("--body", body_,
                     "body.h5 of the scene; without it the body is prepared again");
    arguments.output("--rows", rows_, "CSV to write with every compared row", {"point,path,step"},
                     false);
    arguments.option("--curves", curves_,
                     "curves.h5 that the asset was made from: of recordings, with --body, states "
                     "what points left out show");
    arguments.option("--reference DIR", reference_,
                     "Folder that keeps the simulated rows, for a validation that was stopped and "
                     "for the next one; by default ASSET.SCENE.reference beside the asset");
    arguments.named_outputs(reference_, kReference);
    arguments.option("--samples", samples_,
                     "samples.h5 that the asset was made from, with whose rows a manifest's rivals "
                     "answer; by default the one beside the asset");
    arguments.flag(
        "--no-causes", no_causes_,
        "Do not split the error by cause, which needs simulations at the contact points");
    arguments.output("--statement", statement_,
                     "statement.json to write; the asset carries the statement from then on, as "
                     "after run; of a scene it needs --body",
                     {"{\"force_error\":"}, false);
  }

  int run(Reply& reply) override {
    if (kind_of_file(scene_) == kSamplesSchema.name) return compare_recordings(reply);
    if (is_manifest(scene_)) return compare_later_recordings(reply);
    refuse_options({{"--samples", !samples_.empty()}},
                   "is of a manifest, and " + scene_ + " is none");
    refuse_options({{"--curves", !curves_.empty()}},
                   "is of recordings, and " + scene_ + " is a scene");
    if (points_ < 0)
      throw Error("--points", "there must be at least one contact point",
                  "Give a positive number.");
    if (!statement_.empty() && body_.empty())
      throw Error("--statement", "says what the body is by its file, and there is none",
                  "Give --body body.h5, too.");
    Scene& scene = stage_.scene;
    scene = open_scene(scene_);
    if (points_ != 0) scene.validate.points = points_;
    if (seed_ != 0) scene.validate.seed = seed_;
    if (no_causes_) scene.validate.causes = false;
    check_choices(scene);
    const RemovedIfEmpty made{keep_reference()};
    if (body_.empty()) {
      const Surface surface = palpate::surface_of(read_asset_file(asset_).asset());
      stage_.body = prepare_body(scene, false, &surface);
    } else {
      stage_.body = read_body(body_);
    }
    check_experiments(scene, stage_.body);
    make_statement(kValidateStage, reply);
    return stage_.statement.reference_failures ? kSomeFailed : kDone;
  }

 private:
  // A validation that is refused leaves no folder behind.
  struct RemovedIfEmpty {
    std::filesystem::path folder;
    ~RemovedIfEmpty() {
      std::error_code ignored;
      std::filesystem::remove(folder, ignored);
    }
  };

  // What is simulated is kept beside the asset where nothing else is said, so that a validation
  // that was stopped goes on. Returns the folder that was made, if one was.
  std::filesystem::path keep_reference() {
    namespace fs = std::filesystem;
    stage_.files.reference = reference_;
    if (reference_.empty())
      stage_.files.reference =
          fs::path(asset_).replace_extension(fs::path(scene_).stem().string() + ".reference");
    std::error_code failed;
    const bool is_made = fs::create_directories(stage_.files.reference, failed);
    if (!failed) {
      check_named_outputs(stage_.files.reference, kReference, false);
      return is_made ? stage_.files.reference : "";
    }
    if (!reference_.empty())
      throw Error(reference_, "cannot be made: " + failed.message(),
                  "Choose a folder that can be written.");
    warn("{}: cannot be made ({}), so nothing is kept of what is simulated",
         stage_.files.reference.string(), failed.message());
    stage_.files.reference.clear();
    return {};
  }

  // Recordings that the asset was not made from, all of them held out.
  int compare_later_recordings(Reply& reply) {
    refuse_simulated();
    refuse_options({{"--curves", !curves_.empty()},
                    {"--body", !body_.empty()},
                    {"--statement", !statement_.empty()}},
                   "is of what the asset was made from, and " + scene_ + " has other recordings");
    const std::filesystem::path beside =
        std::filesystem::path(asset_).replace_filename("samples.h5");
    if (samples_.empty() && std::filesystem::exists(beside)) samples_ = beside.string();
    const AssetFile file = read_asset_file(asset_);
    ImportRequest request;
    request.manifest = read_manifest(scene_);
    if (std::filesystem::exists(scan_curves_path(samples_))) read_as_passes(request.manifest);
    request.jobs = stage_.jobs, request.asset = &file.asset(), request.earlier = samples_;
    const ReadRecordings later = read_recordings(request);
    stage_.statement = validate_recordings(
        asset_, {samples_.empty() ? Samples() : read_samples(samples_), later.assembled.samples},
        {.jobs = stage_.jobs, .rows_csv = rows_});
    reply = {in_words(stage_.statement), nlohmann::ordered_json::parse(to_json(stage_.statement))};
    reply.json["notes"] = later.assembled.notes;
    return stage_.statement.all.rows == 0 || later.assembled.failed() > 0 ? kSomeFailed : kDone;
  }

  void refuse_simulated() const {
    refuse_options({{"--points", points_ != 0},
                    {"--seed", seed_ != 0},
                    {"--reference", !reference_.empty()},
                    {"--no-causes", no_causes_}},
                   "is of a simulated reference, and " + scene_ + " holds recordings");
  }

  int compare_recordings(Reply& reply) {
    refuse_simulated();
    refuse_options({{"--samples", !samples_.empty()}},
                   "is of a manifest, and " + scene_ + " is none");
    if (curves_.empty() != body_.empty())
      throw Error(curves_.empty() ? "--curves" : "--body", "is missing beside the other one",
                  "Give both, for what points left out show, or none.");
    stage_.files.samples = scene_;
    make_statement(kRecordedValidateStage, reply);
    return stage_.statement.all.rows == 0 ? kSomeFailed : kDone;
  }

  void make_statement(const StageRow& stage, Reply& reply) {
    StageFiles& files = stage_.files;
    files.asset = asset_, files.body = body_, files.rows = rows_;
    files.curves = curves_, files.statement = statement_;
    stage.make(stage_, statement_.empty() ? "" : stage.wanted(stage_));
    reply = {in_words(stage_.statement), nlohmann::ordered_json::parse(to_json(stage_.statement))};
  }

  std::string asset_, scene_, body_, rows_, curves_, reference_, statement_, samples_;
  int points_ = 0, seed_ = 0;
  Pipeline stage_;
  bool no_causes_ = false;
};

}  // namespace

const CommandRow kValidateCommand{
    "validate", "Compare an asset with fresh simulated experiments, or with recordings",
    declared<Validate>, "Stages of a run", "validate asset.palp organ.toml"};

}  // namespace palpate::tools
