#include "libfit/fit/fit_curves.hpp"

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <mutex>

#include "libfit/fit/basis/choose_basis.hpp"
#include "libfit/fit/basis/choose_degree.hpp"
#include "libfit/fit/fit_options.hpp"
#include "libfit/fit/fit_report.hpp"
#include "libfit/fit/neighbours/smooth_curves.hpp"
#include "libfit/fit/point/choose_family.hpp"
#include "libfit/fit/point/fit_point.hpp"
#include "libfit/fit/point/nuisance.hpp"
#include "libfit/fit/spline/curve_band.hpp"
#include "libfit/fit/warm_start.hpp"
#include "libfit/fit/words.hpp"

namespace palpate {
namespace {

using fit::BodyBases;
using fit::PointResult;

// By how much rings of a body's points differ from their median (docs/method.md, section 5).
constexpr double kUsualLambda = 0.2, kUsualFriction = 0.03, kUsualFrictionSlope_1_m = 5;
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
  return bases;
}

// Bases chosen again from rows as they are without what sensors add, found on the bases so far; and
// those rows. Nothing changes where all is known of sensors.
void settle_sensors(const fit::BodyData& body, const FitOptions& options,
                    std::vector<fit::PointRows>& rows, BodyBases& bases) {
  if (!fit::has_unknown_sensors(body)) return;
  for (int round = 0; round < kSensorRounds; ++round) {
    const fit::Bases plain(bases.plain);
    std::vector<fit::PointRows> corrected(rows.size());
    parallel_for(options.jobs, rows.size(), [&](std::size_t p) {
      const fit::PointData& point = body.points[p];
      if (!point.problem.empty()) return;
      const fit::PointCurves found = fit::identify(point, rows[p], bases, plain, options);
      corrected[p] = fit::curve_rows(
          found.problem.empty() ? fit::without_sensors(point, found.sensor) : point);
    });
    rows = std::move(corrected);
    bases = make_bases(body, rows, options);
  }
}

// The family asked for or, by evidence, the one the body needs; bases are left as it has them.
FamilyReport settle_family(const fit::BodyData& body, const FitOptions& options,
                           const std::vector<fit::PointRows>& rows, BodyBases& bases) {
  FamilyReport report = options.family ? FamilyReport{*options.family, {}, "as asked"}
                                       : fit::choose_family(body, rows, bases, options);
  if (options.family && options.judges_family)
    report.evidence.push_back(fit::judge_family(body, rows, bases, report.family, options));
  bases = fit::of_family(std::move(bases), report.family);
  return report;
}

// What rings of the body's points have in common, from points that were dragged until they slip:
// the rest lean on it. Theory where none was.
void settle_rings(const fit::BodyData& body, const std::vector<fit::PointRows>& rows,
                  const FitOptions& options, BodyBases& bases) {
  if (bases.family != CurveFamily::rings) return;
  bases.rings.lambda = options.default_lateral_ratio;
  bases.rings.friction = options.default_friction;
  const fit::Bases plain = fit::plain_bases(bases);
  std::vector<Eigen::VectorXd> found(rows.size());
  parallel_for(options.jobs, rows.size(), [&](std::size_t p) {
    if (!body.points[p].problem.empty() || rows[p].slipping_drags == 0) return;
    const fit::PointCurves curves = fit::identify(body.points[p], rows[p], bases, plain, options);
    if (curves.problem.empty()) found[p] = curves.more.head<3>();
  });
  std::array<std::vector<double>, 3> values;
  for (const Eigen::VectorXd& each : found)
    for (std::size_t k = 0; k < 3 && each.size() > 0; ++k)
      values[k].push_back(each[static_cast<Eigen::Index>(k)]);
  if (values[0].empty()) return;
  bases.rings = {fit::median(values[0]), fit::median(values[1]),
                 fit::median(values[2]), kUsualLambda,
                 kUsualFriction,         kUsualFrictionSlope_1_m * body.length_m};
}

// What is fitted: all rows, or those of the points that are not kept.
struct Input {
  const Samples& samples;
  const RowIndex& index;           // of all rows
  std::size_t rows = 0;            // of all points
  std::vector<Eigen::Index> kept;  // P, row of the earlier fit, or -1
  std::vector<std::string> hash;   // P
  const fit::EarlierPoints& earlier;
  ReadRows read_rows{};  // of points kept
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
  const fit::Bases plain = fit::plain_bases(bases), si = fit::si_bases(bases);
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
  out.curves = CurveSet(bases.family);
  out.curves.basis = bases.si;
  const auto parts = parts_of(bases.family);
  for (std::size_t i = 0; i < parts.size(); ++i)
    out.curves.control[i].resize(points, parts[i].width * size_of(parts[i], bases.si[i]));
  const std::size_t curves = curves_of(bases.family);
  for (std::size_t kind = 0; kind < curves; ++kind)
    out.covariance[kind].resize(points, fit::packed_size(bases.si[kind].size() - 1));
  out.rms_residual_N.setConstant(points, std::numeric_limits<double>::quiet_NaN());
  out.max_residual_N = out.rms_residual_N;
  out.depth_range_m.setZero(points);
  for (Eigen::Index p = 0; p < points; ++p) {
    const PointResult& result = results[static_cast<std::size_t>(p)];
    for (std::size_t i = 0; i < parts.size(); ++i) out.curves.control[i].row(p) = result.control[i];
    for (std::size_t kind = 0; kind < curves; ++kind)
      out.covariance[kind].row(p) = result.covariance[kind];
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

FittedCurves fit_body(const Input& input, const fit::BodyData& body, FitOptions options,
                      const Progress& progress, FitReport* report) {
  const auto begin = std::chrono::steady_clock::now();
  std::vector<fit::PointRows> rows;
  for (const fit::PointData& point : body.points) rows.push_back(fit::curve_rows(point));
  fit::ChosenDegree degree{options.degree, ""};
  if (options.degree == 0) degree = fit::choose_degree(body, rows, options);
  options.degree = degree.degree;
  BodyBases bases = make_bases(body, rows, options);
  settle_sensors(body, options, rows, bases);
  const FamilyReport family = settle_family(body, options, rows, bases);
  settle_rings(body, rows, options, bases);
  auto results = fit_points(input, body, rows, bases, options, progress);
  FittedCurves fitted = collect(input, body, bases, results);
  const auto smoothing = fit::smooth_curves(input.samples, body, rows, bases, options, fitted,
                                            results, input.read_rows);
  fitted.scores = fit::collect_scores(input.index, results);
  if (report != nullptr) {
    *report = fit::make_report(input.rows, bases, fitted, results, options.worst_points);
    report->degree_reason = degree.reason;
    report->family = family;
    report->smoothing = smoothing;
    report->is_stopped = progress.stopped();
    report->seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  }
  return fitted;
}

}  // namespace

FittedCurves fit_curves(const Samples& samples, const FitOptions& wanted, const Progress& progress,
                        FitReport* report) {
  fit::check_options(wanted);
  const FitOptions options = wanted.warm_start != nullptr ? fit::as_before(wanted) : wanted;
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
  fit::check_options(wanted);
  if (wanted.warm_start == nullptr || wanted.judges_family || wanted.frees != FitOptions{}.frees)
    return std::nullopt;
  const FitOptions options = fit::as_before(wanted);
  const bool is_settled = fit::kept_strengths(options) ||
                          (options.smoothing == 0.0 && !fit::is_smoothed(*options.warm_start));
  if (!is_settled) return std::nullopt;
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
  return fit_body({samples, index, rows, kept, hashes, earlier, read_rows}, body, options, progress,
                  report);
}

}  // namespace palpate
