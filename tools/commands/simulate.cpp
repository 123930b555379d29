#include <filesystem>
#include <nlohmann/json.hpp>

#include "libfem/solve/experiments/simulate.hpp"
#include "libfit/core/error.hpp"
#include "libfit/io/csv/tables.hpp"
#include "libfit/io/files/files.hpp"
#include "tools/command.hpp"
#include "tools/console.hpp"
#include "tools/outputs.hpp"
#include "tools/scene/canonical.hpp"
#include "tools/stages/body/prepare.hpp"
#include "tools/stages/fingerprint.hpp"
#include "tools/stages/samples/experiment_table.hpp"
#include "tools/stages/samples/shards.hpp"
#include "tools/stages/stage_table.hpp"

namespace palpate::tools {
namespace {

constexpr NamedOutput kBeside[] = {{".surface.h5", kSurfaceSchema.name},
                                   {"../placed.h5", kBodySchema.name},
                                   {"../placement.csv", "points,new_points"}};

namespace fs = std::filesystem;

int say_samples(Pipeline& stage, Reply& reply) {
  const Eigen::Index rows = stage.samples.rows(), points = stage.samples.points();
  say("wrote {}: {} rows at {} points", stage.files.samples.string(), rows, points);
  kSimulateStage.say(stage);
  reply.json = nlohmann::ordered_json{
      {"rows", rows}, {"points", points}, {"experiments_not_good", *stage.bad_experiments}};
  return *stage.bad_experiments ? kSomeFailed : kDone;
}

class Simulate final : public Command {
 public:
  explicit Simulate(Arguments& arguments) {
    arguments.positional("input", input_, "Scene to read, scene.toml, or the body.h5 made from it");
    arguments.output("-o,--output", output_, "samples.h5 to write", {kSamplesSchema.name});
    arguments.named_outputs(output_, kBeside);
    arguments.option("--points", points_,
                     "Table of points in metres to experiment at, P.csv: x_m,y_m,z_m[,nx,ny,nz]");
    arguments.option(
        "--paths", paths_,
        "Table of paths in metres to follow, PATHS.csv: path,x_m,y_m,z_m,dx_m,dy_m,dz_m");
    arguments.option("--shard I/N", shard_,
                     "Share of the experiments to simulate, such as 3/8, for several processes; -o "
                     "then names a folder that they share, and merge puts them together");
    arguments.jobs(stage_.jobs);
    arguments.flag("--resume", stage_.resume, "Go on from the rows that an interrupted run kept");
  }

  int run(Reply& reply) override {
    if (!points_.empty() && !paths_.empty())
      throw Error("--points", "says nothing beside --paths, which name their own points",
                  "Leave one of them out.");
    stage_.files.samples = output_;
    load();
    check_choices(stage_.scene);
    check_experiments(stage_.scene, stage_.body);
    return shard_.empty() ? simulate(reply) : simulate_share(reply);
  }

 private:
  void load() {
    const fs::path shared = fs::path(output_) / "body.h5";
    if (input_.ends_with(".h5")) {
      stage_.body = read_body(input_);
      stage_.scene = scene_of(stage_.body, input_);
      made_from_ = stored_in_hdf5(input_).value_or("");
    } else {
      stage_.scene = open_scene(input_);
      made_from_ = body_fingerprint(stage_.scene);
      const bool is_made = !shard_.empty() && stored_in_hdf5(shared) == made_from_;
      stage_.body = is_made ? read_body(shared) : prepare_body(stage_.scene, false);
    }
    if (points_.empty()) return;
    const PointTable points = read_point_table(points_);
    warn_of_unused(points_, points.ignored);
    stage_.body.test_points = place_points(points, stage_.body.surface, points_);
    refuse_same_place(stage_.body.test_points.position, points_);
    stage_.scene.experiments.placement.reset();
  }

  int simulate(Reply& reply) {
    const OutputLock lock(output_);
    if (paths_.empty())
      remake(kSimulateStage, stage_);
    else
      follow_paths();
    return say_samples(stage_, reply);
  }

  int simulate_share(Reply& reply) {
    const Shard shard = parse_shard(shard_);
    if (!paths_.empty())
      throw Error("--shard", "deals test points, not the paths of --paths",
                  "Cut the table of paths into several files instead.");
    settle_body(output_, stage_.scene, stage_.body, made_from_);
    const std::size_t dealt = simulate_shard(output_, shard, stage_.jobs);
    say("{}: {} experiments", shard_path(output_, shard).string(), dealt);
    reply.json = nlohmann::ordered_json{{"experiments", dealt}};
    return kDone;
  }

  void follow_paths() {
    std::vector<std::string> unused;
    const std::vector<PathInTable> table = read_tool_paths(paths_, &unused);
    warn_of_unused(paths_, unused);
    const PlacedPaths paths = place_paths(table, stage_.body.surface, paths_);
    const fem::Simulator simulator = make_simulator(stage_.scene, stage_.body);
    const fem::SimulatorOf of_all = [&](const Experiment&) -> const fem::Simulator& {
      return simulator;
    };
    const ExperimentList list = paths_at(paths.points, paths.paths);
    ConsoleProgress progress("simulate");
    Samples& samples = stage_.samples;
    samples = fem::simulate(of_all, list, experiments_of(stage_.scene),
                            {.jobs = job_count(stage_.jobs), .already_done = {}}, {},
                            progress.progress());
    add_body_and_probe(samples, of_all, list);
    write_with_surface(output_, samples, {});
  }

  std::string input_, output_, points_, paths_, shard_, made_from_;
  Pipeline stage_{.resume = false};
};

class Merge final : public Command {
 public:
  explicit Merge(Arguments& arguments) {
    arguments.positional("folder", folder_, "Folder of the shards, which simulate --shard wrote");
    arguments.output("-o,--output", output_, "samples.h5 to write", {kSamplesSchema.name});
    arguments.named_outputs(output_, kBeside);
    arguments.jobs(jobs_);
  }

  int run(Reply& reply) override {
    const OutputLock lock(output_);
    Merged merged = merge_shards(folder_, output_, jobs_);
    if (merged.samples) {
      Pipeline stage{.files = {.samples = output_}, .samples = *std::move(merged.samples)};
      stage.scene = scene_of(read_body(fs::path(folder_) / "body.h5"), folder_);
      return say_samples(stage, reply);
    }
    say("round {} simulates {} more experiments; run all shards again, then merge",
        merged.next_round, merged.next_experiments);
    reply.json = nlohmann::ordered_json{{"next_round", merged.next_round},
                                        {"next_experiments", merged.next_experiments}};
    return kDone;
  }

 private:
  std::string folder_, output_;
  int jobs_ = 0;
};

}  // namespace

const CommandRow kMergeCommand{"merge", "Put the samples of several simulate --shard together",
                               declared<Merge>, "Stages of a run", "merge shards -o samples.h5"};
const CommandRow kSimulateCommand{
    "simulate", "Simulate presses and drags of the probe at every test point", declared<Simulate>,
    "Stages of a run", "simulate body.h5 -o samples.h5"};

}  // namespace palpate::tools
