#include "tools/stages/fit.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "libfem/probes/probes.hpp"
#include "libfit/core/error.hpp"
#include "libfit/core/experiments.hpp"
#include "libfit/fit/contact_effects.hpp"
#include "libfit/fit/fit_curves.hpp"
#include "tools/console.hpp"

namespace palpate::tools {
namespace {

constexpr std::size_t kListed = 15;  // points named before "and N more"

void say_report(const FitReport& report) {
  say("  family   {}: {}", kCurveFamilyNames[static_cast<std::size_t>(report.family.family)].name,
      report.family.reason);
  for (int kind = 0; kind < static_cast<int>(curves_of(report.family.family)); ++kind) {
    const auto k = static_cast<std::size_t>(kind);
    const CurveBasis& basis = report.kind[k].basis;
    say("  {:<8} {} pieces of degree {} to {:.2f} mm: {}", kCurveNames[k], basis.pieces(),
        basis.degree, 1e3 * basis.knots_m.back(), report.kind[k].reason);
  }
  if (!report.assumed.empty()) say("  assumed: {}", report.assumed);
  say("  rows: {} fitted of {} ({} not good, {} not finite, {} after a bad one)", report.rows.used,
      report.rows.all, report.rows.not_good, report.rows.not_finite, report.rows.cut);
  say("  residual: median {:.2f} %, p95 {:.2f} %, max {:.2f} % of force", 100 * report.error.median,
      100 * report.error.p95, 100 * report.error.max);
  say("  points: {} good, {} poor, {} underdetermined, {} failed ({})", report.points.good,
      report.points.poor, report.points.underdetermined, report.points.failed,
      in_words(report.seconds));
  for (const WorstPoint& p : report.worst)
    say("  worst: {} at ({:.1f}, {:.1f}, {:.1f}) mm: rms {:.2g} N, {:.1f} % of force; {}", p.name,
        1e3 * p.position[0], 1e3 * p.position[1], 1e3 * p.position[2], p.rms_residual_N,
        100 * p.relative_residual, p.reason);
}

void say_recordings(const FittedRecordings& recordings) {
  const std::size_t count = recordings.experiment.size();
  for (std::size_t i = 0; i < std::min(count, kListed); ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    say("  experiment {}: contact {:+.3g} +- {:.2g} mm, bias {:+.3g} +- {:.2g} N, drift {:+.3g} +- "
        "{:.2g} N",
        recordings.experiment[i], 1e3 * recordings.contact_m[at],
        1e3 * recordings.contact_deviation_m[at], recordings.bias_N[at],
        recordings.bias_deviation_N[at], recordings.drift_N[at], recordings.drift_deviation_N[at]);
  }
  if (count > kListed) say("  and {} more experiments", count - kListed);
}

void say_fit(const FittedCurves& curves, const FitReport& report) {
  if (report.is_stopped) throw Interrupted("fit: nothing was written");
  say_report(report);
  say_recordings(curves.recordings);
  if (report.points.failed == curves.status.size())
    throw Error(
        "fit", fmt::format("none of the {} test points has a usable row", report.points.failed),
        "See the list of experiments that are not good; press less deep or in smaller steps.");
}

// Identifies the softening of the body, into the curves.
void add_damage(FittedCurves& curves, const Samples& cycles) {
  fit::DamageReport report;
  curves.curves.damage = fit::identify_damage(curves, cycles, &report);
  const runtime::DamageView& damage = curves.curves.damage;
  if (!damage.softens()) {
    say("  damage   none: {} cycles of {} rows, {:.1f} % off without it (median)", report.cycles,
        report.rows, 100 * report.undamaged.median);
    return;
  }
  say("  damage   r {:.3g}, m {:.3g} of a whole press's energy, beta {:.3g}: {} cycles of {} rows "
      "are off by {:.1f} % (median), {:.1f} % (p95); without it {:.1f} % and {:.1f} %",
      damage.r, damage.scale, damage.beta, report.cycles, report.rows, 100 * report.damaged.median,
      100 * report.damaged.p95, 100 * report.undamaged.median, 100 * report.undamaged.p95);
  say("           standard deviations: r {:.2g} %, m {:.2g} %, beta {:.2g} %",
      100 * report.deviation[0], 100 * report.deviation[1], 100 * report.deviation[2]);
}

// Identifies how curves change with the indenter's radius, into the curves.
void add_radius_effect(FittedCurves& curves, const Samples& others) {
  std::vector<Indenter> ends;
  for (const ProbeSpec& spec : others.other_probes) {
    const auto end = fem::round_end(fem::make_probe(spec, "[[experiments.probe]]"));
    if (!end)
      throw Error("[[experiments.probe]]", "is not round along its press",
                  "Take a ball, a cone, a rod or another shape that is.");
    ends.push_back(*end);
  }
  fit::RadiusReport report;
  fit::identify_radius_effect(curves, others, ends, &report);
  if (others.rows() == 0) return;
  if (curves.curves.family != CurveFamily::rings || report.points == 0) {
    say("  radius   {}", curves.curves.family == CurveFamily::rings
                             ? "no press of another tool can be used"
                             : "what it changes is known of rings alone, and the law is another");
    return;
  }
  const auto words = [](const RelativeErrors& e) {
    return fmt::format("{:.1f} and {:.1f} %", 100 * e.median, 100 * e.p95);
  };
  say("  radius   {} presses' rows of other tools at {} points, median and p95: as the own ball "
      "{}, theory alone {}, of left out points {} ({}), as fitted {}",
      report.rows, report.points, words(report.as_own_ball), words(report.theory),
      words(report.left_out), report.chosen, words(report.fitted));
}

}  // namespace

FitOptions fit_options(const Samples& samples, const FitSection& section, int jobs) {
  FitOptions options = options_for(samples);
  std::vector<std::string_view> names;
  for (const CurveFamilyName& row : kCurveFamilyNames) names.push_back(row.name);
  if (std::ranges::find(names, section.family) == names.end())
    throw Error("--family", "unknown curve family \"" + section.family + "\"",
                fmt::format("Use one of: {}.", fmt::join(names, ", ")));
  options.family = section.family == name_of(CurveFamily::separable) ? CurveFamily::separable
                                                                     : CurveFamily::rings;
  options.degree = section.degree;
  options.pieces = {section.pieces, section.pieces, section.pieces};
  options.tolerance = section.tolerance;
  options.jobs = job_count(jobs);
  return options;
}

FittedCurves fit_samples(const Samples& all, const FitSection& section, int jobs,
                         const FitOptions& choices) {
  const Samples samples =
      of_kinds(all, {ExperimentKind::press, ExperimentKind::drag, ExperimentKind::path});
  FitOptions options = fit_options(all, section, jobs);
  const Samples others = of_kinds(all, {ExperimentKind::other});
  options.warm_start = choices.warm_start;
  options.estimates = choices.estimates;
  FitReport report;
  FittedCurves curves;
  {
    ConsoleProgress progress("fit");
    curves = fit_curves(samples, options, progress.progress(), &report);
  }
  say_fit(curves, report);
  curves.probe = samples.probe;
  if (const Samples cycles = of_kinds(all, {ExperimentKind::cycle}); cycles.rows() > 0)
    add_damage(curves, cycles);
  add_radius_effect(curves, others);
  return curves;
}

std::size_t list_bad_points(const FittedCurves& curves, bool is_quick) {
  std::size_t guessed = 0, poor = 0, listed = 0;
  for (const FitStatus status : curves.status) {
    guessed += status == FitStatus::failed || (status == FitStatus::underdetermined && !is_quick);
    poor += status == FitStatus::poor;
  }
  // None of the shipped block and liver are poor. At a half a spleen with 28 of 48 is just found,
  // and at an eighth one bad recording of eight fails a rig.
  const bool are_too_many = 4 * (guessed + poor) >= curves.status.size();
  const std::size_t bad = guessed + (are_too_many ? poor : 0);
  for (std::size_t p = 0; p < curves.status.size(); ++p) {
    const bool is_poor = curves.status[p] == FitStatus::poor;
    const bool is_guessed = curves.status[p] == FitStatus::underdetermined && !is_quick;
    if (is_poor ? !are_too_many : !is_guessed && curves.status[p] != FitStatus::failed) continue;
    if (++listed <= kListed)
      say_failed("  {}: {}: {}", is_poor ? "poor" : "no curves of its own", curves.name[p],
                 curves.message[p]);
  }
  if (bad > kListed) say_failed("  and {} more points", bad - kListed);
  if (are_too_many && poor > 0)
    say_failed(
        "  {} of {} points are poor or have no curves of their own: the asset is far from its rows "
        "there. Look at the residuals of these points (`palpate report`): a contact point or an "
        "axis that is off, a body that is not held, or a law that it does not follow (`family`).",
        bad, curves.status.size());
  return bad;
}

}  // namespace palpate::tools
