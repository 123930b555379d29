#include "libfit/fit/fit_report.hpp"

#include <algorithm>
#include <cmath>

#include "libfit/fit/spline/curve_band.hpp"
#include "libfit/fit/words.hpp"

namespace palpate::fit {
namespace {

std::vector<WorstPoint> worst_points(const FittedCurves& fitted,
                                     const std::vector<PointResult>& results, int count) {
  std::vector<WorstPoint> worst;
  for (std::size_t p = 0; p < results.size(); ++p) {
    if (!results[p].is_scored) continue;
    const PointScore& score = results[p].score;
    const auto at = static_cast<Eigen::Index>(p);
    std::string reason = "worst at row " + std::to_string(score.worst_row) + " of experiment " +
                         std::to_string(score.worst_experiment);
    if (!results[p].message.empty()) add_sentence(reason, results[p].message);
    worst.push_back({at, fitted.name[p], fitted.position.row(at), score.relative, score.rms_N,
                     score.max_N, reason});
  }
  std::stable_sort(worst.begin(), worst.end(), [](const WorstPoint& a, const WorstPoint& b) {
    return a.relative_residual > b.relative_residual;
  });
  if (worst.size() > static_cast<std::size_t>(std::max(count, 0)))
    worst.resize(static_cast<std::size_t>(std::max(count, 0)));
  return worst;
}

// Relative bands where each curve's rows end: past that it is extrapolated.
void report_bands(const FittedCurves& fitted, FitReport& report) {
  for (std::size_t kind = 0; kind < curves_of(fitted.curves.family); ++kind) {
    const SplineTables tables = tabulate(fitted.curves.basis[kind]);
    const auto spline = view(tables);
    std::vector<double> bands;
    for (Eigen::Index at = 0; at < fitted.position.rows(); ++at) {
      const double end = fitted.scores.curve_end_m(at, static_cast<Eigen::Index>(kind));
      if (!fitted.covariance[kind].row(at).allFinite() || std::isnan(end)) continue;
      const Eigen::VectorXd covariance = fitted.covariance[kind].row(at);
      const double value =
          runtime::curve_value(spline, fitted.curves.control[kind].row(at).data(), end);
      if (!(value > 0)) continue;
      bands.push_back(kBand90 * curve_deviation(spline, covariance, end) / value);
      if (bands.back() > report.widest_band[kind] || report.widest_point[kind] < 0)
        report.widest_band[kind] = bands.back(), report.widest_point[kind] = at;
    }
    report.median_band[kind] = median(std::move(bands));
  }
}

}  // namespace

FitReport make_report(std::size_t rows, const BodyBases& bases, const FittedCurves& fitted,
                      const std::vector<PointResult>& results, int count) {
  FitReport report;
  report.kind = bases.report;
  report.worst = worst_points(fitted, results, count);
  for (const PointResult& result : results) report.kept += result.is_kept;
  for (const FitStatus status : fitted.status) {
    report.good += status == FitStatus::good;
    report.underdetermined += status == FitStatus::underdetermined;
    report.poor += status == FitStatus::poor;
    report.failed += status == FitStatus::failed;
  }
  report.rows = rows;
  for (const PointResult& result : results) {
    report.rows_used += static_cast<std::size_t>(result.rows.used);
    report.rows_not_good += static_cast<std::size_t>(result.rows.not_good);
    report.rows_not_finite += static_cast<std::size_t>(result.rows.not_finite);
    report.rows_cut += static_cast<std::size_t>(result.rows.cut);
  }
  std::vector<double> errors;
  for (const PointResult& result : results)
    errors.insert(errors.end(), result.score.relative_errors.begin(),
                  result.score.relative_errors.end());
  report.median_relative_error = median(errors);
  report.p95_relative_error = quantile(errors, 0.95);
  report.max_relative_error = quantile(errors, 1);
  report_bands(fitted, report);
  return report;
}

}  // namespace palpate::fit
