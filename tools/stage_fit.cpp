#include "tools/stage_fit.hpp"

#include <algorithm>

#include "libfit/core/error.hpp"
#include "libfit/fit/fit_curves.hpp"
#include "tools/console.hpp"

namespace palpate::tools {
namespace {

constexpr std::size_t kListed = 15;  // points named before "and N more"

void say_report(const FitReport& report) {
  say("  family   {}: {}", kCurveFamilyNames[static_cast<std::size_t>(report.family.family)].name,
      report.family.reason);
  for (int kind = 0; kind < kCurveKinds; ++kind) {
    const auto k = static_cast<std::size_t>(kind);
    const CurveBasis& basis = report.kind[k].basis;
    say("  {:<8} {} pieces of degree {} to {:.2f} mm: {}", kCurveNames[k], basis.pieces(),
        basis.degree, 1e3 * basis.knots_m.back(), report.kind[k].reason);
  }
  say("  rows: {} fitted of {} ({} not good, {} not finite, {} after a bad one)", report.rows_used,
      report.rows, report.rows_not_good, report.rows_not_finite, report.rows_cut);
  say("  residual: median {:.2f} %, p95 {:.2f} %, max {:.2f} % of force",
      100 * report.median_relative_error, 100 * report.p95_relative_error,
      100 * report.max_relative_error);
  if (report.kept > 0)
    say("  kept: {} points whose rows are those of the earlier fit", report.kept);
  say("  points: {} good, {} poor, {} underdetermined, {} failed ({})", report.good, report.poor,
      report.underdetermined, report.failed, in_words(report.seconds));
  const std::size_t shown = std::min<std::size_t>(report.worst.size(), 3);
  for (std::size_t i = 0; i < shown; ++i) {
    const WorstPoint& p = report.worst[i];
    say("  worst: {} at ({:.1f}, {:.1f}, {:.1f}) mm: rms {:.2g} N, {:.1f} % of force; {}", p.name,
        1e3 * p.position[0], 1e3 * p.position[1], 1e3 * p.position[2], p.rms_residual_N,
        100 * p.relative_residual, p.reason);
  }
}

}  // namespace

FittedCurves fit_samples(const Samples& samples, const FitSection& section, double default_friction,
                         int jobs, const FittedCurves* warm_start) {
  const auto is_known = [&](const CurveFamilyName& row) { return row.name == section.family; };
  if (section.family != "auto" &&
      std::none_of(kCurveFamilyNames.begin(), kCurveFamilyNames.end(), is_known))
    throw Error("--family", "unknown curve family \"" + section.family + "\"",
                "Use auto, separable or leaning.");
  FitOptions options;
  options.warm_start = warm_start;
  for (const CurveFamilyName& row : kCurveFamilyNames)
    if (row.name == section.family) options.family = row.family;
  options.degree = section.degree;
  options.pieces = {section.pieces, section.pieces, section.pieces};
  options.tolerance = section.tolerance;
  options.default_friction = default_friction;
  options.jobs = job_count(jobs);
  FitReport report;
  FittedCurves curves;
  {
    ConsoleProgress progress("fit");
    curves = fit_curves(samples, options, progress.progress(), &report);
  }
  if (report.is_stopped) throw Interrupted("fit: nothing was written");
  say_report(report);
  if (report.failed == curves.status.size())
    throw Error(
        "fit", fmt::format("none of the {} test points has a usable row", report.failed),
        "See the list of experiments that are not good; press less deep or in smaller steps.");
  return curves;
}

std::size_t list_bad_points(const FittedCurves& curves) {
  std::size_t bad = 0;
  for (std::size_t p = 0; p < curves.status.size(); ++p) {
    if (curves.status[p] != FitStatus::underdetermined && curves.status[p] != FitStatus::failed)
      continue;
    if (++bad <= kListed) say("  no curves of its own: {}: {}", curves.name[p], curves.message[p]);
  }
  if (bad > kListed) say("  and {} more points", bad - kListed);
  return bad;
}

}  // namespace palpate::tools
