#include "libfit/refine/next_points.hpp"

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "libfit/core/curves.hpp"
#include "libfit/core/stated_error.hpp"

namespace palpate {
namespace {

constexpr int kFeatures = 2 * kComparedDepths;  // normal force, then limit force
using Features = Eigen::Matrix<double, 1, kFeatures>;
using Gradient = Eigen::Matrix<double, 3, kFeatures>;  // of each along the surface
using FeatureTable = Eigen::Matrix<double, Eigen::Dynamic, kFeatures, Eigen::RowMajor>;

/// Forces of the curves of each row at quarters of the depth range [N].
FeatureTable features_of(const CurveSet& curves) {
  FeatureTable table = FeatureTable::Zero(curves.points(), kFeatures);
  const double range_m = curves.basis[0].knots_m.back();
  int column = 0;
  const NodeForces forces(curves);
  for (const bool is_limit : {false, true})
    for (int step = 1; step <= kComparedDepths; ++step, ++column)
      for (Eigen::Index row = 0; row < table.rows(); ++row) {
        const double depth_m = range_m * step / kComparedDepths;
        table(row, column) =
            is_limit ? forces.limit_N(row, depth_m) : forces.normal_N(row, depth_m);
      }
  return table;
}

bool is_poor(const FittedCurves& curves, std::int32_t point) {
  return curves.status[point] == FitStatus::poor;
}

/// Least-squares gradient of each feature along the surface at every test point, from its
/// neighbours but poor ones: 3 x features per point. Nearer neighbours count more.
std::vector<Gradient> gradients_of(const FittedCurves& curves, const FeatureTable& features,
                                   const Triangles& triangles) {
  const Neighbours neighbours(triangles, curves.position.rows());
  std::vector<Gradient> gradients;
  for (Eigen::Index p = 0; p < curves.position.rows(); ++p) {
    const Vec3 first = Vec3(curves.normal.row(p)).unitOrthogonal();
    const Vec3 second = Vec3(curves.normal.row(p)).cross(first);
    Eigen::Matrix2d normal_matrix = Eigen::Matrix2d::Zero();
    Eigen::Matrix<double, 2, kFeatures> right = Eigen::Matrix<double, 2, kFeatures>::Zero();
    for (const std::int32_t q : neighbours.of(p)) {
      const Vec3 offset = (curves.position.row(q) - curves.position.row(p)).transpose();
      if (!(offset.squaredNorm() > 0) || is_poor(curves, q)) continue;
      const Eigen::Vector2d flat =
          Eigen::Vector2d(offset.dot(first), offset.dot(second)) / offset.norm();
      normal_matrix += flat * flat.transpose();
      right += flat * (features.row(q) - features.row(p)) / offset.norm();
    }
    // Minimum norm where all neighbours lie in one direction.
    const Eigen::Matrix<double, 2, kFeatures> flat =
        normal_matrix.completeOrthogonalDecomposition().solve(right);
    gradients.push_back(first * flat.row(0) + second * flat.row(1));
  }
  return gradients;
}

// The same gradients by side forces (B4a): those of the limit force as of the normal one.
std::vector<Gradient> side_gradients_of(const FittedCurves& curves, const FeatureTable& features) {
  const Controls slopes = slopes_of(curves);
  const Eigen::Index size = slopes.cols() / 3;
  const SplineTables t = tabulate(curves.curves.basis[0]);
  std::vector<Gradient> gradients;
  for (Eigen::Index p = 0; p < slopes.rows(); ++p) {
    Gradient gradient = Gradient::Zero();
    const Eigen::Matrix3Xd by_axis = slopes.row(p).reshaped(3, size);
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::VectorXd control = by_axis.row(axis);
      for (int step = 0; step < kComparedDepths; ++step)
        gradient(axis, step) = runtime::curve_value(view(t), control.data(),
                                                    t.knots.back() * (step + 1) / kComparedDepths);
    }
    for (int step = 0; step < kComparedDepths; ++step)
      if (features(p, step) > 0)
        gradient.col(kComparedDepths + step) =
            gradient.col(step) * (features(p, kComparedDepths + step) / features(p, step));
    gradients.push_back(gradient);
  }
  return gradients;
}

}  // namespace

std::vector<std::int32_t> next_points(const Surface& fine, const std::vector<char>& is_candidate,
                                      const std::vector<EdgePathSeeds>& points,
                                      std::vector<double> expected_error,
                                      const NextPointsOptions& options) {
  std::vector<double> distance_m = nearest_source(fine, points).distance_m;
  const auto is_free = [&](std::size_t v) {
    return is_candidate[v] && distance_m[v] > options.least_m && std::isfinite(distance_m[v]);
  };
  double largest_m = 0;
  for (std::size_t v = 0; v < distance_m.size(); ++v)
    if (is_free(v)) largest_m = std::max(largest_m, distance_m[v]);
  for (std::size_t v = 0; v < distance_m.size(); ++v)
    if (is_free(v)) {
      const double share = distance_m[v] / largest_m;
      expected_error[v] += options.gap_error * share * share;
    }

  const auto gaps = int(std::lround(options.gap_share * options.count));
  std::vector<std::int32_t> picked;
  while (std::ssize(picked) < options.count) {
    const bool fills_gap = std::ssize(picked) >= options.count - gaps;
    const std::vector<double>& score = fills_gap ? distance_m : expected_error;
    std::int32_t best = -1;
    for (std::size_t v = 0; v < score.size(); ++v)
      if (is_free(v) && (best < 0 || score[v] > score[best])) best = v;
    if (best < 0) break;
    picked.push_back(best);
    const auto from_pick = nearest_source(fine, {{{best, 0.0}}}).distance_m;
    for (std::size_t v = 0; v < distance_m.size(); ++v) {
      if (!(from_pick[v] < distance_m[v])) continue;
      const double share = from_pick[v] / distance_m[v];
      expected_error[v] *= share * share;
      distance_m[v] = from_pick[v];
    }
  }
  return picked;
}

std::vector<double> expected_errors(const FittedCurves& curves, const Model& model,
                                    const RefineReport& refined, double floor_N) {
  const double slope_share = refined.interpolation.slope_share;
  const Triangles& triangles = refined.triangles;
  FeatureTable at_points = features_of(curves.curves), at_vertices = features_of(model.curves);
  if (refined.trend.is_known()) {  // what is interpolated is the force over its trend
    for (int f = 0; f < kFeatures; ++f) {
      at_points.col(f).array() *= (-refined.trend.at_point.col(f % kComparedDepths)).array().exp();
      at_vertices.col(f).array() *=
          (-refined.trend.at_vertex.col(f % kComparedDepths)).array().exp();
    }
  }
  const auto gradients = gradients_of(curves, at_points, triangles);
  const auto slopes = slope_share > 0 ? side_gradients_of(curves, at_points) : gradients;
  // Twice what the tangent at one end gets wrong at the other: the second difference along the
  // edge, from either end; the larger one, because it is a feature that is being sought.
  const auto second_difference = [&](std::int32_t i, std::int32_t j) -> Features {
    const Vec3 offset = (curves.position.row(j) - curves.position.row(i)).transpose();
    const Features rise = at_points.row(j) - at_points.row(i);
    const Features from_i = offset.transpose() * gradients[i] - rise;
    const Features from_j = rise - offset.transpose() * gradients[j];
    return 2 * from_i.cwiseAbs().cwiseMax(from_j.cwiseAbs());
  };
  // The difference of the two where side forces determine the slopes, of which half remains.
  const auto third_difference = [&](std::int32_t i, std::int32_t j) -> Features {
    const Vec3 offset = (curves.position.row(j) - curves.position.row(i)).transpose();
    const Features both = offset.transpose() * (slopes[i] + slopes[j]);
    return 2 * (both - 2 * (at_points.row(j) - at_points.row(i))).cwiseAbs();
  };
  std::vector<double> errors(model.blend_weight.rows(), 0.0);
  for (Eigen::Index v = 0; v < model.blend_weight.rows(); ++v) {
    if (!model.is_covered[v]) continue;
    Features error = Features::Zero();
    for (int k = 0; k < 3; ++k) {
      const int l = (k + 1) % 3;
      const double both = model.blend_weight(v, k) * model.blend_weight(v, l);
      if (!(both > 0)) continue;
      const std::int32_t i = model.blend_point(v, k), j = model.blend_point(v, l);
      if (is_poor(curves, i) || is_poor(curves, j)) continue;
      // The rest of the second difference shows features that lie between test points, where
      // slopes agree by chance.
      error += 0.5 * (1 - 1.5 * slope_share) * both * second_difference(i, j);
      if (slope_share > 0) error += 0.5 * slope_share * both * third_difference(i, j);
    }
    for (int f = 0; f < kFeatures; ++f) {
      const double relative =
          relative_error(error[f], at_vertices(v, f % kComparedDepths), floor_N);
      errors[v] = std::max(errors[v], relative);
    }
  }
  return errors;
}

}  // namespace palpate
