#include "libfit/refine/choose_interpolation.hpp"

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <set>

#include "libfit/core/node_forces.hpp"
#include "libfit/refine/edge_paths.hpp"

namespace palpate {
namespace {

constexpr int kDepths = 4;
constexpr int kShares = 4;  // eighths up to a half
// Fewer points agree by chance, with the trend's four numbers more than with one.
constexpr int kMinPoints = 4, kMinShapePoints = 6;
constexpr int kMaxPoints = 500;      // evenly taken: more tell nothing new
constexpr double kFacesAlike = 0.3;  // cosine: not the other side of a thin body
// Of the error without.
constexpr double kSlopesPay = 0.95, kShapePays = 0.9, kKrigingPays = 0.95;

// Usable points within two edges of a point that face as it does.
std::vector<std::int32_t> points_around(const FittedCurves& curves, const Neighbours& neighbours,
                                        const std::vector<char>& is_usable, std::int32_t point) {
  std::set<std::int32_t> found;
  for (const std::int32_t q : neighbours.of(point)) {
    found.insert(q);
    for (const std::int32_t r : neighbours.of(q)) found.insert(r);
  }
  found.erase(point);
  std::erase_if(found, [&](std::int32_t q) {
    return is_usable[static_cast<std::size_t>(q)] == 0 ||
           curves.normal.row(q).dot(curves.normal.row(point)) < kFacesAlike;
  });
  return {found.begin(), found.end()};
}

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
    const Vec3 way = (curves.position.row(q) - curves.position.row(point)).transpose();
    flat.emplace_back(way.dot(first), way.dot(second));
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
  const auto way = [&](std::int32_t q) {
    return Vec3((curves.position.row(q) - curves.position.row(point)).transpose());
  };
  for (std::size_t a = 0; a < near.size(); ++a)
    for (std::size_t b = a + 1; b < near.size(); ++b) {
      const Vec3 from = way(near[a]), along = way(near[b]) - from;
      const double share =
          along.norm() > 0 ? std::clamp(-from.dot(along) / along.squaredNorm(), 0.0, 1.0) : 0;
      const double away = (from + share * along).norm();
      if (best && !(away < best->size)) continue;
      best = BlendPoints{{near[a], near[b], near[b]}, Vec3(1 - share, share, 0), away};
    }
  return best;
}

// Of a point left out, the normal curve that is true, that is predicted from the neighbours, what
// slopes add, what the trend predicts, what kriging does.
Controls normal_controls(const FittedCurves& curves, const LeftOutPoint& row,
                         const Controls& slopes, const ShapeCovariates& shape,
                         const ShapeRegression& trend, const Eigen::VectorXd& log_force,
                         const Eigen::VectorXd& kriged) {
  const Eigen::Index n = curves.curves.control[0].cols();
  const std::int32_t p = row.point;
  Controls control = Controls::Zero(5, n);
  control.row(0) = curves.curves.control[0].row(p);
  for (int k = 0; k < 3; ++k) {
    const std::int32_t l = row.corner[static_cast<std::size_t>(k)];
    const Eigen::RowVectorXd part = row.weight[k] * curves.curves.control[0].row(l);
    const Vec3 way = (curves.position.row(p) - curves.position.row(l)).transpose();
    control.row(1) += part;
    for (Eigen::Index j = 0; j < n && slopes.cols() > 0; ++j)
      control(2, j) += row.weight[k] * slopes.row(l).segment<3>(3 * j).dot(way.transpose());
    control.row(3) +=
        std::exp(trend.at(shape.at_point.row(p)) - trend.at(shape.at_point.row(l))) * part;
    if (kriged.size() > 0) control.row(4) += std::exp(kriged[p] - log_force[l]) * part;
  }
  return control;
}

// Mean relative errors of a point left out: with shares of slopes, and with the trend last.
std::array<double, kShares + 3> errors_of(const FittedCurves& curves, const Controls& control) {
  CurveSet rows(curves.curves.family);
  rows.basis = curves.curves.basis;
  rows.control[0] = control;
  const NodeForces forces(rows);
  const double range_m = curves.curves.basis[0].knots_m.back();
  std::array<double, kShares + 3> error{};
  for (int step = 1; step <= kDepths; ++step) {
    const double depth_m = range_m * step / kDepths, truth = forces.normal_N(0, depth_m);
    if (!(truth > 0)) continue;
    const double plain = forces.normal_N(1, depth_m), more = forces.normal_N(2, depth_m);
    for (int share = 0; share <= kShares; ++share)
      error[static_cast<std::size_t>(share)] +=
          std::abs(plain + 0.125 * share * more - truth) / truth / kDepths;
    for (const int more_row : {3, 4})
      error[static_cast<std::size_t>(kShares - 2 + more_row)] +=
          std::abs(forces.normal_N(more_row, depth_m) - truth) / truth / kDepths;
  }
  return error;
}

// Points, at most kMaxPoints, that neighbours surround; and those at the rim, if wanted.
std::vector<LeftOutPoint> left_out_points(const FittedCurves& curves, const Triangles& triangles,
                                          const std::vector<char>& is_used, bool with_rim) {
  std::vector<LeftOutPoint> out;
  const Neighbours neighbours(triangles, curves.curves.points());
  const auto points = static_cast<std::int32_t>(curves.curves.points());
  for (std::int32_t p = 0; p < points; p += 1 + points / kMaxPoints) {
    if (is_used[static_cast<std::size_t>(p)] == 0) continue;
    const auto near = points_around(curves, neighbours, is_used, p);
    auto around = without(curves, near, p);
    if (!around && with_rim) around = beside(curves, near, p);
    if (around) out.push_back({p, around->point, around->weight});
  }
  return out;
}

double angle(const Vec3& a, const Vec3& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

}  // namespace

Eigen::VectorXd log_forces(const FittedCurves& curves, std::vector<char>& is_usable) {
  const NodeForces forces(curves.curves);
  const double range_m = curves.curves.basis[0].knots_m.back();
  Eigen::VectorXd log_force = Eigen::VectorXd::Zero(curves.curves.points());
  for (Eigen::Index p = 0; p < log_force.size(); ++p)
    for (int step = 1; step <= kDepths && is_usable[static_cast<std::size_t>(p)] != 0; ++step) {
      const double force_N = forces.normal_N(p, range_m * step / kDepths);
      if (force_N > 0)
        log_force[p] += std::log(force_N) / kDepths;
      else
        is_usable[static_cast<std::size_t>(p)] = 0;
    }
  return log_force;
}

InterpolationChoice choose_interpolation(const FittedCurves& curves, const Triangles& triangles,
                                         const std::vector<char>& is_usable, const Controls& slopes,
                                         const ShapeCovariates& shape,
                                         const MeasuredPoints& measured) {
  InterpolationChoice out;
  std::vector<char> is_used = is_usable;
  const Eigen::VectorXd log_force = log_forces(curves, is_used);
  std::array<double, kShares + 3> error{};
  const std::vector<LeftOutPoint> rows =
      left_out_points(curves, triangles, is_used, measured.is_there());
  out.trend = regress_on_shape(shape, log_force, is_used, rows);
  for (Controls* kept :
       {&out.plain_normal, &out.slope_normal, &out.shape_normal, &out.kriged_normal})
    kept->resize(static_cast<Eigen::Index>(rows.size()), curves.curves.control[0].cols());
  for (const LeftOutPoint& row : rows) {
    const ShapeRegression trend = regress_on_shape(shape, log_force, is_used, rows, row.point);
    const Controls control =
        normal_controls(curves, row, slopes, shape, trend, log_force, measured.force);
    out.plain_normal.row(out.points) = control.row(1);
    out.slope_normal.row(out.points) = control.row(2);
    out.shape_normal.row(out.points) = control.row(3);
    out.kriged_normal.row(out.points) = control.row(4);
    if (measured.is_there()) {
      const Vec3 own = curves.normal.row(row.point);
      out.surface_normal_rad += angle(shape.at_point.row(row.point).tail<3>(), own);
      out.kriged_normal_rad += angle(measured.normal.row(row.point), own);
    }
    out.left_out.push_back(row.point);
    ++out.points;
    const auto at_point = errors_of(curves, control);
    for (std::size_t k = 0; k < error.size(); ++k) error[k] += at_point[k];
  }
  if (out.points == 0) return out;
  for (double& e : error) e /= out.points;
  out.surface_normal_rad /= out.points;
  out.kriged_normal_rad /= out.points;
  out.kriges_normals =
      out.points >= kMinShapePoints && out.kriged_normal_rad < out.surface_normal_rad;
  const auto best = std::min_element(error.begin(), error.begin() + kShares + 1);
  out.error = out.plain_error = error[0];
  out.slope_error = *best;
  out.shape_error = error[kShares + 1];
  if (measured.is_there()) out.kriged_error = error[kShares + 2];
  if (out.points >= kMinPoints && out.slope_error < kSlopesPay * out.plain_error) {
    out.slope_share = 0.125 * static_cast<double>(best - error.begin());
    out.error = out.slope_error;
  }
  if (out.points >= kMinShapePoints && out.shape_error < kShapePays * out.error) {
    out.follows_shape = true;
    out.error = out.shape_error;
  }
  if (measured.is_there() && out.points >= kMinShapePoints &&
      out.kriged_error < kKrigingPays * out.error) {
    out.is_kriged = true;
    out.follows_shape = false;
    out.slope_share = 0;
    out.error = out.kriged_error;
  }
  return out;
}

}  // namespace palpate
