#include "tools/stages/fit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "libfit/core/error.hpp"
#include "libfit/core/experiments.hpp"
#include "libfit/core/units.hpp"
#include "libfit/fit/fit_curves.hpp"
#include "libfit/io/files/files.hpp"
#include "libfit/refine/points_on_surface.hpp"
#include "libfit/refine/refine.hpp"
#include "libfit/refine/side_force.hpp"
#include "tools/console.hpp"
#include "tools/stages/samples/coupling.hpp"
#include "tools/stages/samples/cycles.hpp"
#include "tools/stages/samples/sample_cache.hpp"
#include "tools/stages/shape.hpp"

namespace palpate::tools {
namespace {

constexpr std::size_t kListed = 15;  // points named before "and N more"

void say_smoothing(const FitReport& report) {
  for (std::size_t k = 0; k < kCurveKinds; ++k) {
    const SmoothingReport& kind = report.smoothing[k];
    if (kind.strength == 0) {
      if (!kind.evidence.empty())
        say("  {:<8} not smoothed over neighbours: {}", kCurveNames[k], kind.reason);
      continue;
    }
    say("  {:<8} smoothed over {} neighbours of {} points, strength {:.3g}: {}; moved by {:.2g} of "
        "their standard errors (median), {:.2g} at point {}",
        kCurveNames[k], kind.neighbours, kind.points, kind.strength, kind.reason, kind.median_move,
        kind.largest_move, kind.largest_point);
  }
}

void say_report(const FitReport& report) {
  say("  family   {}: {}", kCurveFamilyNames[static_cast<std::size_t>(report.family.family)].name,
      report.family.reason);
  if (!report.degree_reason.empty())
    say("  degree   {}: {}", report.kind[0].basis.degree, report.degree_reason);
  for (int kind = 0; kind < static_cast<int>(curves_of(report.family.family)); ++kind) {
    const auto k = static_cast<std::size_t>(kind);
    const CurveBasis& basis = report.kind[k].basis;
    say("  {:<8} {} pieces of degree {} to {:.2f} mm: {}", kCurveNames[k], basis.pieces(),
        basis.degree, 1e3 * basis.knots_m.back(), report.kind[k].reason);
  }
  if (const RingsReport& rings = report.rings; rings.points > 0) {
    say("  rings    lambda {:.3g} +- {:.2g}, mu0 {:.3g} +- {:.2g}, mu1 {:.3g} +- {:.2g} /m, side "
        "force +- {:.2g} % of the normal one ({} points with drags; standard errors of a point's)"
        "{}{}",
        rings.lambda, rings.lambda_deviation, rings.friction, rings.friction_deviation,
        rings.friction_slope_1_m, rings.friction_slope_deviation_1_m, 100 * rings.side_deviation,
        rings.points, rings.warning.empty() ? "" : "; ", rings.warning);
    if (!rings.uneven.empty())
      say("  rings    lambda is uneven at {} points: {}", rings.uneven.size(),
          fmt::join(rings.uneven, ", "));
  }
  if (!report.assumed.empty()) say("  assumed: {}", report.assumed);
  say("  rows: {} fitted of {} ({} not good, {} not finite, {} after a bad one)", report.rows_used,
      report.rows, report.rows_not_good, report.rows_not_finite, report.rows_cut);
  say("  residual: median {:.2f} %, p95 {:.2f} %, max {:.2f} % of force",
      100 * report.median_relative_error, 100 * report.p95_relative_error,
      100 * report.max_relative_error);
  say_smoothing(report);
  for (std::size_t k = 0; k < kCurveKinds; ++k)
    if (report.widest_point[k] >= 0)
      say("  {:<8} 90 % band where its rows end: median {:.2g} % of force, widest {:.2g} % at "
          "point "
          "{}",
          kCurveNames[k], 100 * report.median_band[k], 100 * report.widest_band[k],
          report.widest_point[k]);
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
  if (report.failed == curves.status.size())
    throw Error(
        "fit", fmt::format("none of the {} test points has a usable row", report.failed),
        "See the list of experiments that are not good; press less deep or in smaller steps.");
}

}  // namespace

FitOptions fit_options(const Samples& samples, const FitSection& section, int jobs) {
  const auto is_known = [&](const CurveFamilyName& row) { return row.name == section.family; };
  std::vector<std::string_view> names;
  for (const CurveFamilyName& row : kCurveFamilyNames) names.push_back(row.name);
  if (section.family != "auto" &&
      std::none_of(kCurveFamilyNames.begin(), kCurveFamilyNames.end(), is_known))
    throw Error("--family", "unknown curve family \"" + section.family + "\"",
                fmt::format("Use auto or one of: {}.", fmt::join(names, ", ")));
  FitOptions options = options_for(samples);
  for (const CurveFamilyName& row : kCurveFamilyNames)
    if (row.name == section.family) options.family = row.family;
  options.degree = section.degree;
  options.pieces = {section.pieces, section.pieces, section.pieces};
  options.tolerance = section.tolerance;
  options.smoothing = section.smoothing;
  // What simulated rows leave is the family's, not noise that neighbours average.
  if (!options.smoothing && samples.recordings.size() == 0) options.smoothing = 0;
  options.jobs = job_count(jobs);
  return options;
}

FittedCurves fit_samples(const Samples& all, const FitSection& section, int jobs, const Body* body,
                         const WarmStart& warm, const NuisanceChoice& nuisances, FitCache* cache) {
  const Samples samples =
      of_kinds(all, {ExperimentKind::press, ExperimentKind::drag, ExperimentKind::path});
  FitOptions options = fit_options(samples, section, jobs);
  options.warm_start = warm.curves;
  options.warm_cache = warm.cache;
  options.estimates = nuisances.estimates;
  options.contact_deviation_m = nuisances.contact_deviation_m;
  if (body != nullptr) options.triangles = neighbour_triangles(samples, *body);
  FitReport report;
  FittedCurves curves;
  {
    ConsoleProgress progress("fit");
    curves = fit_curves(samples, options, progress.progress(), &report, cache);
  }
  say_fit(curves, report);
  curves.probe = samples.probe;
  if (const Samples cycles = of_kinds(all, {ExperimentKind::cycle}); cycles.rows() > 0)
    add_damage(curves, cycles, all.recordings.size() > 0);
  return curves;
}

NuisanceChoice nuisance_choice(const std::string& names, const std::string& contact_deviation) {
  NuisanceChoice choice;
  for (std::size_t begin = 0; begin < names.size();) {
    const std::size_t end = std::min(names.find(',', begin), names.size());
    const std::string name = names.substr(begin, end - begin);
    const auto row = std::ranges::find(kNuisanceNames, name);
    if (row == kNuisanceNames.end())
      throw Error("--free", "there is nothing called \"" + name + "\" to free",
                  "Use contact, bias, drift, or several with commas between.");
    choice.estimates[static_cast<std::size_t>(row - kNuisanceNames.begin())] = true;
    begin = end + 1;
  }
  if (contact_deviation.empty()) return choice;
  const auto length = parse_quantity(contact_deviation, Dimension::length);
  if (!length || !(*length > 0))
    throw Error("--contact-deviation", "\"" + contact_deviation + "\" is no length above 0",
                "Give a length with its unit, such as \"0.1 mm\".");
  choice.contact_deviation_m = *length;
  return choice;
}

std::optional<double> smoothing_choice(const std::string& text) {
  if (text == "auto") return std::nullopt;
  if (text == "none") return 0;
  double strength = -1;
  const char* const end = text.data() + text.size();
  const auto found = std::from_chars(text.data(), end, strength);
  if (found.ec != std::errc{} || found.ptr != end || !(strength >= 0) ||
      !(strength <= kStrongestSmoothing))
    throw Error("--smoothing", "\"" + text + "\" is no strength of smoothing",
                "Use auto, none or a number from 0 to 1e12.");
  return strength;
}

Triangles neighbour_triangles(const Samples& samples, const Body& body) {
  const double size_m = extent_m(body.surface.vertices).norm();
  const Triangles own = match_triangles(samples.point_position, body.test_points, size_m);
  if (own.rows() > 0) return own;
  const RefineOptions options;
  const auto seeds = place_on_surface(samples.point_position, samples.point_normal, body.surface,
                                      vertex_normals(body.surface), options.largest_angle_rad,
                                      options.largest_stray_diagonals * size_m);
  return triangulate_over(body.surface, nearest_source(body.surface, seeds).source,
                          samples.point_position, samples.point_normal, options.largest_angle_rad);
}

std::size_t list_bad_points(const FittedCurves& curves, bool is_quick) {
  std::size_t bad = 0;
  for (std::size_t p = 0; p < curves.status.size(); ++p) {
    const bool is_guessed = curves.status[p] == FitStatus::underdetermined && !is_quick;
    if (!is_guessed && curves.status[p] != FitStatus::failed) continue;
    if (++bad <= kListed)
      say_failed("  no curves of its own: {}: {}", curves.name[p], curves.message[p]);
  }
  if (bad > kListed) say_failed("  and {} more points", bad - kListed);
  return bad;
}

Samples read_known(const std::filesystem::path& samples) {
  return std::filesystem::exists(surface_path(samples)) ? read_with_surface(samples)
                                                        : read_samples(samples);
}

Model refine_body(const FittedCurves& curves, const Body& body, const RefineOptions& options,
                  const Samples& samples, const Scene* scene) {
  RefineReport report;
  Model model = refine(curves, body, options, &report);
  if (static_cast<Eigen::Index>(report.left_out.size()) == curves.position.rows())
    throw Error("curves",
                fmt::format("none of the {} test points lies on this body with curves of its own",
                            curves.position.rows()),
                "Name the body.h5 that the samples were taken on; `fit` lists points without "
                "curves.");
  say("  {} test points spread over {} triangles{}; largest distance of a vertex {:.2f} mm",
      curves.position.rows() - static_cast<Eigen::Index>(report.left_out.size()),
      report.triangles.rows(),
      report.is_own_triangulation ? " made for them, since they are not the body's own" : "",
      1e3 * report.largest_projection_m);
  if (const InterpolationChoice& chosen = report.interpolation; chosen.points > 0)
    say("  {} test points left out are predicted to {:.1f} % (mean) by area alone, {:.1f} % with "
        "the slopes of side forces, {:.1f} % with the shape of the surface: {}",
        chosen.points, 100 * chosen.plain_error, 100 * chosen.slope_error, 100 * chosen.shape_error,
        chosen.follows_shape     ? "forces follow the shape"
        : chosen.slope_share > 0 ? fmt::format("{:.3g} of the slopes count", chosen.slope_share)
                                 : "area alone");
  if (curves.curves.family == CurveFamily::rings) {
    const SideMismatch off = side_mismatch(model);
    say("  side force off the slope of the normal energy by {:.2g} % of the normal force (median), "
        "{:.2g} % (p95), {:.2g} % (max)",
        100 * off.median, 100 * off.p95, 100 * off.max);
  }
  for (const auto point : report.left_out) {
    const auto p = static_cast<std::size_t>(point);
    say("  left out: {}: {}", curves.name[p],
        curves.message[p].empty() ? "too far from the surface" : curves.message[p]);
  }
  if (!report.uncovered.empty())
    say("  {} reachable vertices are answered for by no test point", report.uncovered.size());
  model.probe = curves.probe;
  if (samples.surface.rows() > 0)
    add_shape(model, of_kinds(samples, {ExperimentKind::press, ExperimentKind::drag}));
  if (scene != nullptr) add_coupling(model, *scene, samples);
  return model;
}

std::optional<double> slope_share_choice(const std::string& text) {
  if (text == "auto") return std::nullopt;
  double share = -1;
  const char* const end = text.data() + text.size();
  const auto found = std::from_chars(text.data(), end, share);
  if (found.ec != std::errc{} || found.ptr != end || !(share >= 0 && share <= 0.5))
    throw Error("--slope-share", "\"" + text + "\" is no share of slopes",
                "Use auto or a number from 0 to 0.5.");
  return share;
}

std::optional<bool> follow_shape_choice(const std::string& text) {
  if (text == "auto") return std::nullopt;
  if (text != "yes" && text != "no")
    throw Error("--follow-shape", "\"" + text + "\" is no choice", "Use auto, yes or no.");
  return text == "yes";
}

}  // namespace palpate::tools
