#include "libfit/recordings/indentation/fit_model.hpp"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "libfit/recordings/indentation/solve_model.hpp"

namespace palpate::recordings {
namespace {

constexpr double kSame = 2;  // bic within which models are equals

double square(double x) { return x * x; }

// Deviations with the choice whether the free part slopes, each counted with its bic.
void hold_slope(const SolvedModel& tilted, double rows, SolvedModel& flat) {
  const double readings = std::max(8., rows / tilted.correlation_time);
  const double better =  // bic
      readings * std::log(flat.squares / std::max(tilted.squares, 1e-300)) - std::log(readings);
  const double share = 1 / (1 + std::exp(-better / 2));
  const auto held = [&](double value, double deviation, double other, double of_other) {
    return std::max(deviation, std::sqrt((1 - share) * square(deviation) +
                                         share * (square(of_other) + square(other - value))));
  };
  ModelFit& fit = flat.fit;
  const ModelFit& other = tilted.fit;
  fit.young_deviation_Pa =
      held(fit.young_Pa, fit.young_deviation_Pa, other.young_Pa, other.young_deviation_Pa);
  fit.contact_deviation_m =
      held(fit.contact_m, fit.contact_deviation_m, other.contact_m, other.contact_deviation_m);
}

}  // namespace

std::vector<ModelFit> fit_models(const Eigen::VectorXd& travel_m, const Eigen::VectorXd& push_N,
                                 const Indentation& press, const std::vector<std::string>& names,
                                 const ModelFitOptions& options) {
  ModelProblem p;
  Eigen::Index rows = travel_m.size();
  const double first_N = push_N.head(std::max<Eigen::Index>(1, rows / 10)).mean();
  if (options.force_share > 0 && options.force_share < 1) {
    const double limit_N = first_N + options.force_share * (push_N.maxCoeff() - first_N);
    rows = 0;
    while (rows < travel_m.size() && (push_N[rows] <= limit_N || rows < 8)) ++rows;
  }
  p.first_m = travel_m.head(rows).minCoeff();
  p.range_m = travel_m.head(rows).maxCoeff() - p.first_m;
  p.base_N = first_N;
  p.rise_N = push_N.head(rows).maxCoeff() - first_N;
  if (!(p.range_m > 0) || !(p.rise_N > 0)) return {};
  p.x = (travel_m.head(rows).array() - p.first_m) / p.range_m;
  p.y = (push_N.head(rows).array() - p.base_N) / p.rise_N;
  if (options.contact_m) p.contact = (*options.contact_m - p.first_m) / p.range_m;

  std::vector<SolvedModel> solved;
  for (const IndentationModel& model : indentation_models()) {
    if (!names.empty() && std::ranges::find(names, model.name) == names.end()) continue;
    if (!model.is_admissible(press)) continue;
    p.law = model.law ? model.law(press) : ModelLaw{};
    p.area_scale = 1;
    if (p.law)  // past the range of a table half of it serves
      for (double share = 1; share > 1e-6; share /= 2)
        if (const double area = p.law(share * p.range_m).area_m2; std::isfinite(area)) {
          p.area_scale = area;
          break;
        }
    p.has_slope = options.has_slope;
    auto found = solve_model(p, model, press);
    if (!found) continue;
    p.has_slope = true;
    if (!options.has_slope && model.law)
      if (const auto tilted = solve_model(p, model, press))
        hold_slope(*tilted, static_cast<double>(rows), *found);
    solved.push_back(std::move(*found));
  }
  if (solved.empty()) return {};
  const auto best = std::ranges::min_element(solved, {}, &SolvedModel::squares);
  const double readings = std::max(8., static_cast<double>(rows) / best->correlation_time);
  double least = std::numeric_limits<double>::infinity();
  for (SolvedModel& s : solved) {
    s.fit.bic = readings * std::log(std::max(s.squares, 1e-300)) +
                static_cast<double>(s.unknowns) * std::log(readings);
    least = std::min(least, s.fit.bic);
  }
  std::vector<ModelFit> fits;
  for (SolvedModel& s : solved) {
    s.fit.bic -= least;
    fits.push_back(std::move(s.fit));
  }
  return fits;
}

std::vector<std::vector<ModelFit>> fit_all(const std::vector<ModelFitTask>& tasks,
                                           const std::vector<std::string>& names, int jobs) {
  constexpr Eigen::Index kLeastReadings = 8;
  std::vector<std::vector<ModelFit>> fits(tasks.size());
  tbb::task_arena arena(jobs > 0 ? jobs : tbb::task_arena::automatic);
  arena.execute([&] {
    tbb::parallel_for(std::size_t{0}, tasks.size(), [&](std::size_t i) {
      const ModelFitTask& task = tasks[i];
      if (task.travel_m->size() >= kLeastReadings)
        fits[i] = fit_models(*task.travel_m, *task.push_N, task.press, names, task.options);
    });
  });
  return fits;
}

Eigen::VectorXd model_push_N(const ModelFit& fit, const Indentation& press,
                             const Eigen::VectorXd& travel_m) {
  const ModelLaw law = fit.model->law ? fit.model->law(press) : ModelLaw{};
  const double modulus_Pa = fit.young_Pa / (1 - square(press.poisson));
  return travel_m.unaryExpr([&](double travel) {
    const double depth_m = travel - fit.contact_m,
                 free_N = fit.baseline_N + fit.slope_N_m * depth_m;
    if (!(depth_m > 0)) return free_N;
    return free_N + (law ? modulus_Pa * law(depth_m).area_m2
                         : fit.force_N * std::pow(depth_m / fit.depth_m, fit.exponent));
  });
}

std::optional<std::size_t> best_model(const std::vector<ModelFit>& fits) {
  const bool any_holds = std::ranges::any_of(
      fits, [](const ModelFit& fit) { return fit.model->law && !fit.is_beyond; });
  std::optional<std::size_t> best;
  for (std::size_t i = 0; i < fits.size(); ++i)
    if (fits[i].model->law && !(any_holds && fits[i].is_beyond) &&
        (!best || fits[i].bic < fits[*best].bic - kSame))
      best = i;
  return best;
}

double chosen_deviation_Pa(const std::vector<ModelFit>& fits, std::size_t best) {
  double weights = 0, squares = 0;
  for (const ModelFit& fit : fits) {
    if (!fit.model->law || fit.is_beyond) continue;
    const double weight = std::exp((fits[best].bic - fit.bic) / 2);
    weights += weight;
    squares +=
        weight * (square(fit.young_deviation_Pa) + square(fit.young_Pa - fits[best].young_Pa));
  }
  return weights > 0 ? std::max(fits[best].young_deviation_Pa, std::sqrt(squares / weights))
                     : fits[best].young_deviation_Pa;
}

}  // namespace palpate::recordings
