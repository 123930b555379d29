#include "tools/stages/samples/placement.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>

#include "libfem/probes/probes.hpp"
#include "libfem/solve/experiments/simulate.hpp"
#include "libfit/core/stated_error.hpp"
#include "libfit/fit/fit_curves.hpp"
#include "libfit/io/atomic_file.hpp"
#include "libfit/io/csv/csv.hpp"
#include "libfit/refine/next_points.hpp"
#include "libfit/refine/points_on_surface.hpp"
#include "libfit/refine/refine.hpp"
#include "libfit/validation/replay.hpp"
#include "tools/console.hpp"
#include "tools/stages/fingerprint.hpp"
#include "tools/stages/fit.hpp"
#include "tools/stages/samples/experiment_table.hpp"

namespace palpate::tools {
namespace {

using namespace validation;

// The tolerance has to be met by two rounds in a row or more, of so many new points: a few may all
// lie where a body is even. No round after one that met it adds more.
constexpr int kJudged = 12;

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
                                 double tolerance, double least_m) {
  const auto seeds =
      place_on_surface(points.position, points.normal, body.surface, -model.inward_normal, -1,
                       extent_m(body.surface.vertices).norm());
  NextPointsOptions options;
  options.count = count;
  if (tolerance > 0) options.gap_error = tolerance / 4;
  options.least_m = least_m;
  std::vector<char> is_candidate = model.is_covered;
  for (std::size_t v = 0; v < is_candidate.size(); ++v)
    is_candidate[v] = is_candidate[v] && body.is_reachable[v];
  return next_points(body.surface, is_candidate, seeds, expected_error, options);
}

// Compares presses on one mesh with those on two at some points (M13e). No scale where they are
// further off than wanted.
fem::QuickScale try_quick(const fem::SimulatorOf& simulator, const TestPoints& points,
                          const std::vector<Effort>& effort, const std::vector<std::size_t>& which,
                          const fem::Experiments& experiments, double wanted, SampleCache& known) {
  const std::vector<Effort> one_mesh(effort.size(), {false, 1});
  const auto at = [&](const std::vector<Effort>& of, const char* what) {
    return known.at(simulator, taken(experiments_at(points, of), which), experiments, what);
  };
  const Samples two_meshes = at(effort, "simulate");
  fem::QuickScale quick = fem::compare_quick(two_meshes, at(one_mesh, "press on one mesh"), wanted);
  if (!quick) return quick;
  const bool is_good = quick.p95 <= wanted && quick.points >= 4;
  say("  presses on one mesh: times {:.3f} they are {:.1f} % (p95) off those on two, at {} points "
      "that state less than {:.3g} % themselves: {}",
      quick.number(), 100 * quick.p95, quick.points, 100 * wanted,
      is_good ? "others are pressed so" : "too far, or too few");
  if (!is_good) quick = {};
  return quick;
}

}  // namespace

int round_size(int points, bool is_quick, bool is_within) {
  // A quarter of what there is: few enough to learn from, enough to keep threads busy. Where
  // presses are quick, fits are what takes time.
  return std::clamp((is_quick ? 2 : 1) * points / 4, 4, is_within ? kJudged : 64);
}

PlacementRound judge_round(const Samples& samples, const Model& model,
                           const std::vector<std::int32_t>& vertices,
                           const std::vector<FitStatus>& fits) {
  PlacementRound round;
  round.new_points = static_cast<int>(vertices.size());
  round.points = static_cast<int>(samples.points()) - round.new_points;
  Replayed predicted(samples);
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const std::int32_t point = round.points + static_cast<std::int32_t>(i);
    if (fits[point] == FitStatus::poor)
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

namespace {

void write_rounds(const std::filesystem::path& path, const std::vector<PlacementRound>& rounds) {
  static constexpr std::string_view kHeader[] = {"points",  "new_points", "median_rel", "p95_rel",
                                                 "max_rel", "dragged",    "poor",       "rows"};
  CsvWriter csv(path, kHeader);
  for (const PlacementRound& round : rounds) {
    if (std::isnan(round.p95_rel)) continue;  // no new point has a good row
    csv.integer(round.points).integer(round.new_points).number(round.median_rel);
    csv.number(round.p95_rel).number(round.max_rel).integer(round.dragged);
    csv.integer(round.poor).integer(round.rows).end_row();
  }
  csv.commit();
}

struct Placement {
  TestPoints points;           ///< the body's first points, then those added, triangulated
  std::vector<Effort> effort;  ///< what is simulated at each
  fem::QuickScale quick;       ///< what presses on one mesh lack
  Samples samples;
  std::vector<PlacementRound> rounds;
  std::string ended;  ///< why, a sentence
};

/// Adds test points where interpolation fails (docs/method.md, section 7): from the body's own
/// points on, each round predicts the experiments at places that promise the largest error,
/// simulates there and adds them, until two rounds or more in a row, of twelve new points, were
/// predicted within the tolerance (p95 of force errors at points whose own fit is not poor) or the
/// budget is spent. Says the error of each round. With rings a few of the first points are dragged
/// and all others pressed alone, on one mesh where that is good enough (M13e). A first
/// point that is pressed on one mesh is pressed once more when its factor is known; nothing else is
/// simulated twice, in this run or a resumed one. The same scene gives the same points whatever the
/// number of threads.
class PlacementRounds {
 public:
  PlacementRounds(const Scene& scene, const Body& body, const fem::SimulatorOf& simulator, int jobs,
                  SampleCache& known)
      : scene_(scene),
        body_(body),
        simulator_(simulator),
        jobs_(jobs),
        known_(known),
        wanted_(*scene.experiments.placement),
        experiments_(experiments_of(scene)),
        has_drags_(!experiments_.drag_depths_m.empty()),
        are_few_(has_drags_ && scene.fit.family != name_of(CurveFamily::separable)),
        contact_m_(rigid_probe(scene).contact_radius_m(experiments_.depth_m)),
        least_m_(0.5 * contact_m_) {}

  Placement run() {
    begin();
    while (is_next_round()) {
      const RoundPrediction predicted = predict();
      const Grown grown = choose_points(predicted);
      if (grown.vertices.empty()) break;
      simulate(grown.points);
      fit(&curves_);
      judge(predicted.model, grown.vertices);
    }
    say("  {} test points: {}", placement_.points.position.rows(), placement_.ended);
    if (are_few_ && press_alone_) drag_last();
    return std::move(placement_);
  }

 private:
  struct RoundPrediction {
    Model model;
    std::vector<double> expected_error;
  };

  // The first points: a few of them are dragged, and all others pressed alone where that is enough.
  void begin() {
    placement_.points = body_.test_points;
    std::vector<Effort>& effort = placement_.effort;
    const Eigen::Index first = placement_.points.position.rows();
    effort.assign(first, {has_drags_ && !are_few_, 0});
    on_two_meshes_.resize(effort.size());
    std::iota(on_two_meshes_.begin(), on_two_meshes_.end(), std::size_t{0});
    if (are_few_) {
      const std::vector<Effort> one_mesh(effort.size(), {false, 1});
      on_two_meshes_ =
          points_to_drag(known_.at(simulator_, experiments_at(placement_.points, one_mesh),
                                   experiments_, "press on one mesh"));
      for (const std::size_t p : on_two_meshes_) effort[p].is_dragged = true;
    }
    if ((are_few_ || !has_drags_) && wanted_.budget > first) {
      placement_.quick = try_quick(simulator_, placement_.points, effort, on_two_meshes_,
                                   experiments_, quick_error(), known_);
      for (std::size_t p = 0; p < effort.size(); ++p)
        if (!std::ranges::binary_search(on_two_meshes_, p))
          effort[p].scale = placement_.quick.number();
    }
    simulate(placement_.points);
    fit(nullptr);
    if (are_few_ && !are_rings()) {  // a few drags do not identify other families
      placement_.quick = {};
      std::fill(effort.begin(), effort.end(), Effort{true, 0});
      simulate(placement_.points);
      fit(nullptr);
    }
    press_alone_ = !has_drags_ || (are_few_ && are_rings());
    budget_ = press_alone_ ? wanted_.budget : std::min(wanted_.budget, 48);  // five times the time
  }

  bool are_rings() const { return curves_.curves.family == CurveFamily::rings; }
  double quick_error() const {
    if (scene_.experiments.force_tolerance > 0) return scene_.experiments.force_tolerance;
    return wanted_.tolerance > 0 ? wanted_.tolerance : PlacementSection{}.tolerance;
  }

  bool is_next_round() {
    if (!placement_.ended.empty()) return false;
    const auto count = static_cast<int>(placement_.points.position.rows());
    batch_ = std::min(round_size(count, static_cast<bool>(placement_.quick), rounds_within_ > 0),
                      budget_ - count);
    if (batch_ <= 0) placement_.ended = fmt::format("the budget of {} points is spent", budget_);
    return batch_ > 0;
  }

  RoundPrediction predict() const {
    RefineReport refined;
    Model model = refine(curves_, body_.surface, body_.in_region, placement_.points.triangles,
                         {.tool = fem::round_end(rigid_probe(scene_))}, &refined);
    std::vector<double> expected =
        expected_errors(curves_, model, refined, relative_floor_N(placement_.samples));
    return {std::move(model), std::move(expected)};
  }

  // None where the surface has no place left; the spacing halves before that.
  Grown choose_points(const RoundPrediction& predicted) {
    for (;; least_m_ /= 2) {
      Grown grown = grow(placement_.points, predicted.model,
                         choose(body_, placement_.points, predicted.model, predicted.expected_error,
                                batch_, wanted_.tolerance, least_m_));
      if (!grown.vertices.empty()) return grown;
      if (least_m_ <= 0.125 * contact_m_) break;
    }
    placement_.ended = fmt::format(
        "every vertex that can be reached is one, or nearer than {:.2g} mm to one", 1e3 * least_m_);
    return {};
  }

  void simulate(const TestPoints& points) {
    placement_.points = points;
    placement_.effort.resize(points.position.rows(), {!press_alone_, placement_.quick.number()});
    placement_.samples = known_.at(simulator_, experiments_at(points, placement_.effort),
                                   experiments_, "simulate", placement_.quick);
  }

  // Later rounds keep the first round's bases.
  void fit(const FittedCurves* before) {
    FitOptions options = fit_options(placement_.samples, scene_.fit, jobs_);
    options.warm_start = before;
    curves_ = fit_curves(placement_.samples, options);
  }

  void judge(const Model& model, const std::vector<std::int32_t>& vertices) {
    PlacementRound round = judge_round(placement_.samples, model, vertices, curves_.status);
    round.dragged = static_cast<int>(std::ranges::count_if(placement_.effort, &Effort::is_dragged));
    placement_.rounds.push_back(round);
    say("  {} points predict {} new ones to {} (median), {} (p95), {} (max); {} points are "
        "dragged{}",
        round.points, round.new_points, stated_percent(round.median_rel),
        stated_percent(round.p95_rel), stated_percent(round.max_rel), round.dragged,
        round.poor > 0 ? fmt::format("; {} poor ones do not count", round.poor) : "");
    const bool is_within = round.p95_rel <= wanted_.tolerance;
    rounds_within_ = is_within ? rounds_within_ + 1 : 0;
    points_within_ = is_within ? points_within_ + round.new_points - round.poor : 0;
    if (rounds_within_ >= 2 && points_within_ >= kJudged)
      placement_.ended = fmt::format("the tolerance of {:.3g} % is met", 100 * wanted_.tolerance);
  }

  void drag_last() {
    const std::vector<std::size_t> last = points_beyond_drags(placement_.samples, on_two_meshes_);
    for (const std::size_t p : last) placement_.effort[p] = {true, 0};
    if (!last.empty())
      say("  {} more are dragged, of whose force no upright dragged one tells", last.size());
  }

  const Scene& scene_;
  const Body& body_;
  const fem::SimulatorOf& simulator_;
  int jobs_;
  SampleCache& known_;
  const PlacementSection& wanted_;
  fem::Experiments experiments_;
  bool has_drags_, are_few_, press_alone_ = false;
  double contact_m_;
  // Spacing of test points, at first half the contact's radius: without it 120 of a hand's 200
  // points crowd in one web; all of it leaves 47 % in a dragon's hollow, where half leaves 26.
  // Halved where it leaves no vertex before the tolerance is met, down to an eighth.
  double least_m_;
  int budget_ = 0, batch_ = 0;
  int rounds_within_ = 0, points_within_ = 0;  // the last ones that met the tolerance
  std::vector<std::size_t> on_two_meshes_;
  FittedCurves curves_;
  Placement placement_;
};

}  // namespace

SimulateRequest request_for(const Scene& scene, const Body& body, Purpose purpose, int jobs,
                            const std::filesystem::path& output, bool resume) {
  std::string fingerprint = point_fingerprint(scene, body);
  if (purpose == Purpose::hold_out)
    fingerprint =
        ContentHash().add(fingerprint).add(fmt::format("{}", scene.validate.force_tolerance)).hex();
  return {.jobs = jobs,
          .output = output,
          .fingerprint = fingerprint,
          .tool = tool_fingerprint(scene, other_tools(scene, purpose)),
          .resume = resume,
          .surface_columns = surface_columns(scene, body)};
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
  std::vector<Effort> effort(points.position.rows(), {!each.drag_depths_m.empty(), 0});
  if (scene.experiments.placement) {
    Placement placement = PlacementRounds(scene, body, simulator, request.jobs, cache).run();
    points = std::move(placement.points);
    effort = std::move(placement.effort);
    quick = std::move(placement.quick);
    say_thin_parts(refused_points(scene, make_setup(scene, body), points).size(), points);
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

}  // namespace palpate::tools
