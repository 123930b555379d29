#include "libfit/fit/fit_curves.hpp"

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <mutex>

#include "libfit/core/error.hpp"
#include "libfit/core/samples.hpp"
#include "libfit/core/text.hpp"
#include "libfit/fit/basis/choose_basis.hpp"
#include "libfit/fit/collect.hpp"
#include "libfit/fit/point/covariance.hpp"
#include "libfit/fit/point/fit_point.hpp"
#include "libfit/fit/point/judge_family.hpp"
#include "libfit/fit/point/nuisance.hpp"
#include "libfit/fit/ring_constants.hpp"
#include "libfit/fit/slow_motion.hpp"
#include "libfit/fit/warm_start.hpp"

namespace palpate {
namespace {

using fit::BodyBases;
using fit::PointResult;

constexpr double kLeastSway = 0.05;
constexpr int kTimeRounds = 3;
constexpr int kNuisanceRounds = 2;  // a second round moves contact points by less than their errors

template <class Act>
void parallel_for(int wanted, std::size_t count, const Act& act) {
  const int jobs = wanted > 0 ? wanted : tbb::this_task_arena::max_concurrency();
  // Without it TBB grants at most a thread per core and prints a warning about the rest.
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<std::size_t>(jobs));
  tbb::task_arena arena(jobs);
  arena.execute([&] { tbb::parallel_for(std::size_t{0}, count, act); });
}

// Rings as theory has them, by what the samples know of probe and body: a ball ploughs, which
// measures as mu(d) = 0.95 mu (1 + d / 2R), and drags its rim outward. Rings that relax are not
// spread.
fit::RingPrior rings_in_theory(const Samples& samples, double length_m, const FitOptions& options) {
  fit::RingPrior rings;
  const double friction =
      samples.probe ? fit::kSlidingShare * samples.probe->friction : options.default_friction;
  const double radius_m = ball_radius_m(samples.probe);
  rings.constant = {std::log(options.default_lateral_ratio), friction,
                    radius_m > 0 ? friction * length_m / (2 * radius_m) : 0.0,
                    radius_m > 0 && samples.relaxation.branches() == 0
                        ? fit::kSpreadOfBall * length_m / radius_m
                        : 0.0};
  return rings;
}

BodyBases make_bases(const Samples& samples, const fit::BodyData& body,
                     std::vector<fit::CurveRows>& rows, const FitOptions& options) {
  BodyBases bases;
  bases.rings = rings_in_theory(samples, body.length_m, options);
  bases.report = fit::choose_bases(body, rows, options);
  for (std::size_t kind = 0; kind < kCurveKinds; ++kind) {
    bases.plain[kind] = bases.si[kind] = bases.report[kind].basis;
    for (double& knot : bases.si[kind].knots_m) knot *= body.length_m;
    if (!options.knots_m[kind].empty()) bases.si[kind].knots_m = options.knots_m[kind];
    bases.report[kind].basis = bases.si[kind];
  }
  if (options.family.value_or(CurveFamily::rings) != CurveFamily::rings) return bases;
  bases.bed = fit::choose_bed_basis(rows, options);
  if (!bases.bed) return bases;
  bases.bed_plain = bases.bed->basis;
  for (double& knot : bases.bed->basis.knots_m) knot *= body.length_m;
  return bases;
}

// Bases chosen again from rows as they are without what recordings add, found on the bases so far;
// and those rows. Nothing changes where all is known of the recordings.
void settle_nuisances(const Samples& samples, const fit::BodyData& body, const FitOptions& options,
                      std::vector<fit::CurveRows>& rows, BodyBases& bases) {
  if (!fit::has_nuisances(body)) return;
  for (int round = 0; round < kNuisanceRounds; ++round) {
    const fit::Bases plain(bases.plain);
    std::vector<fit::CurveRows> corrected(rows.size());
    parallel_for(options.jobs, rows.size(), [&](std::size_t p) {
      const fit::PointData& point = body.points[p];
      if (!point.problem.empty()) return;
      const fit::PointCurves found = fit::identify(point, rows[p], bases, plain, options);
      corrected[p] = fit::curve_rows(
          found.problem.empty() ? fit::without_nuisances(point, found.nuisance) : point);
    });
    rows = std::move(corrected);
    bases = make_bases(samples, body, rows, options);
  }
}

bool is_dragged(const std::vector<fit::CurveRows>& rows) {
  return std::ranges::any_of(rows, [](const fit::CurveRows& point) { return point.drags > 0; });
}

// The family asked for, else the one that the rows support; bases are left as it has them.
FamilyReport settle_family(const FitOptions& options, const std::vector<fit::CurveRows>& rows,
                           BodyBases& bases) {
  const bool has_drags = is_dragged(rows);
  FamilyReport report{
      options.family.value_or(has_drags ? CurveFamily::rings : CurveFamily::separable), false,
      options.family ? "as asked"
      : has_drags    ? "there are drags"
                     : "no drags"};
  bases = fit::of_family(std::move(bases), report.family);
  return report;
}

// What rings of the body's points have in common, from points that were dragged: the rest lean on
// it. Theory stays where none was.
void settle_rings(const Samples& samples, const fit::BodyData& body,
                  const std::vector<fit::CurveRows>& rows, const FitOptions& options,
                  BodyBases& bases) {
  if (bases.family != CurveFamily::rings) return;
  const fit::Bases plain = fit::plain_bases(bases);
  struct Found {
    fit::PointCurves curves;
    Eigen::VectorXd deviation;
  };
  std::vector<std::optional<Found>> found(rows.size());
  parallel_for(options.jobs, rows.size(), [&](std::size_t p) {
    if (!body.points[p].problem.empty() || rows[p].drags == 0) return;
    fit::PointCurves curves = fit::identify(body.points[p], rows[p], bases, plain, options);
    if (!curves.problem.empty()) return;
    Eigen::VectorXd deviation = Eigen::Vector4d::Zero();
    const Eigen::MatrixXd square = fit::covariance(body.points[p], plain, curves).more;
    if (square.rows() >= 4 && square.allFinite())
      deviation = square.diagonal().cwiseMax(0).cwiseSqrt();
    found[p] = Found{std::move(curves), std::move(deviation)};
  });
  std::vector<fit::RingPoint> points;
  for (const auto& each : found) {
    if (!each) continue;
    fit::RingPoint& point = points.emplace_back();
    point.log_force = each->curves.log_force;
    for (std::size_t k = 0; k < point.constant.size(); ++k) {
      point.constant[k] = each->curves.more[static_cast<Eigen::Index>(k)];
      point.error[k] = each->deviation[static_cast<Eigen::Index>(k)];
    }
    point.error[0] /= point.constant[0];  // of the logarithm
    point.constant[0] = std::log(point.constant[0]);
  }
  if (points.empty()) return;
  bases.rings = fit::ring_lines(
      points, fit::kUsualRings,
      samples.probe ? std::optional(bases.rings.constant) : std::optional<fit::RingConstants>());
}

// earlier: of each point, its place in the earlier fit, or -1.
std::vector<PointResult> fit_points(const Samples& samples, const fit::BodyData& body,
                                    const std::vector<fit::CurveRows>& rows, const BodyBases& bases,
                                    const std::vector<Eigen::Index>& earlier,
                                    const FitOptions& options, const Progress& progress) {
  const fit::Bases plain = fit::plain_bases(bases), si = fit::si_bases(bases);
  std::vector<PointResult> results(body.points.size());
  std::mutex mutex;
  std::size_t done = 0;
  parallel_for(options.jobs, results.size(), [&](std::size_t p) {
    if (progress.stopped()) {
      results[p] = fit::no_curves(bases, "stopped before this point was fitted");
      return;
    }
    progress.begin(samples.point_name[p]);
    const fit::PointData& point = body.points[p];
    results[p] = earlier[p] >= 0 ? fit::kept_point(options, earlier[p], point.experiments.size())
                                 : fit::fit_point(samples, point, rows[p], body.length_m, bases,
                                                  plain, si, options);
    progress.end();
    const std::lock_guard lock(mutex);
    progress.report(++done, results.size(), samples.point_name[p]);
  });
  return results;
}

// Scores curves that an earlier fit or their neighbours gave.
void score_given(const Samples& samples, const fit::BodyData& body, const BodyBases& bases,
                 int jobs, const FittedCurves& fitted, std::vector<PointResult>& results) {
  const fit::Bases si = fit::si_bases(bases);
  parallel_for(jobs, results.size(), [&](std::size_t p) {
    PointResult& result = results[p];
    bool is_given = result.is_kept;
    for (std::size_t i = 0; i < result.control.size(); ++i) {
      const Eigen::VectorXd control = fitted.curves.control[i].row(static_cast<Eigen::Index>(p));
      is_given = is_given || control != result.control[i];
      result.control[i] = control;
    }
    if (is_given && result.is_scored)
      result.score = fit::score_point(samples, body.points[p], body.length_m, si, result.control,
                                      result.nuisance);
  });
}

// A body's rows as a fit reads them, and what it chose for them.
struct Reading {
  fit::BodyData body;
  std::vector<fit::CurveRows> rows;
  BodyBases bases;
  FamilyReport family;
};

Reading read_rows(const Samples& samples, FitOptions options, bool without_sway) {
  Reading out{fit::gather_experiments(samples, without_sway), {}, {}, {}};
  fit::add_nuisances(samples, options, out.body);
  for (const fit::PointData& point : out.body.points) out.rows.push_back(fit::curve_rows(point));
  out.bases = make_bases(samples, out.body, out.rows, options);
  settle_nuisances(samples, out.body, options, out.rows, out.bases);
  out.family = settle_family(options, out.rows, out.bases);
  return out;
}

// Whether the body moves as a whole by more than kLeastSway of what the tool does, at some row.
bool may_sway(const Samples& samples) {
  if (samples.point_sway.rows() == 0) return false;
  for (Eigen::Index i = 0; i < samples.rows(); ++i) {
    const Vec3 force = samples.force.row(i);
    const Mat3 sway =
        symmetric_of(samples.point_sway.row(samples.point[static_cast<std::size_t>(i)]));
    if ((sway * force).norm() > kLeastSway * samples.deflection.row(i).norm()) return true;
  }
  return false;
}

// Rows as they are or without the body's sway, whichever lets held-out rows be predicted better:
// without it the family is rings.
Reading settle_reading(const Samples& samples, const FitOptions& options) {
  if (options.sways)
    return read_rows(samples, options, *options.sways && samples.point_sway.rows() > 0);
  Reading plain = read_rows(samples, options, false);
  if (plain.family.family != CurveFamily::rings || !is_dragged(plain.rows) || !may_sway(samples))
    return plain;
  FitOptions rings = options;
  rings.family = CurveFamily::rings;
  Reading local = read_rows(samples, rings, true);
  const auto judged = [&](const Reading& reading) {
    return fit::judge_family(reading.body, reading.rows, reading.bases, rings);
  };
  const fit::FamilyEvidence without = judged(plain), with = judged(local);
  plain.family.reason +=
      "; rings on a body that sways " + percent(with.median_error) + ", " + percent(with.p95_error);
  if (!fit::is_worth_its_sway(without, with)) return plain;
  local.family = {CurveFamily::rings, true, plain.family.reason};
  return local;
}

FittedCurves fit_slow_rows(const Samples& samples, const FitOptions& wanted,
                           const Progress& progress, FitReport* report, FitCache* cache) {
  const auto begin = std::chrono::steady_clock::now();
  FitOptions options = wanted.warm_start != nullptr ? fit::as_before(wanted) : wanted;
  Reading reading = settle_reading(samples, options);
  auto& [body, rows, bases, family] = reading;
  settle_rings(samples, body, rows, options, bases);
  std::vector<std::string> fingerprint = fit::fingerprints(samples, body, bases, options);
  const std::vector<Eigen::Index> earlier = fit::earlier_points(options, fingerprint);
  auto results = fit_points(samples, body, rows, bases, earlier, options, progress);
  FittedCurves fitted = fit::collect_curves(samples, body, bases, results);
  score_given(samples, body, bases, options.jobs, fitted, results);
  fit::collect_residuals(results, fitted);
  RingsReport rings = fit::judge_rings(samples, rows, fitted);
  if (report != nullptr) {
    *report = fit::make_report(body, rows, bases, fitted, results, options);
    report->rows.all = static_cast<std::size_t>(samples.rows());
    report->family = family;
    report->rings = std::move(rings);
    report->is_stopped = progress.stopped();
    report->seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  }
  if (cache != nullptr) *cache = {std::move(fingerprint)};
  return fitted;
}

FittedCurves fit_straight(const Samples& samples, const FitOptions& wanted,
                          const Progress& progress, FitReport* report, FitCache* cache) {
  FitOptions options = wanted;
  if (samples.relaxation.branches() > 0) {
    if (options.family.value_or(CurveFamily::rings) != CurveFamily::rings)
      throw Error("family",
                  "`" + std::string(name_of(*options.family)) +
                      "` has no memory of time, and the body relaxes",
                  "Use rings, or leave the family out.");
    options.family = CurveFamily::rings;
  }
  if (!fit::feels_time(samples)) return fit_slow_rows(samples, options, progress, report, cache);
  options.warm_start = nullptr;  // its rows are of slow motion, and those are not known yet
  FittedCurves curves = fit_slow_rows(samples, options, progress, nullptr, nullptr);
  for (int round = 1; round < kTimeRounds; ++round)
    curves =
        fit_slow_rows(fit::in_slow_motion(samples, curves), options, progress, nullptr, nullptr);
  return fit_slow_rows(fit::in_slow_motion(samples, curves), options, progress, report, cache);
}

}  // namespace

FittedCurves fit_curves(const Samples& samples, const FitOptions& options, const Progress& progress,
                        FitReport* report, FitCache* cache) {
  fit::check_options(options);
  fit::check_samples(samples);
  if (!has_crooked_press(samples)) return fit_straight(samples, options, progress, report, cache);
  Samples straight = samples;
  straighten_presses(straight);
  return fit_straight(straight, options, progress, report, cache);
}

}  // namespace palpate
