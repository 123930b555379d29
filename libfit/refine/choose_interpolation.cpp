#include "libfit/refine/interpolation.hpp"

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <set>

#include "libfit/core/curves.hpp"
#include "libfit/core/stated_error.hpp"
#include "libfit/core/statistics.hpp"

namespace palpate {
namespace {

constexpr int kShares = 4;  // eighths up to a half

// Usable points within two edges of a point that face as it does.
std::vector<std::int32_t> points_around(const FittedCurves& curves, const Neighbours& neighbours,
                                        const std::vector<char>& is_usable, std::int32_t point) {
  std::set<std::int32_t> found;
  for (const std::int32_t q : neighbours.of(point)) {
    found.insert(q);
    for (const std::int32_t r : neighbours.of(q)) found.insert(r);
  }
  found.erase(point);
  std::erase_if(found, [&](std::int32_t q) {  // the other side of a thin body, too
    return is_usable[q] == 0 || curves.normal.row(q).dot(curves.normal.row(point)) < 0.3;
  });
  return {found.begin(), found.end()};
}

// A place as a blend of three points.
struct BlendPoints {
  std::array<std::int32_t, 3> point{};
  Vec3 weight = Vec3::Zero();
  double size = std::numeric_limits<double>::infinity();
};

// Area coordinates of the origin, and the radius of the circle through the corners.
std::optional<BlendPoints> around_origin(const std::array<Eigen::Vector2d, 3>& at) {
  const auto cross = [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    return a.x() * b.y() - a.y() * b.x();
  };
  const double area = cross(at[1] - at[0], at[2] - at[0]);
  BlendPoints out;
  out.weight = Vec3(cross(at[1], at[2]), cross(at[2], at[0]), cross(at[0], at[1])) / area;
  if (!(out.weight.minCoeff() >= 0)) return std::nullopt;
  out.size = (at[1] - at[0]).norm() * (at[2] - at[1]).norm() * (at[0] - at[2]).norm() /
             (2 * std::abs(area));
  return out;
}

// The smallest triangle of the points near that has the point inside: the one that would answer
// for its place if it were not there.
std::optional<BlendPoints> without(const FittedCurves& curves,
                                   const std::vector<std::int32_t>& near, std::int32_t point) {
  const Vec3 normal = curves.normal.row(point);
  const Vec3 first = normal.unitOrthogonal(), second = normal.cross(first);
  std::vector<Eigen::Vector2d> flat;
  for (const std::int32_t q : near) {
    const Vec3 offset = (curves.position.row(q) - curves.position.row(point)).transpose();
    flat.emplace_back(offset.dot(first), offset.dot(second));
  }
  std::optional<BlendPoints> best;
  for (std::size_t a = 0; a < near.size(); ++a)
    for (std::size_t b = a + 1; b < near.size(); ++b)
      for (std::size_t c = b + 1; c < near.size(); ++c) {
        std::optional<BlendPoints> found = around_origin({flat[a], flat[b], flat[c]});
        if (!found || (best && !(found->size < best->size))) continue;
        found->point = {near[a], near[b], near[c]};
        best = found;
      }
  return best;
}

// The place on a line between two of the points near that is nearest to the point: what answers for
// a place at the rim.
std::optional<BlendPoints> beside(const FittedCurves& curves, const std::vector<std::int32_t>& near,
                                  std::int32_t point) {
  std::optional<BlendPoints> best;
  const auto offset = [&](std::int32_t q) {
    return Vec3((curves.position.row(q) - curves.position.row(point)).transpose());
  };
  for (std::size_t a = 0; a < near.size(); ++a)
    for (std::size_t b = a + 1; b < near.size(); ++b) {
      const Vec3 from = offset(near[a]), along = offset(near[b]) - from;
      const double share =
          along.norm() > 0 ? std::clamp(-from.dot(along) / along.squaredNorm(), 0.0, 1.0) : 0;
      const double away = (from + share * along).norm();
      if (best && !(away < best->size)) continue;
      best = BlendPoints{{near[a], near[b], near[b]}, Vec3(1 - share, share, 0), away};
    }
  return best;
}

// Normal curves of a point left out: its own, and those predicted from its neighbours.
enum Prediction : int { truth, plain, slope, over_gap, kriged, kPredictions };

struct Evidence {
  const FittedCurves& curves;
  const Controls& slopes;
  const LogForces& gap;
  const Controls& log_force;
  const Controls& kriged_force;
};

Controls normal_controls(const Evidence& of, std::int32_t p, const BlendPoints& around) {
  const Controls& normal = of.curves.curves.control[0];
  Controls control = Controls::Zero(kPredictions, normal.cols());
  const auto scaled = [&](const Eigen::RowVectorXd& part, const Eigen::RowVectorXd& log_force) {
    const Eigen::RowVectorXd more = at_controls(of.curves.curves.basis[0], log_force);
    return Eigen::RowVectorXd(part.cwiseProduct(more.array().exp().matrix()));
  };
  control.row(truth) = normal.row(p);
  for (int k = 0; k < 3; ++k) {
    const std::int32_t l = around.point[k];
    const Eigen::RowVectorXd part = around.weight[k] * normal.row(l);
    const Vec3 offset = (of.curves.position.row(p) - of.curves.position.row(l)).transpose();
    control.row(plain) += part;
    for (Eigen::Index j = 0; j < normal.cols() && of.slopes.cols() > 0; ++j)
      control(slope, j) +=
          around.weight[k] * of.slopes.row(l).segment<3>(3 * j).dot(offset.transpose());
    if (of.gap.is_known())
      control.row(over_gap) +=
          scaled(part, kGapShare * (of.gap.at_point.row(p) - of.gap.at_point.row(l)));
    if (of.kriged_force.size() > 0)
      control.row(kriged) += scaled(part, of.kriged_force.row(p) - of.log_force.row(l));
  }
  for (const int as : {over_gap, kriged}) clamp_rising(control.row(as));
  return control;
}

// Mean relative errors of a point left out: with shares of slopes, then as predicted.
struct LeftOutErrors {
  std::array<double, kShares + 1> share{};
  std::array<double, kPredictions> as{};
};
void add_errors(const FittedCurves& curves, const Controls& control, LeftOutErrors& errors) {
  CurveSet rows(curves.curves.family);
  rows.basis = curves.curves.basis;
  rows.control[0] = control;
  const NodeForces forces(rows);
  const double range_m = curves.curves.basis[0].knots_m.back();
  for (int step = 1; step <= kComparedDepths; ++step) {
    const double depth_m = range_m * step / kComparedDepths,
                 true_N = forces.normal_N(truth, depth_m);
    if (!(true_N > 0)) continue;
    const double plain_N = forces.normal_N(plain, depth_m),
                 slope_N = forces.normal_N(slope, depth_m);
    for (int share = 0; share <= kShares; ++share)
      errors.share[share] +=
          std::abs(plain_N + 0.125 * share * slope_N - true_N) / true_N / kComparedDepths;
    for (const int as : {over_gap, kriged})
      errors.as[as] += std::abs(forces.normal_N(as, depth_m) - true_N) / true_N / kComparedDepths;
  }
}

double angle(const Vec3& a, const Vec3& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

// The rule: kriging for measured points, else the gap's force, else slopes, each unless it errs
// more than what is left. Fewer than four points agree on slopes by chance. gap_ratio:
// median error over the gap's force, over that by area; medians, as one point beside a fold
// outweighs all others in a mean.
void choose(bool knows_gap, double gap_ratio, double best_share, InterpolationChoice& out) {
  out.error = out.plain_error;
  if (out.points >= 4 && out.slope_error < 0.95 * out.plain_error) {
    out.slope_share = best_share;
    out.error = out.slope_error;
  }
  // The method that is expected to be better is not used where its error exceeds what chance alone
  // makes it.
  const double by_chance = 1 + 1 / std::sqrt(double(out.points));
  out.follows_gap = knows_gap && gap_ratio < by_chance &&
                    !(out.slope_share > 0 && out.slope_error < out.gap_error);
  if (out.follows_gap) out.error = out.gap_error;
  out.kriges_normals =
      out.kriged_error > 0 && out.kriged_normal_rad < by_chance * out.surface_normal_rad;
  out.is_kriged = out.kriged_error > 0 && out.kriged_error < by_chance * out.error;
  if (out.is_kriged) out.error = out.kriged_error;
  if (out.follows_gap || out.is_kriged) out.slope_share = 0;
}

// Normal curves of points left out, as the model interpolates.
Controls left_out_normal(const InterpolationChoice& chosen,
                         const std::array<Controls, kPredictions>& normal) {
  Controls out = chosen.is_kriged ? normal[kriged]
                 : chosen.follows_gap
                     ? normal[over_gap]
                     : Controls(normal[plain] + chosen.slope_share * normal[slope]);
  for (Eigen::Index row = 0; row < out.rows(); ++row) {
    out(row, 0) = 0;
    clamp_rising(out.row(row));
  }
  return out;
}

}  // namespace

Controls log_forces(const FittedCurves& curves, const std::vector<char>& is_usable) {
  const NodeForces forces(curves.curves);
  const double range_m = curves.curves.basis[0].knots_m.back();
  Controls force_N = Controls::Zero(curves.curves.points(), kComparedDepths);
  for (Eigen::Index p = 0; p < force_N.rows(); ++p)
    for (int k = 0; k < kComparedDepths && is_usable[p] != 0; ++k)
      force_N(p, k) = forces.normal_N(p, range_m * (k + 1) / kComparedDepths);
  const double floor_N = relative_floor_N(force_N.maxCoeff());
  return force_N.cwiseMax(floor_N).array().log();
}

InterpolationChoice choose_interpolation(const FittedCurves& curves, const Triangles& triangles,
                                         const std::vector<char>& is_usable, const Controls& slopes,
                                         const LogForces& gap, const MeasuredPoints& measured) {
  InterpolationChoice out;
  const Controls log_force = log_forces(curves, is_usable);
  const Evidence evidence{curves, slopes, gap, log_force, measured.force};
  LeftOutErrors errors;
  std::vector<double> by_area, by_gap;  // of each point
  std::array<Controls, kPredictions> normal;
  normal.fill(Controls(0, curves.curves.control[0].cols()));
  const Neighbours neighbours(triangles, curves.curves.points());
  const std::int32_t points = curves.curves.points();
  // More than 500 points, evenly taken, do not change the choice.
  for (std::int32_t p = 0; p < points; p += 1 + points / 500) {
    if (is_usable[p] == 0) continue;
    const auto near = points_around(curves, neighbours, is_usable, p);
    auto around = without(curves, near, p);
    if (!around && measured.is_there()) around = beside(curves, near, p);  // at the rim
    if (!around) continue;
    const Controls control = normal_controls(evidence, p, *around);
    for (int as = plain; as < kPredictions; ++as) {
      normal[as].conservativeResize(out.points + 1, Eigen::NoChange);
      normal[as].row(out.points) = control.row(as);
    }
    if (measured.is_there()) {
      const Vec3 own = curves.normal.row(p);
      out.surface_normal_rad += angle(measured.surface_normal.row(p), own);
      out.kriged_normal_rad += angle(measured.normal.row(p), own);
    }
    out.left_out.push_back(p);
    ++out.points;
    const LeftOutErrors before = errors;
    add_errors(curves, control, errors);
    by_area.push_back(errors.share[0] - before.share[0]);
    by_gap.push_back(errors.as[over_gap] - before.as[over_gap]);
  }
  if (out.points == 0) {
    out.follows_gap = gap.is_known();
    return out;
  }
  for (double& e : errors.share) e /= out.points;
  for (double& e : errors.as) e /= out.points;
  out.surface_normal_rad /= out.points;
  out.kriged_normal_rad /= out.points;
  const auto best = std::min_element(errors.share.begin(), errors.share.end());
  out.plain_error = errors.share[0];
  out.slope_error = *best;
  if (gap.is_known()) out.gap_error = errors.as[over_gap];
  if (measured.is_there()) out.kriged_error = errors.as[kriged];
  choose(gap.is_known(), median(by_gap) / median(by_area),
         0.125 * double(best - errors.share.begin()), out);
  out.left_out_normal = left_out_normal(out, normal);
  return out;
}

}  // namespace palpate
