#include <nlohmann/json.hpp>

#include "libfem/solve/experiments/simulate.hpp"
#include "libfit/io/csv/tables.hpp"
#include "libfit/io/files/files.hpp"
#include "tools/command.hpp"
#include "tools/console.hpp"
#include "tools/scene/settings.hpp"
#include "tools/stages/fingerprint.hpp"
#include "tools/stages/placement.hpp"
#include "tools/stages/prepare.hpp"
#include "tools/stages/simulate.hpp"

namespace palpate::tools {
namespace {

class Simulate final : public Command {
 public:
  explicit Simulate(Arguments& arguments) {
    arguments.positional("input", input_, "Scene to read, scene.toml, or the body.h5 made from it");
    arguments.output("-o,--output", output_, "samples.h5 to write", {kSamplesSchema.name});
    arguments.option("--points", points_,
                     "Table of points in metres to experiment at, P.csv: x_m,y_m,z_m[,nx,ny,nz]");
    arguments.option(
        "--paths", paths_,
        "Table of paths in metres to follow, PATHS.csv: path,x_m,y_m,z_m,dx_m,dy_m,dz_m");
    arguments.option("--jobs", jobs_,
                     "Number of threads; 0 uses all cores; results do not depend on it");
    arguments.flag("--resume", resume_, "Go on from the rows that an interrupted run kept");
  }

  int run(Reply& reply) override {
    load();
    check_choices(scene_);
    check_experiments(scene_, body_);
    const std::string fingerprint = point_fingerprint(scene_, body_);
    if (paths_.empty())
      attributes_ = {{kInputsAttribute, samples_fingerprint(scene_, body_)},
                     {kPointFingerprintAttribute, fingerprint}};
    const bool is_placing = scene_.experiments.placement && points_.empty() && paths_.empty();
    const SimulateRequest request{jobs_, output_, fingerprint, resume_,
                                  keeps_surface(scene_, body_)};
    const Samples samples = !paths_.empty() ? follow_paths()
                            : is_placing    ? place(request)
                                            : simulate_body(scene_, body_, request);
    write_with_surface(output_, samples, attributes_);
    remove_partial(output_);
    say("wrote {}: {} rows at {} points", output_, samples.rows(), samples.points());
    say_force_errors(samples, scene_.experiments.force_tolerance);
    const std::size_t bad = list_bad_experiments(samples);
    reply.json = nlohmann::ordered_json{
        {"rows", samples.rows()}, {"points", samples.points()}, {"experiments_not_good", bad}};
    return bad ? kSomeFailed : kDone;
  }

 private:
  void load() {
    if (input_.ends_with(".h5")) {
      body_ = read_body(input_);
      scene_ = scene_of(body_, input_);
    } else {
      scene_ = open_scene(input_);
      body_ = prepare_body(scene_, false);
    }
    if (!points_.empty())
      body_.test_points = place_points(read_point_table(points_), body_.surface, points_);
  }

  // The points grow; the body that `refine` needs then is written beside the samples.
  Samples place(const SimulateRequest& request) {
    Placement placement = place_and_simulate(scene_, body_, request);
    body_.test_points = std::move(placement.points);
    const auto folder = std::filesystem::path(output_).parent_path();
    write_body(folder / "placed.h5", body_, {{kInputsAttribute, attributes_.at(kInputsAttribute)}});
    write_rounds(folder / "placement.csv", placement.rounds);
    say("wrote {}", (folder / "placed.h5").string());
    return std::move(placement.samples);
  }

  Samples follow_paths() {
    const PlacedPaths paths = place_paths(read_tool_paths(paths_), body_.surface, paths_);
    const fem::Simulator simulator = make_simulator(scene_, body_);
    ConsoleProgress progress("simulate");
    Samples samples = fem::simulate_paths(simulator, paths.points, paths.paths,
                                          {.jobs = job_count(jobs_), .already_done = {}}, {},
                                          progress.progress());
    add_origin(samples, simulator);
    return samples;
  }

  std::string input_, output_, points_, paths_;
  int jobs_ = 0;
  bool resume_ = false;
  Scene scene_;
  Body body_;
  Attributes attributes_;
};

}  // namespace

std::unique_ptr<Command> declare_simulate(Arguments& arguments) {
  return std::make_unique<Simulate>(arguments);
}

}  // namespace palpate::tools
