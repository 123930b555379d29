#include <algorithm>

#include "libfit/core/stated_error.hpp"
#include "libfit/core/statistics.hpp"
#include "libfit/fit/fit_steps.hpp"
#include "libfit/fit/point/local_curves.hpp"

namespace palpate::fit {
namespace {

constexpr std::size_t kMaxPoints = 24;
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
        part_controls<double>(part, quadric_of(point), curves.more.data() + at, point.sway));
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

}  // namespace

FamilyEvidence judge_family(const BodyData& body, const std::vector<CurveRows>& rows,
                            const BodyBases& bases, const FitOptions& options) {
  const Bases plain = plain_bases(bases);
  std::vector<double> errors;
  // A press tells families hardly apart: where some points are dragged, these judge.
  std::vector<std::size_t> judges, dragged;
  for (std::size_t p = 0; p < body.points.size(); ++p) {
    if (!body.points[p].problem.empty()) continue;
    judges.push_back(p);
    if (rows[p].drags > 0) dragged.push_back(p);
  }
  if (!dragged.empty()) judges = dragged;
  const std::size_t stride = (judges.size() + kMaxPoints - 1) / kMaxPoints;
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

bool improves_by_sway(const FamilyEvidence& without, const FamilyEvidence& with) {
  // A sway that takes more than the deflection off leaves points without rows.
  if (double(with.rows) < kWorthIt * double(without.rows)) return false;
  const bool has_lower_p95 =
      with.p95_error < kWorthIt * without.p95_error && with.median_error <= without.median_error;
  const bool has_lower_median = with.median_error < kWorthIt * without.median_error &&
                                kWorthIt * with.p95_error <= without.p95_error;
  return has_lower_p95 || has_lower_median;
}

}  // namespace palpate::fit
