#include "tools/stage_simulate.hpp"

#include <map>
#include <numeric>
#include <set>

#include "libfem/mesh/read/read.hpp"
#include "libfem/solve/simulate.hpp"
#include "libfit/io/describe.hpp"
#include "libfit/io/samples_file.hpp"
#include "tools/console.hpp"
#include "tools/freshness.hpp"

namespace palpate::tools {
namespace {

constexpr double kKeepInterval_s = 5;   // an interruption by force loses no more than this
constexpr std::size_t kListed = 15;     // experiments named before "and N more"

std::filesystem::path partial_of(const std::filesystem::path& output) { return output.string() + ".partial"; }

// Keeps finished points in a file beside the output.
class Keeper {
 public:
  Keeper(const SimulateRequest& request, const TestPoints& points) : request_(request), points_(points) {}

  // What an earlier run kept for the same inputs; empty otherwise.
  Samples kept() const {
    const auto partial = partial_of(request_.output);
    if (!std::filesystem::exists(partial)) return {};
    if (!request_.resume) {
      say("  {} of an interrupted run is not used (no --resume)", partial.string());
      return {};
    }
    if (inputs_of_hdf5(partial) != request_.inputs) {
      say("  {} was made from something else and is not used", partial.string());
      return {};
    }
    Samples samples = read_samples(partial);
    const std::set<std::int32_t> done(samples.point.begin(), samples.point.end());
    say("  resuming: {} of {} points are done", done.size(), points_.position.rows());
    return samples;
  }

  void keep(const Samples& samples) const {
    write_samples(partial_of(request_.output), samples, {{kInputsAttribute, request_.inputs}});
  }

 private:
  const SimulateRequest& request_;
  const TestPoints& points_;
};

}  // namespace

fem::ProbeSpec probe_spec(const ProbeSection& section) {
  fem::ProbeSpec spec = section.spec;
  if (section.mesh) spec.mesh = read_surface(*section.mesh, section.mesh_unit_m);
  return spec;
}

fem::SimulationSetup make_setup(const Scene& scene, const Body& body) {
  fem::SimulationSetup setup;
  setup.volume = body.volume;
  setup.is_held = body.is_held;
  setup.surface = body.surface;
  setup.materials.push_back(*scene.material);
  std::vector<Region> regions;
  for (const InclusionSection& inclusion : scene.inclusions) {
    setup.materials.push_back(inclusion.material);
    regions.push_back(inclusion.region);
  }
  // The last inclusion named wins where several overlap.
  if (!regions.empty())
    setup.region_at = [regions](const Vec3& place) {
      for (std::size_t i = regions.size(); i-- > 0;)
        if (contains(regions[i], place)) return static_cast<int>(i) + 1;
      return 0;
    };
  setup.probe = probe_spec(scene.probe);
  setup.options.equilibrium.element = fem::find_element(scene.body.element, "element of [body]").kind;
  return setup;
}

fem::Experiments experiments_of(const Scene& scene) {
  const ExperimentsSection& e = scene.experiments;
  return {.depth_m = e.depth_m,
          .press_steps = e.press_steps,
          .drag_depths_m = e.drag_directions > 0 ? e.drag_depths_m : std::vector<double>{},
          .drag_distance_m = e.drag_distance_m,
          .drag_directions = e.drag_directions,
          .drag_steps = e.drag_steps};
}

fem::Simulator make_simulator(const Scene& scene, const Body& body) { return fem::Simulator(make_setup(scene, body)); }

Samples simulate_body(const Scene& scene, const Body& body, const SimulateRequest& request) {
  const fem::Simulator simulator = make_simulator(scene, body);
  const Keeper keeper(request, body.test_points);
  fem::SimulateOptions options{.jobs = job_count(request.jobs), .already_done = keeper.kept()};
  double kept_s = 0;  // the first finished point is kept at once
  const auto on_done = [&](const std::function<Samples()>& so_far) {
    if (wall_seconds() - kept_s < kKeepInterval_s) return;
    keeper.keep(so_far());
    kept_s = wall_seconds();
  };
  Samples samples;
  {
    ConsoleProgress progress("simulate");
    samples = fem::simulate(simulator, body.test_points, experiments_of(scene), options, on_done, progress.progress());
  }
  if (is_interrupted()) {
    keeper.keep(samples);
    throw Interrupted(fmt::format("simulate: what is done is kept in {}; go on with --resume (run does so by itself)",
                                  partial_of(request.output).string()));
  }
  return samples;
}

void remove_partial(const std::filesystem::path& output) {
  std::error_code ignored;
  std::filesystem::remove(partial_of(output), ignored);
}

namespace {

// "rejected: overlaps"
std::string reason_of(const Samples& samples, std::size_t row) {
  std::string reason(kRowStatusNames[static_cast<std::size_t>(samples.status[row])].name);
  if (!samples.doubt.empty() && samples.doubt[row] != RowDoubt::none &&
      samples.status[row] != RowStatus::inverted)
    reason += ": " + std::string(kRowDoubtNames[static_cast<std::size_t>(samples.doubt[row])].name);
  return reason;
}

}  // namespace

std::size_t list_bad_experiments(const Samples& samples) {
  // First bad row of each experiment, with the first reason that is not a consequence.
  std::map<std::int32_t, std::pair<Eigen::Index, std::size_t>> bad;
  for (Eigen::Index row = 0; row < samples.rows(); ++row)
    if (samples.status[static_cast<std::size_t>(row)] != RowStatus::good)
      ++bad.try_emplace(samples.experiment[static_cast<std::size_t>(row)], row, 0).first->second.second;
  std::size_t listed = 0;
  for (const auto& [experiment, place] : bad) {
    if (listed++ == kListed) {
      say("  and {} more experiments with rows that are not good", bad.size() - kListed);
      break;
    }
    const auto row = static_cast<std::size_t>(place.first);
    const Vec3 at = samples.point_position.row(samples.point[row]);
    say("  not good: {} at ({:.1f}, {:.1f}, {:.1f}) mm, {} from {:.2f} mm on: {} ({} rows)",
        samples.point_name[static_cast<std::size_t>(samples.point[row])], 1e3 * at[0], 1e3 * at[1], 1e3 * at[2],
        samples.kind[row] == ExperimentKind::press ? "press" : samples.kind[row] == ExperimentKind::drag ? "drag" : "path",
        1e3 * samples.deflection.row(place.first).norm(), reason_of(samples, row), place.second);
  }
  return bad.size();
}

}  // namespace palpate::tools
