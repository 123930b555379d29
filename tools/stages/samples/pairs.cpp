#include "tools/stages/samples/pairs.hpp"

#include <fmt/core.h>

#include <memory>

#include "libfem/probes/probes.hpp"
#include "libfem/solve/experiments/simulator.hpp"
#include "libfit/assets/asset_file.hpp"
#include "libfit/core/error.hpp"
#include "libfit/core/stated_error.hpp"
#include "libfit/fit/two_tools.hpp"
#include "libfit/io/content_hash.hpp"
#include "libfit/io/files/files.hpp"
#include "libfit/validation/paths.hpp"
#include "libfit/validation/tick_time.hpp"
#include "tools/console.hpp"
#include "tools/stages/body/reach.hpp"
#include "tools/stages/fingerprint.hpp"
#include "tools/stages/samples/kept_paths.hpp"
#include "tools/stages/samples/simulate.hpp"

namespace palpate::tools {
namespace {

using validation::HeldOut;

// Distances of two tools, over the ball's radius: from side by side to where they hardly feel each
// other.
constexpr double kLeast = 2.1, kMost = 7;
constexpr std::uint64_t kFitSeed = 0x7077;

HeldOut draw(const Scene& scene, const Body& body, int pairs, bool is_held_out) {
  const fem::ToolReach reach = make_reach(scene, body.surface);
  const double radius_m = ball_radius_m(scene.probe.spec);
  const validation::HeldOutRange range{
      scene.experiments.each.depth_m, scene.experiments.each.drag_distance_m,
      [&](const Vec3& position, const Vec3& inward) { return reach.is_free(position, inward); }};
  return validation::draw_two_tools(
      body, range, pairs, kLeast * radius_m, kMost * radius_m, is_held_out,
      is_held_out ? static_cast<std::uint64_t>(scene.validate.seed) : kFitSeed);
}

Samples simulate(const Scene& scene, const Body& body, const HeldOut& drawn, int jobs,
                 const std::filesystem::path& output, const std::string& fingerprint, bool resume) {
  return simulate_kept_paths(fem::Simulator(make_setup(scene, body)), drawn.points, drawn.paths,
                             {.what = "two tools",
                              .jobs = jobs,
                              .output = output,
                              .fingerprint = fingerprint,
                              .resume = resume});
}

validation::NamedError error_of(std::string name, const Samples& samples,
                                const TwoToolForces& answered, double floor_N) {
  std::vector<validation::ComparedRow> rows;
  for (Eigen::Index row = 0; row < samples.rows(); ++row) {
    if (samples.status[static_cast<std::size_t>(row)] != RowStatus::good) continue;
    rows.push_back({samples.force.row(row), answered.first_N.row(row), samples.force_error[row]});
    rows.push_back(
        {samples.second_force.row(row), answered.second_N.row(row), samples.force_error[row]});
  }
  return validation::named_error(std::move(name), rows, floor_N);
}

}  // namespace

void check_pairs(const Scene& scene) {
  if (scene.experiments.pairs == 0 && scene.validate.pairs == 0) return;
  const std::string where = scene.path.string() + ": pairs";
  if (scene.probe.spec.shape != "sphere")
    throw Error(
        where,
        fmt::format("two tools are simulated as balls, and this is a {}", scene.probe.spec.shape),
        "Take shape = \"sphere\" in [probe], or leave pairs out.");
}

Samples simulate_pairs(const Scene& scene, const Body& body, int jobs,
                       const std::filesystem::path& output, const std::string& fingerprint,
                       bool resume) {
  const Samples samples = simulate(scene, body, draw(scene, body, scene.experiments.pairs, false),
                                   jobs, output, fingerprint, resume);
  list_bad_experiments(samples);
  return samples;
}

CouplingEvidence pairs_evidence(const runtime::AssetView& asset, const Scene& scene,
                                const Body& body, const Samples& pairs) {
  const auto drawn = std::make_shared<HeldOut>(draw(scene, body, scene.experiments.pairs, false));
  const double depth_m = scene.experiments.each.depth_m;
  const auto replayed = [&asset, &pairs, drawn, depth_m](const runtime::CouplingView& coupling) {
    return replay_two_tools(asset, coupling, pairs, drawn->paths, depth_m);
  };
  const auto residual = [&pairs, replayed](const runtime::CouplingView& coupling) {
    return two_tool_residual(pairs, replayed(coupling));
  };
  const auto report = [&pairs, drawn, replayed](const runtime::CouplingView& coupling) {
    const std::vector<double> felt = two_tool_errors(pairs, replayed(coupling)),
                              alone = two_tool_errors(pairs, replayed({}));
    const auto at = [](const std::vector<double>& errors, double share) {
      return stated_percent(stated_quantile(errors, share));
    };
    say("  two tools: forces of {} pairs ({} rows of one tool) are off by {} (median), {} (p95) if "
        "they feel each other, {} and {} if not",
        drawn->paths.size(), felt.size(), at(felt, 0.5), at(felt, 0.95), at(alone, 0.5),
        at(alone, 0.95));
  };
  return {residual, report};
}

void state_two_tools(const std::filesystem::path& path, const Scene& scene, const Body& body,
                     int jobs, const std::filesystem::path& folder, bool resume,
                     validation::Statement& statement) {
  if (scene.validate.pairs == 0) return;
  const AssetFile file = read_asset_file(path);
  const HeldOut drawn = draw(scene, body, scene.validate.pairs, true);
  ContentHash hash;
  hash.add("held-out pairs").add(point_fingerprint(scene, body));
  for (const ToolPath& way : drawn.paths)
    for (const Points* rows : {&way.deflections, &way.second->deflections})
      hash.add({reinterpret_cast<const char*>(rows->data()),
                static_cast<std::size_t>(rows->size()) * sizeof(double)});
  const Samples samples =
      simulate(scene, body, drawn, jobs, folder.empty() ? folder : folder / "reference_pairs.h5",
               hash.hex(), resume);
  const double depth_m = scene.experiments.each.depth_m;
  const runtime::CouplingView* known = file.asset().coupling;
  const runtime::CouplingView coupling = known != nullptr ? *known : runtime::CouplingView();
  const TwoToolForces felt =
      replay_two_tools(file.asset(), coupling, samples, drawn.paths, depth_m);
  statement.two_tools = {error_of("felt", samples, felt, statement.floor_N),
                         error_of("each_by_itself", samples,
                                  replay_two_tools(file.asset(), {}, samples, drawn.paths, depth_m),
                                  statement.floor_N)};
  statement.two_tools_tick_ns = validation::tick_ns([&] {
    return replay_two_tools(file.asset(), coupling, samples, drawn.paths, depth_m).ticks;
  });
}

}  // namespace palpate::tools
