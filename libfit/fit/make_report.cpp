#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "libfit/core/curves.hpp"
#include "libfit/core/stated_error.hpp"
#include "libfit/core/statistics.hpp"
#include "libfit/core/text.hpp"
#include "libfit/fit/fit_steps.hpp"

namespace palpate::fit {
namespace {

constexpr double kWorthIt = 0.9;  // of the error without a sway

// The point with the rows of one parity weightless.
PointData without_rows(PointData point, std::size_t parity) {
  for (PointExperiment& e : point.experiments)
    for (std::size_t i = parity; i < e.row.size(); i += 2) e.weight[i] = 0;
  return point;
}

double largest_force(const PointData& point) {
  double largest = 0;
  for (const PointExperiment& e : point.experiments)
    for (const Vec3& force : e.force) largest = std::max(largest, force.norm());
  return largest;
}

// Appends the relative errors of the rows of one parity.
void add_errors(const PointData& point, const Bases& bases, const PointCurves& curves,
                std::size_t parity, std::vector<double>& errors) {
  std::vector<std::vector<double>> control;
  for (std::size_t kind = 0; kind < curves_of(bases.family); ++kind) {
    const Eigen::VectorXd values = controls_of(curves.increments[kind]);
    control.emplace_back(values.begin(), values.end());
  }
  each_other_part(bases.family, [&](std::size_t, const runtime::Part& part, int at) {
    control.push_back(
        part_controls<double>(part, quadric_of(point), curves.constants.data() + at, point.sway));
  });
  const LocalCurves local{&bases, pointers_to<double>(control), quadric_of(point)};
  const double floor = relative_floor(largest_force(point));
  for (std::size_t k = 0; k < point.experiments.size(); ++k) {
    const PointExperiment& e = point.experiments[k];
    Points path(e.row.size(), 3);
    for (std::size_t i = 0; i < e.row.size(); ++i) path.row(i) = e.tool_deflection(i);
    const Points answer = local_answer(local, path, nullptr, curves.nuisance[k]).force;
    for (std::size_t i = parity; i < e.row.size(); i += 2) {
      const Vec3 difference = Vec3(answer.row(i)) - e.force[i];
      errors.push_back(relative_error(difference.norm(), e.force[i].norm(), floor));
    }
  }
}

std::vector<WorstPoint> worst_points(const FittedCurves& fitted,
                                     const std::vector<PointResult>& results) {
  std::vector<WorstPoint> worst;
  for (std::size_t p = 0; p < results.size(); ++p) {
    if (!results[p].is_scored) continue;
    const PointScore& score = results[p].score;
    std::string reason =
        fmt::format("worst at row {} of experiment {}", score.worst_row, score.worst_experiment);
    if (!fitted.message[p].empty()) add_sentence(reason, fitted.message[p]);
    worst.push_back({Eigen::Index(p), fitted.name[p], fitted.position.row(p), score.relative,
                     score.rms_N, score.max_N, reason});
  }
  std::stable_sort(worst.begin(), worst.end(), [](const WorstPoint& a, const WorstPoint& b) {
    return a.relative_residual > b.relative_residual;
  });
  worst.resize(std::min<std::size_t>(worst.size(), 3));
  return worst;
}

// Names the curves that points without a drag have from theory; empty where all have a drag.
std::string assumed_curves(const std::vector<CurveRows>& rows, const BodyBases& bases,
                           const std::vector<PointResult>& results, const FitOptions& options) {
  const auto scored = std::ranges::count_if(results, &PointResult::is_scored);
  std::ptrdiff_t pressed = 0;
  for (std::size_t p = 0; p < rows.size(); ++p)
    pressed += results[p].is_scored && rows[p].drags == 0;
  if (pressed == 0 || bases.rings.is_of_drags) return "";
  const std::string where = pressed == scored
                                ? "no point was dragged"
                                : fmt::format("{} of {} points were not dragged", pressed, scored);
  const bool are_rings = bases.family == CurveFamily::rings;
  const double lateral =
      are_rings ? std::exp(bases.rings.constant[0]) : options.default_lateral_ratio;
  const double friction = are_rings ? bases.rings.constant[1] : options.default_friction;
  return where + ": there the lateral stiffness is " + number(lateral) +
         " of the normal one and the limit of friction " + number(friction) +
         " of the normal force" +
         (are_rings ? ", as theory has them" : ", or just above what held in a press");
}

}  // namespace

FamilyEvidence judge_family(const BodyData& body, const std::vector<CurveRows>& rows,
                            const BodyBases& bases, const FitOptions& options) {
  const Bases plain(bases.plain, bases.family);
  std::vector<double> errors;
  // Presses of the families hardly differ: where some points are dragged, these judge.
  std::vector<std::size_t> judges, dragged;
  for (std::size_t p = 0; p < body.points.size(); ++p) {
    if (!body.points[p].problem.empty()) continue;
    judges.push_back(p);
    if (rows[p].drags > 0) dragged.push_back(p);
  }
  if (!dragged.empty()) judges = dragged;
  const std::size_t stride = (judges.size() + 23) / 24;
  for (std::size_t i = 0; i < judges.size(); i += std::max<std::size_t>(stride, 1)) {
    const std::size_t p = judges[i];
    for (const std::size_t parity : {0U, 1U}) {
      const PointData fitted = without_rows(body.points[p], parity);
      const PointCurves curves = identify(fitted, rows[p], bases, plain, options);
      if (curves.problem.empty()) add_errors(fitted, plain, curves, parity, errors);
    }
  }
  return {median(errors), lower_quantile(errors, 0.95), errors.size()};
}

bool predicts_better(const FamilyEvidence& without, const FamilyEvidence& with) {
  // A sway that takes more than the deflection off leaves points without rows.
  if (double(with.rows) < kWorthIt * double(without.rows)) return false;
  const bool has_lower_p95 =
      with.p95_error < kWorthIt * without.p95_error && with.median_error <= without.median_error;
  const bool has_lower_median = with.median_error < kWorthIt * without.median_error &&
                                kWorthIt * with.p95_error <= without.p95_error;
  return has_lower_p95 || has_lower_median;
}

RingPoint ring_point(double log_force, const double* constant, const double* error) {
  RingPoint out{log_force};
  std::copy_n(constant, out.constant.size(), out.constant.begin());
  std::copy_n(error, out.error.size(), out.error.begin());
  out.error[0] /= out.constant[0];  // of the logarithm
  out.constant[0] = std::log(out.constant[0]);
  return out;
}

RingPrior ring_lines(const std::vector<RingPoint>& points, const RingConstants& deviation,
                     const std::optional<RingConstants>& theory) {
  RingPrior out;
  out.is_of_drags = true;
  out.deviation = deviation;
  std::vector<double> log_force;
  for (const RingPoint& point : points) log_force.push_back(point.log_force);
  out.log_force = median(log_force);
  // Weight of a point, 1 without error.
  const auto weight = [&](const RingPoint& point, std::size_t k) {
    return 1 / (1 + std::pow(point.error[k] / deviation[k], 2));
  };
  double square = 0;
  std::vector<double> slopes, pair_weight;
  for (std::size_t i = 0; i < points.size(); ++i) {
    square += weight(points[i], 0) * std::pow(log_force[i] - out.log_force, 2);
    for (std::size_t j = 0; j < i; ++j)
      // Pairs that are closer determine no slope.
      if (const double apart = log_force[i] - log_force[j]; std::abs(apart) > 0.05) {
        slopes.push_back((points[i].constant[0] - points[j].constant[0]) / apart);
        pair_weight.push_back(1 / (1 / weight(points[i], 0) + 1 / weight(points[j], 0)));
      }
  }
  // The slope counts half at a sum of squares of 0.01: slides over stiff inclusions err by 5.3 and
  // 6.3 % (p95) there, at half and at twice that, by 5.4 and 7.1 at 0.05.
  out.slope = weighted_median(slopes, pair_weight) * square / (square + 0.01);
  for (std::size_t k = 0; k < deviation.size(); ++k) {
    std::vector<double> weights, level;
    for (const RingPoint& point : points) {
      weights.push_back(weight(point, k));
      level.push_back(point.constant[k]);
      if (k == 0) level.back() -= out.slope * (point.log_force - out.log_force);
    }
    out.constant[k] = weighted_median(level, weights);
    const double known = std::accumulate(weights.begin(), weights.end(), 0.0);
    if (theory) out.constant[k] += ((*theory)[k] - out.constant[k]) / (1 + known);
  }
  return out;
}

FitReport make_report(const BodyData& body, const std::vector<CurveRows>& rows,
                      const BodyBases& bases, const FittedCurves& fitted,
                      const std::vector<PointResult>& results, const FitOptions& options) {
  FitReport report;
  report.kind = bases.report;
  report.assumed = assumed_curves(rows, bases, results, options);
  report.worst = worst_points(fitted, results);
  for (const FitStatus status : fitted.status) {
    report.points.good += status == FitStatus::good;
    report.points.underdetermined += status == FitStatus::underdetermined;
    report.points.poor += status == FitStatus::poor;
    report.points.failed += status == FitStatus::failed;
  }
  for (const PointData& point : body.points) {
    report.rows.used += point.rows.used;
    report.rows.not_good += point.rows.not_good;
    report.rows.not_finite += point.rows.not_finite;
    report.rows.cut += point.rows.cut;
  }
  std::vector<ForceError> scored;
  for (const PointResult& result : results)
    scored.insert(scored.end(), result.score.rows.begin(), result.score.rows.end());
  report.error = relative_errors(scored);
  return report;
}

}  // namespace palpate::fit
