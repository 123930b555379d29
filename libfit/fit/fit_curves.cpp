#include "libfit/fit/fit_curves.hpp"

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <map>
#include <mutex>

#include "libfit/core/error.hpp"
#include "libfit/fit/choose_basis.hpp"
#include "libfit/fit/choose_family.hpp"
#include "libfit/fit/curve_band.hpp"
#include "libfit/fit/fit_point.hpp"
#include "libfit/fit/rows_hash.hpp"
#include "libfit/fit/sensors.hpp"
#include "libfit/fit/smooth_curves.hpp"
#include "libfit/fit/words.hpp"

namespace palpate {
namespace {

using fit::BodyBases;
using fit::PointResult;

constexpr int kSensorRounds = 2;  // a second round moves contact points by less than their errors

template <class Act>
void parallel_for(int wanted, std::size_t count, const Act& act) {
  const int jobs = wanted > 0 ? wanted : tbb::this_task_arena::max_concurrency();
  // Without it TBB grants at most a thread per core and prints a warning about the rest.
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<std::size_t>(jobs));
  tbb::task_arena arena(jobs);
  arena.execute([&] { tbb::parallel_for(std::size_t{0}, count, act); });
}

void require(bool holds, const char* option, const char* fact, const char* remedy) {
  if (!holds) throw Error(option, fact, remedy);
}

void check(const FitOptions& o) {
  require(o.degree >= 1 && o.degree <= 4, "fit option degree", "is not 1 to 4",
          "Choose a degree of 1, 2, 3 or 4.");
  for (const int pieces : o.pieces)
    require(pieces >= 0 && pieces <= 256, "fit option pieces", "is not 0 to 256",
            "Give a number of pieces, or 0 to have it chosen.");
  require(o.most_pieces >= 1 && o.most_pieces <= 256, "fit option most_pieces", "is not 1 to 256",
          "Allow at least one piece.");
  require(o.tolerance >= 0 && o.tolerance < 1, "fit option tolerance", "is not in [0, 1)",
          "Give a relative error such as 0.02.");
  require(o.poor_above > 0, "fit option poor_above", "is not above 0",
          "Give a relative error such as 0.07.");
  require(o.weight_floor > 0 && o.weight_floor < 1, "fit option weight_floor", "is not in (0, 1)",
          "Give a fraction of the typical force such as 0.001.");
  require(o.default_friction > 0 && std::isfinite(o.default_friction),
          "fit option default_friction", "is not above 0", "Give a friction such as 0.3.");
  require(o.default_lateral_ratio > 0 && std::isfinite(o.default_lateral_ratio),
          "fit option default_lateral_ratio", "is not above 0", "Give a ratio such as 0.67.");
  require(o.contact_deviation_m >= 0 && std::isfinite(o.contact_deviation_m),
          "fit option contact_deviation", "is negative", "Give a length such as 0.1 mm, or 0.");
  require(o.sensor_deviation > 0 && std::isfinite(o.sensor_deviation),
          "fit option sensor_deviation", "is not above 0",
          "Give a share of the force such as 0.05.");
  require(!o.smoothing || (*o.smoothing >= 0 && *o.smoothing <= kStrongestSmoothing),
          "fit option smoothing", "is not 0 to 1e12", "Give 0 for none, or a number such as 100.");
  require(o.jobs >= 0, "fit option jobs", "is negative", "Give a number of threads, or 0 for all.");
}

BodyBases make_bases(const fit::BodyData& body, std::vector<fit::PointRows>& rows,
                     const FitOptions& options) {
  BodyBases bases;
  bases.report = fit::choose_bases(body, rows, options);
  for (std::size_t kind = 0; kind < kCurveKinds; ++kind) {
    bases.plain[kind] = bases.si[kind] = bases.report[kind].basis;
    for (double& knot : bases.si[kind].knots_m) knot *= body.length_m;
    if (!options.knots_m[kind].empty()) bases.si[kind].knots_m = options.knots_m[kind];
    bases.report[kind].basis = bases.si[kind];
  }
  bases.lean_plain.knots_m = {0, bases.plain[0].knots_m.back()};  // a parabola over the depth
  bases.lean_si.knots_m = {0, bases.si[0].knots_m.back()};
  return bases;
}

// Bases chosen again from rows as they are without what sensors add, found on the bases so far; and
// those rows. Nothing changes where all is known of sensors.
void settle_sensors(const fit::BodyData& body, const FitOptions& options,
                    std::vector<fit::PointRows>& rows, BodyBases& bases) {
  if (!fit::has_unknown_sensors(body)) return;
  for (int round = 0; round < kSensorRounds; ++round) {
    const fit::Bases plain(bases.plain);
    BodyBases separable = bases;
    separable.lean_plain.knots_m.clear();
    std::vector<fit::PointRows> corrected(rows.size());
    parallel_for(options.jobs, rows.size(), [&](std::size_t p) {
      const fit::PointData& point = body.points[p];
      if (!point.problem.empty()) return;
      const fit::PointCurves found = fit::identify(point, rows[p], separable, plain, options);
      corrected[p] = fit::curve_rows(
          found.problem.empty() ? fit::without_sensors(point, found.sensor) : point);
    });
    rows = std::move(corrected);
    bases = make_bases(body, rows, options);
  }
}

// The family asked for or, by evidence, the one the body needs; rows and bases are left as it has
// them.
FamilyReport settle_family(const fit::BodyData& body, const FitOptions& options,
                           std::vector<fit::PointRows>& rows, BodyBases& bases) {
  fit::FamilySetting uncoupled{std::move(rows), std::move(bases)}, coupled;
  const auto setting = [&](bool is_coupled) -> const fit::FamilySetting& {
    if (!is_coupled) return uncoupled;
    if (!coupled.rows.empty()) return coupled;
    for (const fit::PointRows& point : uncoupled.rows)
      coupled.rows.push_back(fit::coupled_rows(point, uncoupled.bases.plain[0].knots_m.back()));
    coupled.bases = make_bases(body, coupled.rows, options);
    coupled.bases.is_coupled = true;
    return coupled;
  };
  FamilyReport report = options.family ? FamilyReport{*options.family, {}, "as asked"}
                                       : fit::choose_family(body, setting, options);
  const fit::FamilySetting& chosen = setting(is_coupled(report.family));
  if (options.family && options.judges_family)
    report.evidence.push_back(fit::judge_family(body, chosen, report.family, options));
  rows = chosen.rows;
  bases = chosen.bases;
  if (!leans(report.family)) {
    bases.lean_plain.knots_m.clear();
    bases.lean_si.knots_m.clear();
  }
  return report;
}

// Rows of an earlier fit by what they were fitted from.
std::map<std::string, Eigen::Index> earlier_points(const FittedCurves* earlier) {
  std::map<std::string, Eigen::Index> row;
  if (earlier != nullptr && earlier->covariance[0].size() > 0)
    for (std::size_t p = 0; p < earlier->rows_hash.size(); ++p)
      row.emplace(earlier->rows_hash[p], static_cast<Eigen::Index>(p));
  return row;
}

// Bases and family as the earlier fit had them.
FitOptions as_before(FitOptions options) {
  const CurveSet& curves = options.warm_start->curves;
  options.degree = curves.basis[0].degree;
  for (std::size_t kind = 0; kind < kCurveKinds; ++kind) {
    require(curves.basis[kind].degree == options.degree, "warm start",
            "has curves of several degrees", "Fit without a warm start.");
    options.knots_m[kind] = curves.basis[kind].knots_m;
  }
  options.family = curves.family();
  return options;
}

std::vector<PointResult> fit_points(const Samples& samples, const fit::BodyData& body,
                                    const std::vector<fit::PointRows>& rows, const BodyBases& bases,
                                    const FitOptions& options, const Progress& progress) {
  const fit::Bases plain(bases.plain, bases.lean_plain, bases.is_coupled);
  const fit::Bases si(bases.si, bases.lean_si, bases.is_coupled);
  const auto earlier = earlier_points(options.warm_start);
  std::vector<PointResult> results(body.points.size());
  std::mutex mutex;
  std::size_t done = 0;
  const auto fit_one = [&](std::size_t p) {
    if (progress.stopped()) {
      results[p] = fit::no_curves(bases, "stopped before this point was fitted");
      return;
    }
    const std::string hash = fit::rows_hash(samples, static_cast<Eigen::Index>(p), body.points[p],
                                            body.length_m, options);
    const auto found = earlier.find(hash);
    results[p] = found != earlier.end() ? fit::keep_point(samples, body.points[p], body.length_m,
                                                          si, *options.warm_start, found->second)
                                        : fit::fit_point(samples, body.points[p], rows[p],
                                                         body.length_m, bases, plain, si, options);
    results[p].rows_hash = hash;
    const std::lock_guard lock(mutex);
    progress.report(++done, results.size(), samples.point_name[p]);
  };
  parallel_for(options.jobs, results.size(), fit_one);
  return results;
}

FittedCurves collect(const Samples& samples, const fit::BodyData& body, const BodyBases& bases,
                     const std::vector<PointResult>& results) {
  const Eigen::Index points = samples.points();
  FittedCurves out;
  out.position = samples.point_position;
  out.normal = samples.point_normal;
  out.name = samples.point_name;
  out.curves.basis = bases.si;
  for (std::size_t kind = 0; kind < kCurveKinds; ++kind) {
    out.curves.control[kind].resize(points, bases.si[kind].size());
    out.covariance[kind].resize(points, fit::packed_size(bases.si[kind].size() - 1));
  }
  out.curves.is_coupled = bases.is_coupled;
  out.curves.lean_basis = bases.lean_si;
  if (!bases.lean_si.knots_m.empty()) out.curves.lean.resize(points, 3 * bases.lean_si.size());
  out.rms_residual_N.setConstant(points, std::numeric_limits<double>::quiet_NaN());
  out.max_residual_N = out.rms_residual_N;
  out.depth_range_m.setZero(points);
  for (Eigen::Index p = 0; p < points; ++p) {
    const PointResult& result = results[static_cast<std::size_t>(p)];
    for (std::size_t kind = 0; kind < kCurveKinds; ++kind) {
      out.curves.control[kind].row(p) = result.control[kind];
      out.covariance[kind].row(p) = result.covariance[kind];
    }
    if (result.lean_m.size() > 0) out.curves.lean.row(p) = result.lean_m;
    out.status.push_back(result.status);
    out.message.push_back(result.message);
    out.rows_hash.push_back(result.rows_hash);
    out.depth_range_m[p] = body.points[static_cast<std::size_t>(p)].depth * body.length_m;
    if (!result.is_scored) continue;
    out.rms_residual_N[p] = result.score.rms_N;
    out.max_residual_N[p] = result.score.max_N;
  }
  out.recordings = fit::collect_sensors(body, results);
  return out;
}

std::vector<WorstPoint> worst_points(const FittedCurves& fitted,
                                     const std::vector<PointResult>& results, int count) {
  std::vector<WorstPoint> worst;
  for (std::size_t p = 0; p < results.size(); ++p) {
    if (!results[p].is_scored) continue;
    const fit::PointScore& score = results[p].score;
    const auto at = static_cast<Eigen::Index>(p);
    std::string reason = "worst at row " + std::to_string(score.worst_row) + " of experiment " +
                         std::to_string(score.worst_experiment);
    if (!results[p].message.empty()) fit::add_sentence(reason, results[p].message);
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
void report_bands(const FittedCurves& fitted, const std::vector<fit::PointRows>& rows,
                  double length_m, FitReport& report) {
  for (std::size_t kind = 0; kind < kCurveKinds; ++kind) {
    const SplineTables tables = tabulate(fitted.curves.basis[kind]);
    const auto spline = fit::view(tables);
    std::vector<double> bands;
    for (std::size_t p = 0; p < rows.size(); ++p) {
      const auto at = static_cast<Eigen::Index>(p);
      const Eigen::VectorXd covariance = fitted.covariance[kind].row(at);
      if (!covariance.allFinite() || rows[p].curve[kind].empty()) continue;
      double end = 0;
      for (const fit::CurveRow& row : rows[p].curve[kind]) end = std::max(end, row.x * length_m);
      const double value =
          runtime::curve_value(spline, fitted.curves.control[kind].row(at).data(), end);
      if (!(value > 0)) continue;
      bands.push_back(fit::kBand90 * fit::curve_deviation(spline, covariance, end) / value);
      if (bands.back() > report.widest_band[kind] || report.widest_point[kind] < 0)
        report.widest_band[kind] = bands.back(), report.widest_point[kind] = at;
    }
    report.median_band[kind] = fit::median(std::move(bands));
  }
}

FitReport make_report(const Samples& samples, const fit::BodyData& body, const BodyBases& bases,
                      const FittedCurves& fitted, const std::vector<PointResult>& results,
                      int count) {
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
  report.rows = static_cast<std::size_t>(samples.rows());
  report.rows_used = body.rows_used;
  report.rows_not_good = body.rows_not_good;
  report.rows_not_finite = body.rows_not_finite;
  report.rows_cut = body.rows_cut;
  std::vector<double> errors;
  for (const PointResult& result : results)
    errors.insert(errors.end(), result.score.relative_errors.begin(),
                  result.score.relative_errors.end());
  report.median_relative_error = fit::median(errors);
  report.p95_relative_error = fit::quantile(errors, 0.95);
  report.max_relative_error = fit::quantile(errors, 1);
  return report;
}

}  // namespace

FittedCurves fit_curves(const Samples& samples, const FitOptions& wanted, const Progress& progress,
                        FitReport* report) {
  const auto begin = std::chrono::steady_clock::now();
  check(wanted);
  const FitOptions options = wanted.warm_start != nullptr ? as_before(wanted) : wanted;
  fit::BodyData body = fit::gather_experiments(samples, options.weight_floor);
  fit::free_sensors(samples, options, body);
  std::vector<fit::PointRows> rows;
  for (const fit::PointData& point : body.points) rows.push_back(fit::curve_rows(point));
  BodyBases bases = make_bases(body, rows, options);
  settle_sensors(body, options, rows, bases);
  const FamilyReport family = settle_family(body, options, rows, bases);
  auto results = fit_points(samples, body, rows, bases, options, progress);
  FittedCurves fitted = collect(samples, body, bases, results);
  const auto smoothing = fit::smooth_curves(samples, body, rows, bases, options, fitted, results);
  if (report != nullptr) {
    *report = make_report(samples, body, bases, fitted, results, options.worst_points);
    report->family = family;
    report->smoothing = smoothing;
    report_bands(fitted, rows, body.length_m, *report);
    report->is_stopped = progress.stopped();
    report->seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  }
  return fitted;
}

}  // namespace palpate
