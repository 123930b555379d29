#include "libfit/refine/refine.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "libfit/core/error.hpp"
#include "libfit/core/geometry.hpp"

namespace palpate {
namespace {

void check(const FittedCurves& curves, const Surface& fine, const std::vector<char>& is_reachable,
           const Triangles& triangles) {
  const auto refuse = [](const std::string& what) {
    throw Error("refine", what, "Give the curves and the body of the same project.");
  };
  const Eigen::Index points = curves.position.rows();
  if (points == 0) refuse("the curves hold no test point");
  if (curves.normal.rows() != points || std::ssize(curves.status) != points)
    refuse("the curves' columns differ in length");
  for (const Controls& control : curves.curves.control)
    if (control.rows() != points) refuse("the curves' columns differ in length");
  if (std::ssize(is_reachable) != fine.vertices.rows())
    refuse("the body's columns differ in length");
  const auto fits = [](const Triangles& t, Eigen::Index end) {
    return t.rows() == 0 || (t.minCoeff() >= 0 && t.maxCoeff() < end);
  };
  if (!fits(triangles, points)) refuse("a test-point triangle names a point that is not there");
  if (!fits(fine.triangles, fine.vertices.rows())) refuse("a triangle names a missing vertex");
}

// Points that take part: fitted, and on the surface.
std::vector<char> usable_points(const FittedCurves& curves, const std::vector<EdgePathSeeds>& seeds,
                                std::vector<std::int32_t>& left_out) {
  std::vector<char> is_usable(seeds.size());
  for (std::size_t p = 0; p < seeds.size(); ++p) {
    is_usable[p] = curves.status[p] != FitStatus::failed && !seeds[p].empty();
    if (!is_usable[p]) left_out.push_back(p);
  }
  return is_usable;
}

// Points on which choices rest: one whose curves its own rows do not follow says little of others.
std::vector<char> trusted_points(const FittedCurves& curves, std::vector<char> is_usable) {
  for (std::size_t p = 0; p < is_usable.size(); ++p)
    if (curves.status[p] == FitStatus::poor) is_usable[p] = 0;
  return is_usable;
}

// Forces and normals of measured points that have a force, and what is made of them elsewhere.
struct KrigedPoints {
  std::vector<std::int32_t> point;
  Controls log_force;  // P x kComparedDepths
  std::optional<Kriging> force, normal;
  MeasuredPoints left_out;
};

// The surface's inward normals where points lie, between vertices: nearer ones count more.
Points surface_normals(const std::vector<EdgePathSeeds>& seeds, const Points& outward_normal) {
  Points out = Points::Zero(seeds.size(), 3);
  for (std::size_t p = 0; p < seeds.size(); ++p)
    for (const EdgePathSeed& seed : seeds[p])
      out.row(p) -= outward_normal.row(seed.vertex) / (seed.distance_m + 1e-12);
  return out;
}

KrigedPoints kriged_points(const FittedCurves& curves, const std::vector<char>& is_usable,
                           const std::vector<EdgePathSeeds>& seeds, const Points& outward_normal) {
  KrigedPoints out;
  out.log_force = log_forces(curves, is_usable);
  for (std::size_t p = 0; p < is_usable.size(); ++p)
    if (is_usable[p]) out.point.push_back(p);
  if (out.point.size() < 10 || out.point.size() > 2000) return out;  // chance; P^3
  const Points position = curves.position(out.point, Eigen::all),
               normal = curves.normal(out.point, Eigen::all);
  out.force.emplace(position, normal, out.log_force(out.point, Eigen::all));
  out.left_out = {out.log_force, curves.normal, surface_normals(seeds, outward_normal)};
  out.left_out.force(out.point, Eigen::all) = out.force->left_out();
  out.normal.emplace(position, Points(0, 3), normal);
  out.left_out.normal(out.point, Eigen::all) = out.normal->left_out();
  return out;
}

LogForces kriged_trend(const KrigedPoints& kriged, const FittedCurves& curves, const Surface& fine,
                       const Points& inward_normal) {
  Controls at_point = kriged.force->at(curves.position, curves.normal);
  at_point(kriged.point, Eigen::all) = kriged.log_force(kriged.point, Eigen::all);
  return {at_point, kriged.force->at(fine.vertices, inward_normal), true};
}

// Normals kriged from the points' own, but where they face more than 60 degrees away from the
// surface.
Points kriged_normals(const KrigedPoints& kriged, const Surface& fine, Points inward_normal) {
  const Points found = kriged.normal->at(fine.vertices, Points(0, 3));
  for (Eigen::Index v = 0; v < found.rows(); ++v) {
    const double length = found.row(v).norm();
    if (found.row(v).dot(inward_normal.row(v)) > 0.5 * std::max(length, 0.5))
      inward_normal.row(v) = found.row(v) / length;
  }
  return inward_normal;
}

// Sums in the fixed order of corners: monotone in each control value, so rows stay monotone.
// Numbers that go with a power of the force are blended over their trend (M12g), curves by depth;
// at a test point they are its own.
Controls blend_controls(const Controls& control, const Blend& blend, const LogForces& trend,
                        const runtime::Part& part, const CurveBasis* basis) {
  const int force = part.known == runtime::Known::sway ? 0 : part.force;
  Controls fine = Controls::Zero(blend.point.rows(), control.cols());
  for (Eigen::Index v = 0; v < fine.rows(); ++v) {
    for (int k = 0; k < 3; ++k) {
      const double weight = blend.weight(v, k);
      if (!(weight > 0)) continue;  // a corner without weight may hold anything
      const std::int32_t l = blend.point(v, k);
      if (!trend.is_known() || force == 0 || !(weight < 1 || trend.smooths)) {
        fine.row(v) += weight * control.row(l);
        continue;
      }
      const Eigen::RowVectorXd more = force * (trend.at_vertex.row(v) - trend.at_point.row(l));
      if (basis != nullptr)
        fine.row(v).array() +=
            weight * at_controls(*basis, more).array().exp() * control.row(l).array();
      else
        fine.row(v) += weight * std::exp(more.mean()) * control.row(l);
    }
    if (part.rises && trend.is_known()) clamp_rising(fine.row(v));
  }
  return rounded_to_float(fine);
}

// Adds the share of the test points' slopes times the offsets from them (B4); curves rise again.
void add_slopes(const FittedCurves& curves, const Surface& fine, const Blend& blend,
                const Controls& slopes, double share, Controls& normal) {
  for (Eigen::Index v = 0; v < normal.rows(); ++v) {
    Eigen::RowVectorXd more = Eigen::RowVectorXd::Zero(normal.cols());
    for (int k = 0; k < 3; ++k) {
      if (!(blend.weight(v, k) > 0)) continue;
      const std::int32_t l = blend.point(v, k);
      const Eigen::RowVector3d offset = fine.vertices.row(v) - curves.position.row(l);
      for (Eigen::Index j = 0; j < more.size(); ++j)
        more[j] += share * blend.weight(v, k) * slopes.row(l).segment<3>(3 * j).dot(offset);
    }
    more += normal.row(v);
    more[0] = 0;
    clamp_rising(more);
    normal.row(v) = more;
  }
  normal = rounded_to_float(normal);
}

Model model_of(const FittedCurves& curves, const Surface& fine, Points inward_normal, Blend blend,
               const Controls& slopes, double slope_share, const LogForces& trend) {
  Model model;
  model.surface = fine;
  model.probe = curves.probe;
  model.inward_normal = std::move(inward_normal);
  model.curves = curves.curves;
  for (std::size_t part = 0; part < model.curves.control.size(); ++part) {
    const runtime::Part& of = parts_of(model.curves.family)[part];
    model.curves.control[part] =
        blend_controls(curves.curves.control[part], blend, trend, of,
                       of.is_curve() ? &curves.curves.basis[part] : nullptr);
  }
  if (slope_share > 0)
    add_slopes(curves, fine, blend, slopes, slope_share, model.curves.control[0]);
  for (Eigen::Index v = 0; v < blend.weight.rows(); ++v)
    model.is_covered.push_back(blend.weight.row(v).sum() > 0);
  model.blend_point = std::move(blend.point);
  model.blend_weight = std::move(blend.weight);
  return model;
}

}  // namespace

Model refine(const FittedCurves& curves, const Surface& fine, const std::vector<char>& is_reachable,
             const Triangles& test_triangles, const RefineOptions& options, RefineReport* report) {
  check(curves, fine, is_reachable, test_triangles);
  RefineReport own_report;
  RefineReport& found = report != nullptr ? *report : own_report;
  found = {};
  const Points outward_normal = vertex_normals(fine);
  // Points farther than a twentieth of the diagonal off the body are left out.
  const auto seeds = place_on_surface(curves.position, curves.normal, fine, outward_normal,
                                      kMinCosine, 0.05 * extent_m(fine.vertices).norm());
  const auto is_usable = usable_points(curves, seeds, found.left_out);
  std::vector<EdgePathSeeds> usable_seeds(seeds.size());
  for (std::size_t p = 0; p < seeds.size(); ++p)
    if (is_usable[p]) usable_seeds[p] = seeds[p];

  found.triangles = test_triangles;
  found.is_own_triangulation = test_triangles.rows() == 0;
  std::vector<std::int32_t> cell;
  if (found.is_own_triangulation) {
    cell = nearest_source(fine, usable_seeds).source;
    found.triangles = triangulate_over(fine, cell, curves.position, curves.normal);
  }
  Blend blend = found.triangles.rows() == 0
                    ? blend_by_cell(cell, is_reachable)
                    : blend_by_area(curves, fine, outward_normal, is_reachable, found.triangles,
                                    is_usable, seeds);
  found.largest_projection_m = blend.largest_projection_m;
  const Controls slopes = slopes_of(curves);
  InterpolationChoice& chosen = found.interpolation;
  std::vector<char> is_trusted = trusted_points(curves, is_usable);
  const KrigedPoints kriged = options.is_measured
                                  ? kriged_points(curves, is_usable, seeds, outward_normal)
                                  : KrigedPoints();
  // The surface of measured points is not sure enough.
  const bool may_follow = options.tool && !options.is_measured;
  const GapForces gap = may_follow ? gap_forces(curves, fine, outward_normal, is_reachable,
                                                usable_seeds, *options.tool)
                                   : GapForces();
  chosen =
      choose_interpolation(curves, found.triangles, is_trusted, slopes, gap.force, kriged.left_out);
  const Points inward_normal = chosen.kriges_normals ? kriged_normals(kriged, fine, -outward_normal)
                                                     : Points(-outward_normal);
  if (chosen.is_kriged) found.trend = kriged_trend(kriged, curves, fine, inward_normal);
  if (chosen.follows_gap)
    found.trend = {kGapShare * gap.force.at_point, kGapShare * gap.force.at_vertex};
  Model model = model_of(curves, fine, inward_normal, std::move(blend), slopes, chosen.slope_share,
                         found.trend);
  if (chosen.follows_gap && model.curves.family == CurveFamily::rings) {
    Controls& effect = model.curves.control[runtime::kRadiusEffect];
    if (effect.col(0).isZero(0))  // no second indenter was pressed
      effect.col(0) = gap.radius_effect.array() * (1 - effect.col(1).array());
    effect = rounded_to_float(effect);
  }
  for (std::size_t v = 0; v < is_reachable.size(); ++v)
    if (is_reachable[v] && !model.is_covered[v]) found.uncovered.push_back(v);
  return model;
}

Model refine(const FittedCurves& curves, const Body& body, const RefineOptions& options,
             RefineReport* report) {
  const double size_m = extent_m(body.surface.vertices).norm();
  return refine(curves, body.surface, body.in_region,
                match_triangles(curves.position, body.test_points, size_m), options, report);
}

}  // namespace palpate
