#include "libfit/certify/certificate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>

#include "libfit/certify/for_all.hpp"

namespace palpate::certify {
namespace {

using runtime::AssetView;

constexpr double kNearWorst = 1.1;  // bound over the worst that was found

/// Of all triangles; then those again that might be the worst and are not bounded tightly.
std::vector<Sliding> certify_all(const AssetView& asset, const std::vector<int>& triangles,
                                 OtherRings others, FacetOptions options, int threads,
                                 const Progress& progress) {
  std::vector<Sliding> out(static_cast<std::size_t>(asset.triangles));
  const auto certify_these = [&](const std::vector<int>& these) {
    for_all(static_cast<int>(these.size()), threads, progress, [&](int i) {
      const int t = these[static_cast<std::size_t>(i)];
      out[static_cast<std::size_t>(t)] = certify_sliding(asset, t, others, options);
    });
  };
  certify_these(triangles);
  double found = 0;
  for (const int t : triangles)
    found = std::max(found, out[static_cast<std::size_t>(t)].worst_found);
  if (!std::isfinite(found)) return out;
  const double near = kNearWorst * found;
  options.far = std::min(options.far, near);
  options.of_failing = 1;
  std::vector<int> again;
  for (const int t : triangles)
    if (out[static_cast<std::size_t>(t)].ratio > near) again.push_back(t);
  certify_these(again);
  return out;
}

bool is_worse(const Sliding& a, const Sliding& b) {
  if (a.verdict != b.verdict) {
    if (a.verdict == Verdict::fails || b.verdict == Verdict::fails)
      return a.verdict == Verdict::fails;
    return a.verdict == Verdict::undecided;
  }
  return a.ratio > b.ratio;
}

SlidingFigures figures_of(const AssetView& asset, const Certificate& certificate,
                          std::vector<Sliding> ToolCertificate::*kind) {
  SlidingFigures out;
  double area = 0;
  std::vector<Sliding> failures;
  for (int t = 0; t < asset.triangles; ++t) {
    const auto at = static_cast<std::size_t>(t);
    if (certificate.zone[at] != Zone::interior) continue;
    const Sliding* worst = nullptr;
    for (const ToolCertificate& tool : certificate.tools) {
      const Sliding& here = (tool.*kind)[at];
      if (worst == nullptr || is_worse(here, *worst)) worst = &here;
    }
    area += area_of(asset, t);
    out.factor_required = std::max(out.factor_required, worst->ratio);
    if (std::isfinite(worst->worst_found))
      out.factor_found = std::max(out.factor_found, worst->worst_found);
    if (worst->ratio > 0)
      out.mu_required = std::max(out.mu_required, worst->ratio * worst->friction);
    if (worst->verdict == Verdict::certified) {
      ++out.certified;
      out.certified_area += area_of(asset, t);
      continue;
    }
    ++(worst->verdict == Verdict::fails ? out.failed : out.undecided);
    out.cause_share[static_cast<int>(worst->cause)] += 1;
    if (worst->verdict == Verdict::fails) failures.push_back(*worst);
  }
  const int open = out.failed + out.undecided;
  for (double& share : out.cause_share) share /= open > 0 ? open : 1;
  out.certified_area /= area > 0 ? area : 1;
  std::stable_sort(failures.begin(), failures.end(), [](const Sliding& a, const Sliding& b) {
    return a.witness.created_J > b.witness.created_J;
  });
  for (std::size_t i = 0; i < failures.size() && i < kWitnesses; ++i)
    out.witnesses.push_back(failures[i].witness);
  return out;
}

/// To which share of their depths, in tenths, the triangles that are not certified would be.
double certified_depth_share(const AssetView& asset, const Certificate& certificate,
                             std::vector<Sliding> ToolCertificate::*kind, OtherRings others,
                             const CertifyOptions& options) {
  const auto is_certified_to = [&](int tenths) {
    std::atomic<bool> all{true};
    for (const ToolCertificate& tool : certificate.tools) {
      FacetOptions facet = options.facet;
      facet.radius_m = tool.radius_m;
      facet.depth_share *= 0.1 * tenths;
      for_all(asset.triangles, options.threads, {}, [&](int t) {
        const auto at = static_cast<std::size_t>(t);
        if (!all || certificate.zone[at] != Zone::interior ||
            (tool.*kind)[at].verdict == Verdict::certified)
          return;
        if (certify_sliding(asset, t, others, facet).verdict != Verdict::certified) all = false;
      });
    }
    return all.load();
  };
  int least = 0, most = 10;  // certified to the one, not to the other
  while (most - least > 1) {
    const int middle = (least + most) / 2;
    (is_certified_to(middle) ? least : most) = middle;
  }
  return 0.1 * least;
}

/// Slopes of f^z over a range of depths of a vertex, and its friction.
void look_at_vertex(const AssetView& asset, int v, Certificate& out) {
  const runtime::SplineView& view = asset.curves.view[runtime::kNormal];
  const float* control = asset.node(v) + asset.control_offset[runtime::kNormal];
  constexpr int kSteps = 8;  // of a piece; f' is of degree kMaxDegree - 1 at most
  for (int piece = 0; piece < view.pieces; ++piece)
    for (int i = 1; i <= kSteps; ++i) {
      const double d = view.knots[piece] + (view.knots[piece + 1] - view.knots[piece]) * i / kSteps;
      out.least_slope_N_m = std::min(out.least_slope_N_m, runtime::curve_slope(view, control, d));
    }
  if (!out.is_rings) return;
  runtime::Corner node;
  runtime::read_corner(asset, v, node);
  const double mu = node.row[runtime::kNumbersAt + 1], slope = node.row[runtime::kNumbersAt + 2];
  out.least_friction = std::min(out.least_friction, std::min(mu, mu + slope * asset.max_fitted_m));
}

void take_larger(Continuity& sum, const Continuity& one) {
  sum.touch_N = std::max(sum.touch_N, one.touch_N);
  sum.release_N = std::max(sum.release_N, one.release_N);
  sum.edge_N = std::max(sum.edge_N, one.edge_N);
  sum.knot_N = std::max(sum.knot_N, one.knot_N);
  sum.range_end_N = std::max(sum.range_end_N, one.range_end_N);
  sum.held_N = std::max(sum.held_N, one.held_N);
  sum.inside_N = std::max(sum.inside_N, one.inside_N);
  sum.stiffness_N_m = std::max(sum.stiffness_N_m, one.stiffness_N_m);
  sum.force_N = std::max(sum.force_N, one.force_N);
  sum.seen_m = std::max(sum.seen_m, one.seen_m);
  sum.ticks += one.ticks;
}

std::string in_words(const SlidingFigures& figures, int interior) {
  std::string out = fmt::format(
      "{} of {} triangles ({:.1f} % of the area) are certified, {} create "
      "energy in a replayed slip, {} are undecided",
      figures.certified, interior, 100 * figures.certified_area, figures.failed, figures.undecided);
  if (figures.is_passive())
    return out + fmt::format("; {:.0f} % of the friction is enough (mu {:.3f}), {:.0f} % is not",
                             100 * figures.factor_required, figures.mu_required,
                             99 * figures.factor_found);
  std::string causes;
  for (std::size_t i = 1; i < std::size(kCauseNames); ++i)
    if (figures.cause_share[i] > 0.005)
      causes += fmt::format("{}{} {:.0f} %", causes.empty() ? "" : ", ", kCauseNames[i],
                            100 * figures.cause_share[i]);
  out += fmt::format("; causes: {}; all are certified to {:.0f} % of their depths", causes,
                     100 * figures.depth_share);
  if (std::isfinite(figures.mu_required))
    out += fmt::format("; friction would have to be {:.2f} times itself (mu {:.2f})",
                       figures.factor_required, figures.mu_required);
  else
    out += "; on some no friction is enough";
  if (!figures.witnesses.empty())
    out += fmt::format("; the worst witness creates {:.3g} uJ of {:.3g} uJ",
                       1e6 * figures.witnesses[0].created_J, 1e6 * figures.witnesses[0].stored_J);
  return out;
}

}  // namespace

Zone zone_of(const AssetView& asset, int t) {
  if (!asset.is_solid(t)) return Zone::air;
  int measured = 0;
  for (int k = 0; k < 3; ++k) measured += asset.covered[asset.corner(t, k)] == runtime::kMeasured;
  return measured == 3 ? Zone::interior : measured > 0 ? Zone::skirt : Zone::mean;
}

double area_of(const AssetView& asset, int t) {
  const runtime::Vec3d area = asset.area_vector(t);
  return 0.5 * std::sqrt(dot(area, area));
}

namespace {

Certificate what_it_is_of(const AssetView& asset, const CertifyOptions& options) {
  Certificate out;
  out.family = runtime::row_of(static_cast<runtime::Family>(asset.curves.family)).name;
  out.sways = asset.sways;
  out.relaxes = asset.curves.relaxation.branches > 0;
  out.softens = asset.damage.softens();
  out.couples = asset.coupling != nullptr;
  out.is_rings = asset.curves.family == static_cast<int>(runtime::Family::rings);
  out.max_depth_m = asset.max_fitted_m;
  out.seen_step_m = 2 * options.facet.max_step_m;
  return out;
}

/// Returns the triangles of the interior.
std::vector<int> tell_zones(const AssetView& asset, Certificate& out) {
  double solid = 0;
  std::vector<int> interior;
  for (int t = 0; t < asset.triangles; ++t) {
    const Zone zone = zone_of(asset, t);
    out.zone.push_back(zone);
    if (zone == Zone::air) continue;
    solid += area_of(asset, t);
    if (zone == Zone::interior) interior.push_back(t);
    if (zone == Zone::skirt) ++out.skirt, out.skirt_area += area_of(asset, t);
    if (zone == Zone::mean) ++out.mean, out.mean_area += area_of(asset, t);
  }
  out.interior = static_cast<int>(interior.size());
  for (double* share : {&out.skirt_area, &out.mean_area}) *share /= solid > 0 ? solid : 1;
  return interior;
}

/// Of the other families the checks of Asset::open say all: rising curves store no less than 0.
void look_for_pulls(const AssetView& asset, const CertifyOptions& options, Certificate& out) {
  std::vector<char> pushes(out.zone.size(), 1);
  if (out.is_rings)
    for_all(asset.triangles, options.threads, {}, [&](int t) {
      const auto at = static_cast<std::size_t>(t);
      if (out.zone[at] != Zone::air) pushes[at] = pushes_on(asset, t, options.facet);
    });
  out.pulling = static_cast<int>(std::count(pushes.begin(), pushes.end(), 0));
  out.passive_fixed = out.pulling == 0;
}

ToolCertificate certify_tool(const AssetView& asset, const std::vector<int>& interior,
                             double radius_m, const CertifyOptions& options,
                             const Progress& progress, bool is_rings) {
  ToolCertificate tool;
  tool.radius_m = radius_m;
  FacetOptions facet = options.facet;
  facet.radius_m = radius_m;
  if (is_rings) {
    tool.any = certify_all(asset, interior, OtherRings::any, facet, options.threads, progress);
    tool.gross =
        certify_all(asset, interior, OtherRings::sliding, facet, options.threads, progress);
  }
  ContinuityOptions continuity = options.continuity;
  continuity.radius_m = radius_m;
  tool.continuity = measure_continuity(asset, interior, continuity);
  return tool;
}

}  // namespace

Certificate certify(const AssetView& asset, const CertifyOptions& options,
                    const Progress& progress) {
  Certificate out = what_it_is_of(asset, options);
  const std::vector<int> interior = tell_zones(asset, out);
  out.least_slope_N_m = out.least_friction = std::numeric_limits<double>::infinity();
  for (int v = 0; v < asset.vertices; ++v)
    if (asset.covered[v]) look_at_vertex(asset, v, out);
  if (!out.is_rings) out.least_friction = 0;
  look_for_pulls(asset, options, out);
  for (const double radius_m : options.radii_m)
    out.tools.push_back(certify_tool(asset, interior, radius_m, options, progress, out.is_rings));
  for (const ToolCertificate& tool : out.tools) take_larger(out.continuity, tool.continuity);
  if (!out.is_rings) return out;
  out.any = figures_of(asset, out, &ToolCertificate::any);
  out.gross = figures_of(asset, out, &ToolCertificate::gross);
  if (!out.any.is_passive())
    out.any.depth_share =
        certified_depth_share(asset, out, &ToolCertificate::any, OtherRings::any, options);
  if (!out.gross.is_passive())
    out.gross.depth_share =
        certified_depth_share(asset, out, &ToolCertificate::gross, OtherRings::sliding, options);
  return out;
}

namespace {

/// What of a body is not certified, or by another body's certificate.
std::string limits_in_words(const Certificate& c) {
  std::string out;
  if (c.relaxes)  // (M29d)
    out +=
        "The body relaxes: this is the certificate of its slow motion, and of quick slides on a "
        "body at rest. What dashpots hold after a press is left to the guard. ";
  if (c.softens)
    out +=
        "The body softens: this is the certificate of the body that nothing has pressed yet. "
        "Slides from where it is softer to where it is not are left to the guard. ";
  if (c.couples)
    out +=
        "Contacts move each other: this is the certificate of one by itself. Of several the guard "
        "keeps the sum. ";
  if (c.sways && c.is_rings)
    out += fmt::format(
        "The body sways: certified are ticks in which the tool moves by at most {:.0f} um against "
        "the surface that has swayed; in sampled ticks of 50 um it was at most {:.0f} um. ",
        1e6 * c.seen_step_m, 1e6 * c.continuity.seen_m);
  return out;
}

}  // namespace

std::string in_words(const Certificate& c) {
  std::string out = fmt::format("The body is {}certified to {:.3g} mm. ",
                                c.certified() ? "" : "not ", 1e3 * c.max_depth_m);
  if (!c.is_rings)
    out += "At a fixed contact it is passive: it stores no less than nothing. ";
  else if (c.passive_fixed)
    out += "At a fixed contact it is passive: it never pulls and stores no less than nothing. ";
  else
    out += fmt::format("At a fixed contact {} triangles may pull or store less than nothing. ",
                       c.pulling);
  if (c.is_rings)
    out += fmt::format("Sliding, whatever the rings of the contact do: {}. In gross slip: {}. ",
                       in_words(c.any, c.interior), in_words(c.gross, c.interior));
  else
    out += fmt::format("Sliding is not certified for the family {}. ", c.family);
  out += fmt::format(
      "Over the skirt ({} triangles, {:.1f} % of what can be touched) forces pass over to {}. It "
      "is "
      "not certified: slides inward from it are paid by friction or held back by the guard. ",
      c.skirt, 100 * c.skirt_area, c.mean > 0 ? "the body's mean" : "nothing");
  if (c.mean > 0)
    out += fmt::format(
        "{} triangles ({:.1f} %) have no measured corner. They answer with the mean and are not "
        "certified. ",
        c.mean, 100 * c.mean_area);
  out += limits_in_words(c);
  const Continuity& k = c.continuity;
  out += fmt::format(
      "In {} sampled ticks of 50 um the force changed by at most {:.3g} N ({:.0f} N/m): over edges "
      "{:.3g} N, at touch {:.3g} N, at release {:.3g} N. A device needs {:.2g} N s/m of its own at "
      "1 kHz.",
      k.ticks, k.stiffness_N_m * 5e-5, k.stiffness_N_m, k.edge_N, k.touch_N, k.release_N,
      0.5e-3 * k.stiffness_N_m);
  return out;
}

}  // namespace palpate::certify
