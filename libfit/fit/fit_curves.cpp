#include "libfit/fit/fit_curves.hpp"

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <mutex>

#include "libfit/core/error.hpp"
#include "libfit/fit/choose_basis.hpp"
#include "libfit/fit/choose_family.hpp"
#include "libfit/fit/curve_band.hpp"
#include "libfit/fit/fit_point.hpp"
#include "libfit/fit/keep_points.hpp"
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
  bases.is_anisotropic = is_anisotropic(report.family);
  if (!leans(report.family)) {
    bases.lean_plain.knots_m.clear();
    bases.lean_si.knots_m.clear();
  }
  return report;
}

bool is_smoothed(const FittedCurves& curves) {
  return std::any_of(curves.smoothing.begin(), curves.smoothing.end(),
                     [](double strength) { return strength > 0; });
}

// Bases and family as the earlier fit had them, and no smoothing where it found that none pays.
FitOptions as_before(FitOptions options) {
  const CurveSet& curves = options.warm_start->curves;
  options.degree = curves.basis[0].degree;
  for (std::size_t kind = 0; kind < kCurveKinds; ++kind) {
    require(curves.basis[kind].degree == options.degree, "warm start",
            "has curves of several degrees", "Fit without a warm start.");
    options.knots_m[kind] = curves.basis[kind].knots_m;
  }
  options.family = curves.family();
  const FittedCurves& earlier = *options.warm_start;
  if (!options.smoothing && !earlier.smoothing_reason[0].empty() && !is_smoothed(earlier))
    options.smoothing = 0;
  return options;
}

// What is fitted: all rows, or those of the points that are not kept.
struct Input {
  const Samples& samples;
  const RowIndex& index;           // of all rows
  std::size_t rows = 0;            // of all points
  std::vector<Eigen::Index> kept;  // P, row of the earlier fit, or -1
  std::vector<std::string> hash;   // P
  const fit::EarlierPoints& earlier;
};

// Where the rows of each curve end.
Eigen::RowVector3d curve_ends_m(const fit::PointRows& rows, double length_m) {
  Eigen::RowVector3d end = Eigen::RowVector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  for (std::size_t kind = 0; kind < kCurveKinds; ++kind) {
    if (rows.curve[kind].empty()) continue;
    double& here = end[static_cast<Eigen::Index>(kind)] = 0;
    for (const fit::CurveRow& row : rows.curve[kind]) here = std::max(here, row.x * length_m);
  }
  return end;
}

std::vector<PointResult> fit_points(const Input& input, const fit::BodyData& body,
                                    const std::vector<fit::PointRows>& rows, const BodyBases& bases,
                                    const FitOptions& options, const Progress& progress) {
  const fit::Bases plain(bases.plain, bases.lean_plain, bases.is_coupled, bases.is_anisotropic);
  const fit::Bases si(bases.si, bases.lean_si, bases.is_coupled, bases.is_anisotropic);
  std::vector<PointResult> results(body.points.size());
  std::mutex mutex;
  std::size_t done = 0;
  const auto fit_one = [&](std::size_t p) {
    if (progress.stopped()) {
      results[p] = fit::no_curves(bases, "stopped before this point was fitted");
      return;
    }
    const fit::PointData& point = body.points[p];
    if (input.kept[p] >= 0) {
      results[p] = input.earlier.keep(input.kept[p], input.index.first_experiment[p],
                                      point.experiments.size());
    } else {
      results[p] =
          fit::fit_point(input.samples, point, rows[p], body.length_m, bases, plain, si, options);
      results[p].depth_m = point.depth_m;
      results[p].curve_end_m = curve_ends_m(rows[p], body.length_m);
      results[p].states_errors = point.has_errors;
      results[p].rows = point.rows;
    }
    results[p].rows_hash = input.hash[p];
    const std::lock_guard lock(mutex);
    progress.report(++done, results.size(), input.samples.point_name[p]);
  };
  parallel_for(options.jobs, results.size(), fit_one);
  return results;
}

FittedCurves collect(const Input& input, const fit::BodyData& body, const BodyBases& bases,
                     const std::vector<PointResult>& results) {
  const Samples& samples = input.samples;
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
  if (bases.is_anisotropic) out.curves.anisotropy.resize(points, runtime::kTensorSize);
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
    if (result.anisotropy.size() > 0) out.curves.anisotropy.row(p) = result.anisotropy;
    out.status.push_back(result.status);
    out.message.push_back(result.message);
    out.rows_hash.push_back(result.rows_hash);
    out.depth_range_m[p] = result.depth_m;
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
void report_bands(const FittedCurves& fitted, FitReport& report) {
  for (std::size_t kind = 0; kind < kCurveKinds; ++kind) {
    const SplineTables tables = tabulate(fitted.curves.basis[kind]);
    const auto spline = fit::view(tables);
    std::vector<double> bands;
    for (Eigen::Index at = 0; at < fitted.position.rows(); ++at) {
      const double end = fitted.scores.curve_end_m(at, static_cast<Eigen::Index>(kind));
      if (!fitted.covariance[kind].row(at).allFinite() || std::isnan(end)) continue;
      const Eigen::VectorXd covariance = fitted.covariance[kind].row(at);
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

FitReport make_report(const Input& input, const BodyBases& bases, const FittedCurves& fitted,
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
  report.rows = input.rows;
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
  report.median_relative_error = fit::median(errors);
  report.p95_relative_error = fit::quantile(errors, 0.95);
  report.max_relative_error = fit::quantile(errors, 1);
  return report;
}

FittedCurves fit_body(const Input& input, const fit::BodyData& body, const FitOptions& options,
                      const Progress& progress, FitReport* report) {
  const auto begin = std::chrono::steady_clock::now();
  std::vector<fit::PointRows> rows;
  for (const fit::PointData& point : body.points) rows.push_back(fit::curve_rows(point));
  BodyBases bases = make_bases(body, rows, options);
  settle_sensors(body, options, rows, bases);
  const FamilyReport family = settle_family(body, options, rows, bases);
  auto results = fit_points(input, body, rows, bases, options, progress);
  FittedCurves fitted = collect(input, body, bases, results);
  const auto smoothing =
      fit::smooth_curves(input.samples, body, rows, bases, options, fitted, results);
  fitted.scores = fit::collect_scores(input.index, results);
  if (report != nullptr) {
    *report = make_report(input, bases, fitted, results, options.worst_points);
    report->family = family;
    report->smoothing = smoothing;
    report_bands(fitted, *report);
    report->is_stopped = progress.stopped();
    report->seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  }
  return fitted;
}

}  // namespace

FittedCurves fit_curves(const Samples& samples, const FitOptions& wanted, const Progress& progress,
                        FitReport* report) {
  check(wanted);
  const FitOptions options = wanted.warm_start != nullptr ? as_before(wanted) : wanted;
  fit::BodyData body = fit::gather_experiments(samples, options.weight_floor);
  fit::free_sensors(samples, options, body);
  const RowIndex index = index_rows(samples);
  const fit::EarlierPoints earlier(options.warm_start);
  std::vector<std::string> hashes = fit::point_hashes(samples, index, options);
  fit::add_borrowed(body, hashes);
  const Input input{
      samples, index,  static_cast<std::size_t>(samples.rows()), earlier.rows_of(hashes),
      hashes,  earlier};
  return fit_body(input, body, options, progress, report);
}

std::optional<FittedCurves> refit_curves(const Samples& points, const RowIndex& index,
                                         std::size_t rows, const ReadRows& read_rows,
                                         const FitOptions& wanted, const Progress& progress,
                                         FitReport* report) {
  check(wanted);
  if (wanted.warm_start == nullptr || wanted.judges_family || wanted.frees != FitOptions{}.frees)
    return std::nullopt;
  const FitOptions options = as_before(wanted);
  if (is_smoothed(*options.warm_start) || options.smoothing != 0.0) return std::nullopt;
  const fit::EarlierPoints earlier(options.warm_start);
  const std::vector<std::string> hashes = fit::point_hashes(points, index, options);
  const auto kept = earlier.rows_of(hashes);
  std::vector<char> is_wanted;
  for (const Eigen::Index row : kept) is_wanted.push_back(row < 0);
  if (2 * std::count(is_wanted.begin(), is_wanted.end(), 1) > points.points()) return std::nullopt;
  const Samples samples = read_rows(is_wanted);
  const fit::BodyData body =
      fit::gather_experiments(samples, options.weight_floor, earlier.depth_m(kept));
  if (!earlier.are_errors_alike(kept, body)) return std::nullopt;
  return fit_body({samples, index, rows, kept, hashes, earlier}, body, options, progress, report);
}

}  // namespace palpate
