#include "libfit/fit/collect.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <limits>

#include "libfit/core/stated_error.hpp"
#include "libfit/core/text.hpp"
#include "libfit/fit/point/nuisance.hpp"
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
    const auto at = static_cast<Eigen::Index>(p);
    std::string reason =
        fmt::format("worst at row {} of experiment {}", score.worst_row, score.worst_experiment);
    if (!results[p].message.empty()) add_sentence(reason, results[p].message);
    worst.push_back({at, fitted.name[p], fitted.position.row(at), score.relative, score.rms_N,
                     score.max_N, reason});
  }
  std::stable_sort(worst.begin(), worst.end(), [](const WorstPoint& a, const WorstPoint& b) {
    return a.relative_residual > b.relative_residual;
  });
  worst.resize(std::min(worst.size(), kWorstPoints));
  return worst;
}

// What points without a drag got of the curves that presses do not tell; empty where all have one.
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
    for (Eigen::Index at = 0; at < fitted.position.rows(); ++at) {
      const std::vector<CurveRow>& own = rows[static_cast<std::size_t>(at)].curve[kind];
      if (!fitted.covariance[kind].row(at).allFinite() || own.empty()) continue;
      double end = 0;
      for (const CurveRow& row : own) end = std::max(end, row.x * length_m);
      const Eigen::VectorXd covariance = fitted.covariance[kind].row(at);
      const double value =
          runtime::curve_value(spline, fitted.curves.control[kind].row(at).data(), end);
      if (!(value > 0)) continue;
      bands.push_back(kBand90 * curve_deviation(spline, covariance, end) / value);
      if (bands.back() > report.bands.widest[kind] || report.bands.widest_point[kind] < 0)
        report.bands.widest[kind] = bands.back(), report.bands.widest_point[kind] = at;
    }
    report.bands.median[kind] = median(std::move(bands));
  }
}

// Depth of the first row of a press, of most points.
double first_row_m(const BodyData& body) {
  std::vector<double> first;
  for (const PointData& point : body.points) {
    double least = 0;
    for (const PointExperiment& e : point.experiments) {
      if (e.kind != ExperimentKind::press) continue;
      for (const Vec3& deflection : e.deflection)
        if (const double d = depth_of(point, deflection); d > 0 && (least == 0 || d < least))
          least = d;
    }
    if (least > 0) first.push_back(least * body.length_m);
  }
  return first.empty() ? 0 : median(first);
}

}  // namespace

FittedCurves collect_curves(const Samples& samples, const BodyData& body, const BodyBases& bases,
                            const std::vector<PointResult>& results) {
  const Eigen::Index points = samples.points();
  FittedCurves out;
  out.position = samples.point_position;
  out.normal = samples.point_normal;
  out.name = samples.point_name;
  out.curves = CurveSet(bases.family);
  out.curves.basis = bases.si;
  if (bases.family == CurveFamily::rings) out.curves.relaxation = samples.relaxation;
  out.curves.first_row_m = first_row_m(body);
  const auto parts = parts_of(bases.family);
  for (std::size_t i = 0; i < parts.size(); ++i)
    out.curves.control[i].resize(points, parts[i].width * size_of(parts[i], bases.si[i]));
  for (std::size_t kind = 0; kind < curves_of(bases.family); ++kind)
    out.covariance[kind].resize(points, packed_size(bases.si[kind].size() - 1));
  out.deviation.resize(parts.size());
  for (std::size_t i = 0; i < parts.size(); ++i)
    if (has_deviation(parts[i])) out.deviation[i].resize(points, out.curves.control[i].cols());
  out.depth_range_m.setZero(points);
  for (Eigen::Index p = 0; p < points; ++p) {
    const PointResult& result = results[static_cast<std::size_t>(p)];
    for (std::size_t i = 0; i < parts.size(); ++i) out.curves.control[i].row(p) = result.control[i];
    for (std::size_t kind = 0; kind < curves_of(bases.family); ++kind)
      out.covariance[kind].row(p) = result.covariance[kind];
    for (std::size_t i = 0; i < parts.size(); ++i)
      if (has_deviation(parts[i])) out.deviation[i].row(p) = result.deviation[i];
    out.status.push_back(result.status);
    out.message.push_back(result.message);
    out.depth_range_m[p] = body.points[static_cast<std::size_t>(p)].depth_m;
  }
  out.recordings = collect_nuisances(body, results);
  return out;
}

void collect_residuals(const std::vector<PointResult>& results, FittedCurves& fitted) {
  fitted.rms_residual_N.setConstant(static_cast<Eigen::Index>(results.size()),
                                    std::numeric_limits<double>::quiet_NaN());
  fitted.max_residual_N = fitted.rms_residual_N;
  for (std::size_t p = 0; p < results.size(); ++p) {
    if (!results[p].is_scored) continue;
    fitted.rms_residual_N[static_cast<Eigen::Index>(p)] = results[p].score.rms_N;
    fitted.max_residual_N[static_cast<Eigen::Index>(p)] = results[p].score.max_N;
  }
}

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
    report.rows.used += static_cast<std::size_t>(point.rows.used);
    report.rows.not_good += static_cast<std::size_t>(point.rows.not_good);
    report.rows.not_finite += static_cast<std::size_t>(point.rows.not_finite);
    report.rows.cut += static_cast<std::size_t>(point.rows.cut);
  }
  std::vector<ForceError> scored;
  for (const PointResult& result : results)
    scored.insert(scored.end(), result.score.rows.begin(), result.score.rows.end());
  const std::vector<double> errors = stated_errors(scored);
  report.error.median = median(errors);
  report.error.p95 = quantile(errors, 0.95);
  report.error.max = quantile(errors, 1);
  report_bands(fitted, rows, body.length_m, report);
  return report;
}

}  // namespace palpate::fit
