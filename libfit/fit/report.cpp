#include <fmt/core.h>

#include <algorithm>

#include "libfit/core/stated_error.hpp"
#include "libfit/core/text.hpp"
#include "libfit/fit/fit_steps.hpp"
#include "libfit/fit/spline/curve_band.hpp"

namespace palpate::fit {
namespace {

constexpr std::size_t kWorstPoints = 3;  // that are named

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
  worst.resize(std::min(worst.size(), kWorstPoints));
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
  if (bases.family == CurveFamily::rings) return where + ": rings are as theory has them";
  return where + ": there the lateral curve is a line of " + number(options.default_lateral_ratio) +
         " of the normal stiffness at full depth and the limit " +
         number(options.default_friction) +
         " of the normal force, or just above what held in a press";
}

// Relative bands where each curve's rows end: past that it is extrapolated.
void report_bands(const FittedCurves& fitted, const std::vector<CurveRows>& rows, double length_m,
                  FitReport& report) {
  for (std::size_t kind = 0; kind < curves_of(fitted.curves.family); ++kind) {
    const SplineTables tables = tabulate(fitted.curves.basis[kind]);
    const auto spline = view(tables);
    std::vector<double> bands;
    for (Eigen::Index p = 0; p < fitted.position.rows(); ++p) {
      const std::vector<CurveRow>& own = rows[p].curve[kind];
      if (!fitted.covariance[kind].row(p).allFinite() || own.empty()) continue;
      double end = 0;
      for (const CurveRow& row : own) end = std::max(end, row.x * length_m);
      const Eigen::VectorXd covariance = fitted.covariance[kind].row(p);
      const double value =
          runtime::curve_value(spline, fitted.curves.control[kind].row(p).data(), end);
      if (!(value > 0)) continue;
      bands.push_back(kBand90 * curve_deviation(spline, covariance, end) / value);
      if (bands.back() > report.bands.widest[kind] || report.bands.widest_point[kind] < 0)
        report.bands.widest[kind] = bands.back(), report.bands.widest_point[kind] = p;
    }
    report.bands.median[kind] = median(std::move(bands));
  }
}

}  // namespace

FitReport make_report(const BodyData& body, const std::vector<CurveRows>& rows,
                      const BodyBases& bases, const FittedCurves& fitted,
                      const std::vector<PointResult>& results, const FitOptions& options) {
  FitReport report;
  report.kind = bases.report;
  report.assumed = assumed_curves(rows, bases, results, options);
  report.worst = worst_points(fitted, results);
  for (const PointResult& result : results) report.points.kept += result.is_kept;
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
  report_bands(fitted, rows, body.length_m, report);
  return report;
}

}  // namespace palpate::fit

namespace palpate {

RelativeErrors relative_errors(const std::vector<ForceError>& rows) {
  const std::vector<double> errors = stated_errors(rows);
  return {median(errors), quantile(errors, 0.95), quantile(errors, 1)};
}

}  // namespace palpate
