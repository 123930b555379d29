#include "tools/stages/placement.hpp"

#include <algorithm>
#include <numbers>

#include "libfit/core/statistics.hpp"
#include "libfit/fit/fit_curves.hpp"
#include "libfit/io/csv/csv.hpp"
#include "libfit/refine/insert_point.hpp"
#include "libfit/refine/next_points.hpp"
#include "libfit/refine/points_on_surface.hpp"
#include "libfit/refine/refine.hpp"
#include "libfit/validation/replay.hpp"
#include "tools/console.hpp"
#include "tools/stages/fit.hpp"
#include "tools/stages/simulate.hpp"

namespace palpate::tools {
namespace {

using namespace validation;

// A round adds a quarter of what there is: few enough to learn from, enough to keep threads busy.
constexpr int kMinBatch = 4, kMaxBatch = 64;

// Curves of the points so far. Later rounds keep the first round's bases and fit what is new.
FittedCurves fit_so_far(const Scene& scene, const Samples& samples, int jobs,
                        const FittedCurves* before, FitCache& cache) {
  FitOptions options = fit_options(samples, scene.fit, jobs);
  options.warm_start = before;
  options.warm_cache = &cache;
  options.smoothing = 0;
  return fit_curves(samples, options, {}, nullptr, &cache);
}

// Points so far with the ones of a batch, and the fine vertex each new one is.
struct Grown {
  TestPoints points;
  std::vector<std::int32_t> vertices;
};

Grown grow(const TestPoints& points, const Model& model,
           const std::vector<std::int32_t>& candidates) {
  Grown grown{points, {}};
  for (const std::int32_t vertex : candidates) {
    Eigen::Index strongest = 0;
    model.blend_weight.row(vertex).maxCoeff(&strongest);
    const NewTestPoint added{model.surface.vertices.row(vertex), model.inward_normal.row(vertex),
                             fmt::format("p{:04}", grown.points.position.rows() + 1),
                             model.blend_point(vertex, strongest)};
    if (insert_point(grown.points, added)) grown.vertices.push_back(vertex);
  }
  return grown;
}

std::vector<std::int32_t> choose(const Body& body, const TestPoints& points,
                                 const FittedCurves& curves, const Model& model, int count,
                                 double tolerance) {
  const auto seeds =
      place_on_surface(points.position, points.normal, body.surface, -model.inward_normal,
                       std::numbers::pi, extent_m(body.surface.vertices).norm());
  NextPointsOptions options;
  options.count = count;
  if (tolerance > 0) options.gap_error = tolerance / 4;
  return next_points(body.surface, model.is_covered, seeds,
                     expected_errors(curves, model, points.triangles, kForceFloor_N), options);
}

PlacementRound judge(const Samples& samples, const Model& model, const Grown& grown) {
  const auto before = static_cast<std::int32_t>(samples.points()) -
                      static_cast<std::int32_t>(grown.vertices.size());
  Replayed predicted(samples);
  for (std::size_t i = 0; i < grown.vertices.size(); ++i)
    replay_point(samples, before + static_cast<std::int32_t>(i), model.curves, grown.vertices[i],
                 predicted);
  const Statement statement = summarize(compare(samples, predicted));
  return {before, static_cast<int>(grown.vertices.size()), statement.median_rel, statement.p95_rel,
          statement.max_rel};
}

}  // namespace

Placement place_and_simulate(const Scene& scene, const Body& body, const SimulateRequest& request) {
  const PlacementSection& wanted = *scene.experiments.placement;
  const fem::Simulator simulator = make_simulator(scene, body);
  const fem::Experiments experiments = experiments_of(scene);
  SampleCache known(request);
  Placement placement;
  placement.points = body.test_points;
  placement.samples = known.at(simulator, placement.points, experiments, "simulate");
  FitCache cache;
  FittedCurves curves = fit_so_far(scene, placement.samples, request.jobs, nullptr, cache);
  while (placement.ended.empty()) {
    const auto count = static_cast<int>(placement.points.position.rows());
    const int batch = std::min(std::clamp(count / 4, kMinBatch, kMaxBatch), wanted.budget - count);
    if (batch <= 0) {
      placement.ended = fmt::format("the budget of {} points is spent", wanted.budget);
      break;
    }
    const Model model = refine(curves, body.surface, body.is_reachable, placement.points.triangles);
    const Grown grown =
        grow(placement.points, model,
             choose(body, placement.points, curves, model, batch, wanted.tolerance));
    if (grown.vertices.empty()) {
      placement.ended = "every vertex that can be reached is a test point";
      break;
    }
    placement.samples = known.at(simulator, grown.points, experiments, "simulate");
    placement.points = grown.points;
    const PlacementRound round = judge(placement.samples, model, grown);
    placement.rounds.push_back(round);
    say("  {} points predict {} new ones to {:.1f} % (median), {:.1f} % (p95), {:.1f} % (max)",
        round.points, round.new_points, 100 * round.median_rel, 100 * round.p95_rel,
        100 * round.max_rel);
    if (round.p95_rel <= wanted.tolerance)
      placement.ended = fmt::format("the tolerance of {} % is met", 100 * wanted.tolerance);
    else
      curves = fit_so_far(scene, placement.samples, request.jobs, &curves, cache);
  }
  say("  {} test points: {}", placement.points.position.rows(), placement.ended);
  return placement;
}

void write_rounds(const std::filesystem::path& path, const std::vector<PlacementRound>& rounds) {
  static constexpr std::string_view kHeader[] = {"points", "new_points", "median_rel", "p95_rel",
                                                 "max_rel"};
  CsvWriter csv(path, kHeader);
  for (const PlacementRound& round : rounds)
    csv.integer(round.points)
        .integer(round.new_points)
        .number(round.median_rel)
        .number(round.p95_rel)
        .number(round.max_rel)
        .end_row();
  csv.commit();
}

}  // namespace palpate::tools
