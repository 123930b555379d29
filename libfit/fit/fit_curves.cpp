#include "libfit/fit/fit_curves.hpp"

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <mutex>

#include "libfit/core/error.hpp"
#include "libfit/core/samples.hpp"
#include "libfit/core/text.hpp"
#include "libfit/fit/fit_steps.hpp"
#include "libfit/fit/point/point.hpp"

namespace palpate {
namespace {

using fit::BodyBases;
using fit::PointResult;

void require(bool holds, const char* option, const char* fact, const char* remedy) {
  if (!holds) throw Error(std::string("fit option ") + option, fact, remedy);
}

void check_options(const FitOptions& o) {
  require(o.degree >= 1 && o.degree <= 4, "degree", "is not 1 to 4",
          "Choose a degree of 1, 2, 3 or 4.");
  for (const int pieces : o.pieces)
    require(pieces >= 0 && pieces <= 256, "pieces", "is not 0 to 256",
            "Give a number of pieces, or 0 to have it chosen.");
  require(o.tolerance >= 0 && o.tolerance < 1, "tolerance", "is not in [0, 1)",
          "Give a relative error such as 0.02.");
  require(o.default_friction > 0 && std::isfinite(o.default_friction), "default_friction",
          "is not above 0", "Give a friction such as 0.3.");
  require(o.default_lateral_ratio > 0 && std::isfinite(o.default_lateral_ratio),
          "default_lateral_ratio", "is not above 0", "Give a ratio such as 0.67.");
  require(o.jobs >= 0, "jobs", "is negative", "Give a number of threads, or 0 for all.");
}

template <class Act>
void parallel_for(int wanted, std::size_t count, const Act& act) {
  const int jobs = wanted > 0 ? wanted : tbb::this_task_arena::max_concurrency();
  // Without it TBB grants at most a thread per core and prints a warning about the rest.
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, jobs);
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

BodyBases make_bases(const Samples& samples, const fit::BodyData& body, CurveFamily family,
                     std::vector<fit::CurveRows>& rows, const FitOptions& options) {
  BodyBases bases;
  bases.family = family;
  bases.rings = rings_in_theory(samples, body.length_m, options);
  bases.report = fit::choose_bases(body, rows, options);
  if (family == CurveFamily::rings)
    if (const auto bed = fit::choose_bed_basis(rows, options)) bases.report[0] = *bed;
  for (std::size_t kind = 0; kind < kCurveKinds; ++kind) {
    CurveBasis& basis = bases.report[kind].basis;
    bases.plain[kind] = basis;
    for (double& knot : basis.knots_m) knot *= body.length_m;
    if (!options.knots_m[kind].empty()) basis.knots_m = options.knots_m[kind];
    bases.si[kind] = basis;
  }
  for (auto* all : {&bases.plain, &bases.si}) {
    all->resize(curves_of(family));
    all->resize(parts_of(family).size());
  }
  return bases;
}

// Rows without what recordings add, found on the bases that they had with it. Nothing changes where
// all is known of the recordings.
void settle_nuisances(const Samples& samples, const fit::BodyData& body, const FitOptions& options,
                      std::vector<fit::CurveRows>& rows) {
  if (!fit::has_nuisances(body)) return;
  // The second round moves contact points by less than their errors.
  for (int round = 0; round < 2; ++round) {
    const BodyBases bases = make_bases(samples, body, CurveFamily::separable, rows, options);
    const fit::Bases plain(bases.plain, bases.family);
    std::vector<fit::CurveRows> corrected(rows.size());
    parallel_for(options.jobs, rows.size(), [&](std::size_t p) {
      const fit::PointData& point = body.points[p];
      if (!point.problem.empty()) return;
      const fit::PointCurves found = fit::identify(point, rows[p], bases, plain, options);
      corrected[p] = fit::curve_rows(
          found.problem.empty() ? fit::without_nuisances(point, found.nuisance) : point);
    });
    rows = std::move(corrected);
  }
}

bool is_dragged(const std::vector<fit::CurveRows>& rows) {
  return std::ranges::any_of(rows, [](const fit::CurveRows& point) { return point.drags > 0; });
}

// The prior of a body's rings by the points that were dragged, for all of them. Theory's stays
// where none was; of a body that sways it says nothing.
void settle_rings(const Samples& samples, const fit::BodyData& body,
                  const std::vector<fit::CurveRows>& rows, bool sways, const FitOptions& options,
                  BodyBases& bases) {
  if (bases.family != CurveFamily::rings) return;
  const fit::Bases plain(bases.plain, bases.family);
  std::vector<std::optional<fit::RingPoint>> found(rows.size());
  parallel_for(options.jobs, rows.size(), [&](std::size_t p) {
    if (!body.points[p].problem.empty() || rows[p].drags == 0) return;
    const fit::PointCurves curves = fit::identify(body.points[p], rows[p], bases, plain, options);
    if (!curves.problem.empty()) return;
    Eigen::VectorXd deviation = Eigen::Vector4d::Zero();
    const Eigen::MatrixXd square = fit::covariance(body.points[p], plain, curves).constants;
    if (square.rows() >= 4 && square.allFinite())
      deviation = square.diagonal().cwiseMax(0).cwiseSqrt();
    found[p] = fit::ring_point(curves.log_force, curves.constants.data(), deviation.data());
  });
  std::vector<fit::RingPoint> points;
  for (const auto& point : found)
    if (point) points.push_back(*point);
  if (points.empty()) return;
  const bool has_side = bases.rings.has_side;
  bases.rings = fit::ring_lines(points, fit::kUsualRings,
                                samples.probe && !sways ? std::optional(bases.rings.constant)
                                                        : std::optional<fit::RingConstants>());
  bases.rings.has_side = has_side;
}

// Fits points into their rows of `fitted`.
std::vector<PointResult> fit_points(const Samples& samples, const fit::BodyData& body,
                                    const std::vector<fit::CurveRows>& rows, const BodyBases& bases,
                                    const FitOptions& options, const Progress& progress,
                                    FittedCurves& fitted) {
  const fit::Bases plain(bases.plain, bases.family), si(bases.si, bases.family);
  std::vector<PointResult> results(body.points.size());
  std::mutex mutex;
  std::size_t done = 0;
  parallel_for(options.jobs, results.size(), [&](std::size_t p) {
    if (progress.stopped()) {
      fitted.message[p] = "stopped before this point was fitted";
      return;
    }
    PointResult& result = results[p];
    result = fit::fit_point(samples, body, p, rows[p], bases, plain, si, options, fitted);
    if (result.is_scored) {
      fitted.rms_residual_N[p] = result.score.rms_N;
      fitted.max_residual_N[p] = result.score.max_N;
    }
    const std::lock_guard lock(mutex);
    progress.report(++done, results.size(), samples.point_name[p]);
  });
  return results;
}

// A body's rows as a fit reads them, and what it chose for them.
struct Reading {
  fit::BodyData body;
  std::vector<fit::CurveRows> rows;
  BodyBases bases;
  FamilyReport family;
};

Reading read_rows(const Samples& samples, FitOptions options, const std::vector<Mat3>& sways = {}) {
  Reading out{fit::gather_experiments(samples, sways), {}, {}, {}};
  fit::add_nuisances(samples, options, out.body);
  for (const fit::PointData& point : out.body.points) out.rows.push_back(fit::curve_rows(point));
  settle_nuisances(samples, out.body, options, out.rows);
  out.family = {options.family, !sways.empty(),
                options.family != CurveFamily::rings ? "as asked"
                : is_dragged(out.rows)               ? "there are drags"
                                                     : "no drags"};
  out.bases = make_bases(samples, out.body, out.family.family, out.rows, options);
  return out;
}

// True where the rigid motion of the body exceeds a twentieth of the tool's at some row.
bool may_sway(const Samples& samples) {
  if (samples.point_sway.rows() == 0) return false;
  for (Eigen::Index i = 0; i < samples.rows(); ++i) {
    const Vec3 force = samples.force.row(i);
    const Mat3 sway = symmetric_of(samples.point_sway.row(samples.point[i]));
    if ((sway * force).norm() > 0.05 * samples.deflection.row(i).norm()) return true;
  }
  return false;
}

// Rows as they are or without the body's sway, whichever lets held-out rows be predicted better:
// without it the family is rings. Where the sway explains what a press adds sideways, presses have
// no side forces: fitted to it they would stay when the contact slides.
Reading settle_reading(const Samples& samples, const FitOptions& options) {
  Reading plain = read_rows(samples, options);
  if (options.sways == false || plain.family.family != CurveFamily::rings ||
      !is_dragged(plain.rows) || !may_sway(samples))
    return plain;
  std::string& reason = plain.family.reason;
  const auto judged = [&](const Reading& reading) {
    return fit::judge_family(reading.body, reading.rows, reading.bases, options);
  };
  const auto note = [&](const char* what, const fit::FamilyEvidence& found) {
    reason += what + percent(found.median_error) + ", " + percent(found.p95_error);
  };
  const fit::FamilyEvidence without = judged(plain);
  // A muscle held at its ends has 12 % (p95) so, 35 and 38 where all or nothing is subtracted.
  for (const double share : {1.0, 0.5, 0.25}) {
    const std::vector<Mat3> sways = fit::sways_of(samples, share);
    Reading local = read_rows(samples, options, sways);
    fit::FamilyEvidence with = judged(local);
    note("; rings on a body that sways ", with);
    if (!fit::predicts_better(without, with)) continue;
    // Six points are few for lambda's slope, and where the sway is wrong it may be anything.
    const fit::BodyData body = local.body;
    BodyBases settled = local.bases;
    settle_rings(samples, body, local.rows, true, options, settled);
    for (const double slope : {settled.rings.slope, 0.0}) {
      settled.rings.slope = slope;
      Reading turned = read_rows(samples, options, fit::turned_sways(body, sways, settled.rings));
      const fit::FamilyEvidence with_turned = judged(turned);
      if (!fit::predicts_better(with, with_turned)) continue;
      note("; its sway turned ", with_turned);
      local = std::move(turned);
      with = with_turned;
    }
    local.bases.rings.has_side = false;
    const fit::FamilyEvidence sideless = judged(local);
    local.bases.rings.has_side = fit::predicts_better(sideless, with);
    if (!local.bases.rings.has_side) note("; without side forces ", sideless);
    local.family.reason = reason;
    return local;
  }
  return options.sways ? read_rows(samples, options, fit::sways_of(samples, 1)) : plain;
}

FittedCurves fit_slow_rows(const Samples& samples, const FitOptions& wanted,
                           const Progress& progress, FitReport* report) {
  const auto begin = std::chrono::steady_clock::now();
  FitOptions options = wanted.warm_start != nullptr ? fit::as_before(wanted) : wanted;
  Reading reading = settle_reading(samples, options);
  auto& [body, rows, bases, family] = reading;
  settle_rings(samples, body, rows, family.sways, options, bases);
  FittedCurves fitted = fit::no_curves(samples, body, bases);
  const auto results = fit_points(samples, body, rows, bases, options, progress, fitted);
  fitted.recordings = fit::collect_nuisances(body, results);
  if (report != nullptr) {
    *report = fit::make_report(body, rows, bases, fitted, results, options);
    report->rows.all = samples.rows();
    report->family = family;
    report->is_stopped = progress.stopped();
    report->seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  }
  return fitted;
}

FittedCurves fit_straight(const Samples& samples, const FitOptions& wanted,
                          const Progress& progress, FitReport* report) {
  FitOptions options = wanted;
  if (samples.relaxation.branches() > 0) {
    if (options.family != CurveFamily::rings)
      throw Error("family",
                  "`" + std::string(name_of(options.family)) +
                      "` has no memory of time, and the body relaxes",
                  "Use rings, or leave the family out.");
  }
  // Curves are fitted to the forces of rows with times as these would be in slow motion.
  if (samples.time_s.size() == 0 || samples.relaxation.branches() == 0)
    return fit_slow_rows(samples, options, progress, report);
  options.warm_start = nullptr;  // its rows are of slow motion, and those are not known yet
  FittedCurves curves = fit_slow_rows(samples, options, progress, nullptr);
  for (int round = 1; round < 3; ++round)
    curves = fit_slow_rows(fit::in_slow_motion(samples, curves), options, progress, nullptr);
  return fit_slow_rows(fit::in_slow_motion(samples, curves), options, progress, report);
}

}  // namespace

FitOptions options_for(const Samples& samples) {
  FitOptions options;
  // A limit curve that is zero would never stick.
  if (samples.probe) options.default_friction = std::max(samples.probe->friction, 1e-3);
  if (!std::isnan(samples.poisson))
    options.default_lateral_ratio = 2 * (1 - samples.poisson) / (2 - samples.poisson);
  return options;
}

FittedCurves fit_curves(const Samples& samples, const FitOptions& options, const Progress& progress,
                        FitReport* report) {
  check_options(options);
  fit::check_samples(samples);
  if (!has_crooked_press(samples)) return fit_straight(samples, options, progress, report);
  Samples straight = samples;
  straighten_presses(straight);
  return fit_straight(straight, options, progress, report);
}

}  // namespace palpate
