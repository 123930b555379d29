#include "tools/stages/samples/placement.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

#include "libfem/solve/experiments/quick_press.hpp"
#include "libfit/core/stated_error.hpp"
#include "libfit/fit/fit_curves.hpp"
#include "libfit/io/csv/csv.hpp"
#include "libfit/refine/insert_point.hpp"
#include "libfit/refine/next_points.hpp"
#include "libfit/refine/points_on_surface.hpp"
#include "libfit/refine/refine.hpp"
#include "libfit/validation/replay.hpp"
#include "tools/console.hpp"
#include "tools/stages/fingerprint.hpp"
#include "tools/stages/fit.hpp"
#include "tools/stages/samples/experiment_table.hpp"
#include "tools/stages/samples/simulate.hpp"

namespace palpate::tools {
namespace {

using namespace validation;

// A round adds a quarter of what there is: few enough to learn from, enough to keep threads busy.
// Where presses are quick, fits are what takes time, and it adds half; there the tolerance has to
// be met twice, because the few points of one round may all lie where a body is even.
constexpr int kMinBatch = 4, kMaxBatch = 64;
constexpr double kShare = 0.25, kQuickShare = 0.5;
constexpr int kQuickRounds = 2;
constexpr int kMostDragged = 48;  // points, where all have to be dragged: ten times the time

// Curves of the points so far. Later rounds keep the first round's bases and fit what is new.
FittedCurves fit_so_far(const Scene& scene, const Samples& samples, int jobs,
                        const FittedCurves* before, FitCache& cache) {
  FitOptions options = fit_options(samples, scene.fit, jobs);
  options.warm_start = before;
  options.warm_cache = &cache;
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

std::vector<std::int32_t> choose(const Body& body, const TestPoints& points, const Model& model,
                                 const std::vector<double>& expected_error, int count,
                                 double tolerance) {
  const auto seeds =
      place_on_surface(points.position, points.normal, body.surface, -model.inward_normal,
                       std::numbers::pi, extent_m(body.surface.vertices).norm());
  NextPointsOptions options;
  options.count = count;
  if (tolerance > 0) options.gap_error = tolerance / 4;
  std::vector<char> is_candidate = model.is_covered;
  for (std::size_t v = 0; v < is_candidate.size(); ++v)
    is_candidate[v] = is_candidate[v] && body.is_reachable[v];
  return next_points(body.surface, is_candidate, seeds, expected_error, options);
}

// Compares presses on one mesh with those on two, at points that have these (M13e). No scale where
// they are further off than wanted.
fem::QuickScale try_quick(const fem::SimulatorOf& simulator, const TestPoints& points,
                          const fem::Experiments& experiments, const Samples& two_meshes,
                          double wanted, SampleCache& known) {
  const std::vector<Effort> one_mesh(static_cast<std::size_t>(points.position.rows()), {false, 1});
  fem::QuickScale quick = fem::compare_quick(
      two_meshes,
      known.at(simulator, experiments_at(points, one_mesh), experiments, "press on one mesh"));
  if (!quick) return quick;
  say("  presses on one mesh: times {:.3f} they are {:.1f} % (p95) off those on two: {}",
      quick.number(), 100 * quick.p95,
      quick.p95 <= wanted ? "new points are pressed so" : "too far");
  if (quick.p95 > wanted) quick = {};
  return quick;
}

// kFirstDrags points, if there are that many of those whose presses came to their end, by the force
// of their deepest row: how the constants of a body's rings go with the force is a line. The
// greatest force is a lump's; the least belongs to a fold or an edge as often as not.
std::vector<Effort> first_drags(const Samples& samples) {
  std::vector<double> force_N(static_cast<std::size_t>(samples.points()), 0);
  std::vector<char> is_cut(force_N.size(), 0);
  std::vector<std::size_t> order;
  for (Eigen::Index row = 0; row < samples.rows(); ++row) {
    const auto r = static_cast<std::size_t>(row);
    const auto point = static_cast<std::size_t>(samples.point[r]);
    if (samples.status[r] != RowStatus::good) is_cut[point] = 1;
    double& most = force_N[point];
    most = std::max(most, samples.force.row(row).norm());
  }
  for (const bool any_will_do : {false, true})
    if (order.size() < kFirstDrags) {
      order.clear();
      for (std::size_t p = 0; p < force_N.size(); ++p)
        if (force_N[p] > 0 && (any_will_do || !is_cut[p])) order.push_back(p);
    }
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return force_N[a] < force_N[b]; });
  std::vector<Effort> effort(force_N.size());
  if (order.empty()) return effort;
  const std::size_t from_end = order.size() / 8;
  for (std::size_t k = 0; k < kFirstDrags; ++k)
    effort[order[from_end + (order.size() - 1 - from_end) * k / (kFirstDrags - 1)]].is_dragged =
        true;
  return effort;
}

}  // namespace

PlacementRound judge_round(const Samples& samples, const Model& model,
                           const std::vector<std::int32_t>& vertices,
                           const std::vector<FitStatus>& fits) {
  PlacementRound round;
  round.new_points = static_cast<int>(vertices.size());
  round.points = static_cast<int>(samples.points()) - round.new_points;
  Replayed predicted(samples);
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const std::int32_t point = round.points + static_cast<std::int32_t>(i);
    if (fits[static_cast<std::size_t>(point)] == FitStatus::poor)
      ++round.poor;
    else
      replay_point(samples, point, model.curves, vertices[i], predicted);
  }
  const Statement statement = summarize(compare(samples, predicted));
  round.rows = static_cast<int>(statement.rows_above_floor);
  round.median_rel = statement.all.force.median_rel;
  round.p95_rel = statement.all.force.p95_rel;
  round.max_rel = statement.all.force.max_rel;
  return round;
}

Placement place_and_simulate(const Scene& scene, const Body& body,
                             const fem::SimulatorOf& simulator, int jobs, SampleCache& known) {
  const PlacementSection& wanted = *scene.experiments.placement;
  const fem::Experiments experiments = experiments_of(scene);
  Placement placement;
  placement.points = body.test_points;
  const bool has_drags = !experiments.drag_depths_m.empty();
  const bool are_few = has_drags && wanted.drag_points == "few" &&
                       (scene.fit.family == "auto" || scene.fit.family == "rings");
  std::vector<Effort>& effort = placement.effort;
  effort.assign(static_cast<std::size_t>(placement.points.position.rows()),
                {has_drags && !are_few, 0});
  fem::QuickScale& quick = placement.quick;
  const auto simulate = [&](const TestPoints& points) {
    placement.samples =
        known.at(simulator, experiments_at(points, effort), experiments, "simulate", quick);
  };
  simulate(placement.points);
  if (are_few) {
    effort = first_drags(placement.samples);
    simulate(placement.points);
  }
  FitCache cache;
  FittedCurves curves = fit_so_far(scene, placement.samples, jobs, nullptr, cache);
  const auto are_rings = [&] { return curves.curves.family == CurveFamily::rings; };
  if (are_few && !are_rings()) {  // other families are not told by a few drags
    std::fill(effort.begin(), effort.end(), Effort{true, 0});
    simulate(placement.points);
    curves = fit_so_far(scene, placement.samples, jobs, nullptr, cache);
  }
  const bool press_alone = !has_drags || (are_few && are_rings());
  const int budget = press_alone ? wanted.budget : std::min(wanted.budget, kMostDragged);
  if (press_alone && budget > placement.points.position.rows())
    quick = try_quick(simulator, placement.points, experiments, placement.samples,
                      scene.experiments.force_tolerance > 0 ? scene.experiments.force_tolerance
                      : wanted.tolerance > 0                ? wanted.tolerance
                                                            : PlacementSection{}.tolerance,
                      known);
  int rounds_within = 0;
  while (placement.ended.empty()) {
    const auto count = static_cast<int>(placement.points.position.rows());
    const double share = quick ? kQuickShare : kShare;
    const int batch =
        std::min(std::clamp(static_cast<int>(share * count), kMinBatch, kMaxBatch), budget - count);
    if (batch <= 0) {
      placement.ended = fmt::format("the budget of {} points is spent", budget);
      break;
    }
    RefineReport refined;
    const Model model =
        refine(curves, body.surface, body.in_region, placement.points.triangles, {}, &refined);
    const std::vector<double> expected =
        expected_errors(curves, model, refined, relative_floor_N(placement.samples));
    const Grown grown =
        grow(placement.points, model,
             choose(body, placement.points, model, expected, batch, wanted.tolerance));
    if (grown.vertices.empty()) {
      placement.ended = "every vertex that can be reached is a test point";
      break;
    }
    effort.resize(static_cast<std::size_t>(grown.points.position.rows()),
                  {!press_alone, quick.number()});
    simulate(grown.points);
    placement.points = grown.points;
    curves = fit_so_far(scene, placement.samples, jobs, &curves, cache);
    PlacementRound round = judge_round(placement.samples, model, grown.vertices, curves.status);
    round.dragged = static_cast<int>(std::ranges::count_if(effort, &Effort::is_dragged));
    placement.rounds.push_back(round);
    say("  {} points predict {} new ones to {} (median), {} (p95), {} (max); {} points are "
        "dragged{}",
        round.points, round.new_points, stated_percent(round.median_rel),
        stated_percent(round.p95_rel), stated_percent(round.max_rel), round.dragged,
        round.poor > 0 ? fmt::format("; {} poor ones do not count", round.poor) : "");
    rounds_within = round.p95_rel <= wanted.tolerance ? rounds_within + 1 : 0;
    if (rounds_within == (quick ? kQuickRounds : 1))
      placement.ended = fmt::format("the tolerance of {:.3g} % is met", 100 * wanted.tolerance);
  }
  say("  {} test points: {}", placement.points.position.rows(), placement.ended);
  return placement;
}

Samples simulate_scene(const Scene& scene, const Body& body, const SimulateRequest& request,
                       std::optional<Samples> known) {
  SampleCache cache = known ? SampleCache(request, *std::move(known)) : SampleCache(request);
  Attributes attributes = attributes_of(request);
  attributes[kInputsAttribute] = samples_fingerprint(scene, body);
  const Simulators simulators(scene, body, Purpose::identify);
  const fem::SimulatorOf simulator = std::cref(simulators);
  const fem::Experiments each = experiments_of(scene);
  TestPoints points = body.test_points;
  fem::QuickScale quick;
  std::vector<Effort> effort(static_cast<std::size_t>(points.position.rows()),
                             {!each.drag_depths_m.empty(), 0});
  if (scene.experiments.placement) {
    Placement placement = place_and_simulate(scene, body, simulator, request.jobs, cache);
    points = std::move(placement.points);
    effort = std::move(placement.effort);
    quick = std::move(placement.quick);
    Body placed = body;
    placed.test_points = points;
    const std::filesystem::path folder = request.output.parent_path();
    write_body(folder / "placed.h5", placed, {{kInputsAttribute, attributes.at(kInputsAttribute)}});
    write_rounds(folder / "placement.csv", placement.rounds);
  }
  ExperimentList list = experiments_at(points, effort);
  append(list, draw_experiments({scene, body, points, Purpose::identify}));
  Samples samples = cache.at(simulator, list, each, "simulate", quick);
  samples.relaxation = contact_relaxation(scene, body, samples);
  write_with_surface(request.output, samples, attributes);
  remove_partial(request.output);
  return samples;
}

void write_rounds(const std::filesystem::path& path, const std::vector<PlacementRound>& rounds) {
  static constexpr std::string_view kHeader[] = {"points",  "new_points", "median_rel", "p95_rel",
                                                 "max_rel", "dragged",    "poor",       "rows"};
  CsvWriter csv(path, kHeader);
  for (const PlacementRound& round : rounds) {
    if (std::isnan(round.p95_rel)) continue;  // no new point has a good row
    csv.integer(round.points)
        .integer(round.new_points)
        .number(round.median_rel)
        .number(round.p95_rel)
        .number(round.max_rel)
        .integer(round.dragged)
        .integer(round.poor)
        .integer(round.rows)
        .end_row();
  }
  csv.commit();
}

double last_predicted_p95(const std::filesystem::path& placement_csv) {
  static constexpr CsvColumnRule kRules[] = {{"p95_rel"}};
  const std::vector<double> p95 = read_csv(placement_csv, kRules).number("p95_rel");
  return p95.empty() ? std::numeric_limits<double>::quiet_NaN() : p95.back();
}

}  // namespace palpate::tools
