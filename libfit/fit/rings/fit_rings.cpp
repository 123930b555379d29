#include "libfit/fit/rings/fit_rings.hpp"

#include <ceres/ceres.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "libfit/fit/point/replay.hpp"
#include "libfit/fit/rings/ring_replay.hpp"
#include "libfit/fit/spline/monotone_least_squares.hpp"

namespace palpate::fit {
namespace {

constexpr int kNumbers = 7;  // lambda, mu_0, mu_1, g_2, g_3; increments of f^z after them
constexpr int kStride = 8;          // derivatives at a time
constexpr double kRowShare = 0.01;  // of the typical force: what the law leaves, at best
constexpr double kLeastLambda = 0.05, kMostLambda = 2, kLeastFriction = 0, kMostFriction = 3;

// lambda, mu_0, mu_1, g_2 and g_3 along the tangents -> numbers of a node.
template <class T>
RingPoint<T> ring_point(const PointData& point, const T* normal, const T* parameter) {
  RingPoint<T> out{normal, {}};
  for (std::size_t k = 0; k < 3; ++k) out.number[k] = parameter[k];
  const auto tangents = tangents_of(point.inward);
  for (int power = 0; power < 2; ++power)
    for (int k = 0; k < 3; ++k)
      out.number[static_cast<std::size_t>(runtime::kSide + 3 * power + k)] =
          parameter[3 + 2 * power] * tangents[0][k] + parameter[4 + 2 * power] * tangents[1][k];
  constexpr int kAt[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}};
  for (std::size_t k = 0; k < 6; ++k)
    out.number[runtime::kCurvature + k] = T(-point.normal_gradient(kAt[k][0], kAt[k][1]));
  return out;
}

struct RingResidual {
  const PointData* point;
  const runtime::RingTable<runtime::kRings>* table;
  const runtime::CurveViews* views;
  const Experiment* experiment;
  FitLoss loss;
  double scale;

  template <class T>
  bool operator()(const T* const* parameters, T* residual) const {
    std::vector<T> normal(1, T(0));
    for (int j = 1; j < views->view[runtime::kNormal].size(); ++j)
      normal.push_back(normal.back() + parameters[0][kNumbers + j - 1]);
    const RingPoint<T> numbers = ring_point<T>(*point, normal.data(), parameters[0]);
    std::vector<runtime::Vec3<T>> force(experiment->row.size());
    replay_rings<T>(*table, *views, numbers, quadric_of(point->inward, point->normal_gradient),
                    experiment->deflection.front().data(), static_cast<int>(force.size()),
                    force.data());
    for (std::size_t i = 0; i < force.size(); ++i) {
      // The law is no better than a share of the force, however well rows are known.
      const double w = 1 / std::hypot(1 / experiment->weight[i],
                                      kRowShare * std::max(experiment->force[i].norm(), 0.2));
      T* r = residual + 3 * i;
      r[0] = w * (force[i].x - experiment->force[i].x());
      r[1] = w * (force[i].y - experiment->force[i].y());
      r[2] = w * (force[i].z - experiment->force[i].z());
      if (loss == FitLoss::squared) continue;
      const T squared = r[0] * r[0] + r[1] * r[1] + r[2] * r[2];
      if (!(squared > 1e-12 * scale * scale)) continue;
      using std::sqrt;
      const T factor = loss_factor(loss, scale, T(sqrt(squared)));
      for (int k = 0; k < 3; ++k) r[k] = r[k] * factor;
    }
    return true;
  }
};

struct PriorResidual {
  RingPrior prior;
  const Faint* faint;
  template <class T>
  bool operator()(const T* const* parameters, T* residual) const {
    const T* p = parameters[0];
    residual[0] = (p[0] - prior.lambda) / prior.lambda_deviation;
    residual[1] = (p[1] - prior.friction) / prior.friction_deviation;
    residual[2] = (p[2] - prior.friction_slope) / prior.friction_slope_deviation;
    for (Eigen::Index i = 0; i < faint->matrix.rows(); ++i) {
      residual[3 + i] = T(-kFaint * faint->target[i]);
      for (Eigen::Index j = 0; j < faint->matrix.cols(); ++j)
        residual[3 + i] += kFaint * faint->matrix(i, j) * p[kNumbers + j];
    }
    return true;
  }
};

// g_2 and g_3 that give presses the lateral force they have.
Eigen::Vector4d start_side(const PointData& point) {
  const auto tangents = tangents_of(point.inward);
  Eigen::Matrix2d square = 1e-12 * Eigen::Matrix2d::Identity(), right = Eigen::Matrix2d::Zero();
  for (const Experiment& e : point.experiments) {
    if (e.is_replayed) continue;
    for (std::size_t i = 0; i < e.row.size(); ++i) {
      const double d = depth_of(point, e.deflection[i]);
      if (!(d > 0)) continue;
      const Eigen::Vector2d w(d * d, d * d * d);
      square += w * w.transpose();
      for (int k = 0; k < 2; ++k) right.col(k) += w * e.force[i].dot(tangents[k]);
    }
  }
  const Eigen::Matrix2d g = square.ldlt().solve(right);  // row: power
  return {g(0, 0), g(0, 1), g(1, 0), g(1, 1)};
}

}  // namespace

RingPrior ring_prior(double poisson, double probe_friction, double probe_radius_m,
                     double length_m) {
  RingPrior prior;
  prior.lambda = 2 * (1 - poisson) / (2 - poisson);
  prior.friction = 0.95 * probe_friction;
  prior.friction_slope = probe_radius_m > 0 ? prior.friction / (2 * probe_radius_m) * length_m : 0;
  prior.friction_slope_deviation = 5 * length_m;
  return prior;
}

std::array<double, runtime::kRingNumbers> ring_numbers(const PointData& point,
                                                       const RingNumbers& of) {
  const double packed[kNumbers] = {of.lambda,  of.friction, of.friction_slope, of.side[0],
                                   of.side[1], of.side[2],  of.side[3]};
  return ring_point<double>(point, nullptr, packed).number;
}

RingNumbers fit_rings(const PointData& point, const runtime::SplineView& basis, const Faint& faint,
                      const Eigen::VectorXd& increments, const RingPrior& prior, FitLoss loss) {
  const auto table = runtime::ring_table<runtime::kRings>(basis, basis.knots[basis.pieces]);
  runtime::CurveViews views;
  views.view[runtime::kNormal] = basis;
  Eigen::VectorXd p(kNumbers + increments.size());
  p << prior.lambda, prior.friction, prior.friction_slope, start_side(point), increments;
  const auto count = static_cast<int>(p.size());
  ceres::Problem problem;
  for (const Experiment& e : point.experiments) {
    auto* cost = new ceres::DynamicAutoDiffCostFunction<RingResidual, kStride>(
        new RingResidual{&point, &table, &views, &e, loss, 1.0});
    cost->AddParameterBlock(count);
    cost->SetNumResiduals(static_cast<int>(3 * e.row.size()));
    problem.AddResidualBlock(cost, nullptr, p.data());
  }
  auto* known = new ceres::DynamicAutoDiffCostFunction<PriorResidual, kStride>(
      new PriorResidual{prior, &faint});
  known->AddParameterBlock(count);
  known->SetNumResiduals(3 + static_cast<int>(faint.matrix.rows()));
  problem.AddResidualBlock(known, nullptr, p.data());
  problem.SetParameterLowerBound(p.data(), 0, kLeastLambda);
  problem.SetParameterUpperBound(p.data(), 0, kMostLambda);
  problem.SetParameterLowerBound(p.data(), 1, kLeastFriction);
  problem.SetParameterUpperBound(p.data(), 1, kMostFriction);
  for (int j = kNumbers; j < count; ++j) problem.SetParameterLowerBound(p.data(), j, 0);
  ceres::Solver::Options options;
  options.num_threads = 1;
  options.linear_solver_type = ceres::DENSE_QR;
  options.dense_linear_algebra_library_type = ceres::EIGEN;
  options.logging_type = ceres::SILENT;
  options.max_num_iterations = 60;
  options.function_tolerance = 1e-10;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);

  RingNumbers out{p[0], p[1], p[2], p.segment<4>(3), p.tail(increments.size()), 0, 0};
  double square = 0, force_square = 0;
  const Eigen::VectorXd normal = controls_of(out.increments);
  const RingPoint<double> numbers = ring_point<double>(point, normal.data(), p.data());
  for (const Experiment& e : point.experiments) {
    std::vector<runtime::Vec3d> force(e.row.size());
    out.slid_rows += replay_rings<double>(
        table, views, numbers, quadric_of(point.inward, point.normal_gradient),
        e.deflection.front().data(), static_cast<int>(force.size()), force.data());
    for (std::size_t i = 0; i < force.size(); ++i) {
      square += (Vec3(force[i].x, force[i].y, force[i].z) - e.force[i]).squaredNorm();
      force_square += e.force[i].squaredNorm();
    }
  }
  out.relative_residual = std::sqrt(square / force_square);
  return out;
}

RingPrior ring_medians(const std::vector<RingNumbers>& points, const RingPrior& before) {
  std::vector<double> lambda, friction, slope;
  for (const RingNumbers& p : points) {
    lambda.push_back(p.lambda);
    friction.push_back(p.friction);
    slope.push_back(p.friction_slope);
  }
  RingPrior out = before;
  if (points.empty()) return out;
  out.lambda = median(lambda);
  out.friction = median(friction);
  out.friction_slope = median(slope);
  return out;
}

}  // namespace palpate::fit
