#include <algorithm>
#include <cmath>
#include <random>

#include "libfit/core/linear_algebra.hpp"
#include "libfit/fit/point/point_problem.hpp"

namespace palpate::fit {
namespace {

constexpr int kDraws = 64;              // pairs of opposite sign: 6 % of a deviation
constexpr double kReach = 3;            // deviations within which a bound matters
constexpr double kMinDeviation = 1e-6;  // of a weighted residual: exact rows have no noise
constexpr double kMaxCorrelation = 0.95;

// Rows of one noise: forces along the normal, or across it. A rig with one axis has no noise
// across.
struct Groups {
  Eigen::VectorXd residual;  // rotated: per row normal, then two lateral
  Eigen::MatrixXd rows;
  std::vector<int> group;  // of each scalar row; -1 where it has no weight
};

Groups rotate(const PointData& point, const PointCurves& curves, const Linearised& linear) {
  const auto tangents = tangents_of(point.inward);
  Mat3 frame;
  frame << point.inward.transpose(), tangents[0].transpose(), tangents[1].transpose();
  Groups out{linear.residual, linear.rows, {}};
  Eigen::Index at = 0;
  for (std::size_t e = 0; e < point.experiments.size(); ++e)
    for (const double weight : curves.weight[e]) {
      out.residual.segment<3>(at) = frame * linear.residual.segment<3>(at);
      out.rows.middleRows<3>(at) = frame * linear.rows.middleRows<3>(at);
      for (const int group : {0, 1, 1}) out.group.push_back(weight > 0 ? group : -1);
      at += 3;
    }
  return out;
}

// psi and psi' of the loss at a standardised residual.
std::array<double, 2> influence(double z) {
  if (std::abs(z) > kHuberKnee) return {std::copysign(kHuberKnee, z), 0};
  return {z, 1};
}

// Correlation of neighbouring residuals along the experiments; 0 where it is not significant.
double correlation(const PointData& point, const Groups& g, const std::array<double, 2>& sigma,
                   double parameters) {
  double product = 0, square = 0, rows = 0;
  Eigen::Index at = 0;
  for (const PointExperiment& e : point.experiments) {
    for (std::size_t i = 0; i < e.row.size(); ++i, at += 3) {
      if (g.group[at] < 0) continue;
      const double z = std::clamp(g.residual[at] / sigma[0], -3.0, 3.0);
      square += z * z, ++rows;
      if (i == 0 || g.group[at - 3] < 0) continue;
      product += z * std::clamp(g.residual[at - 3] / sigma[0], -3.0, 3.0);
    }
  }
  if (!(square > 0)) return 0;
  const double r = product / square + parameters / rows;  // fitting takes that much out
  return r > 2 / std::sqrt(rows) ? std::min(r, kMaxCorrelation) : 0;
}

Eigen::MatrixXd solve(const PointData& point, const PointCurves& curves, const Linearised& linear) {
  const Groups g = rotate(point, curves, linear);
  // Priors were weighed against residuals of this deviation.
  const double prior_sigma =
      std::max(curves.noise * root_mean_square_weight(curves), kMinDeviation);
  const Eigen::MatrixXd prior =
      linear.prior.transpose() * linear.prior / (prior_sigma * prior_sigma);
  std::array<double, 2> sigma{prior_sigma, prior_sigma};
  Eigen::MatrixXd out;
  double used = 0;
  for (int round = 0; round < 4; ++round) {
    Eigen::MatrixXd information = prior;
    for (Eigen::Index i = 0; i < g.rows.rows(); ++i)
      if (const int k = g.group[i]; k >= 0)
        information += g.rows.row(i).transpose() * g.rows.row(i) / (sigma[k] * sigma[k]);
    out = cholesky_inverse(information).inverse;
    std::array<double, 2> square{}, slope{}, rows{}, leverage{};
    for (Eigen::Index i = 0; i < g.rows.rows(); ++i) {
      const int k = g.group[i];
      if (k < 0) continue;
      const auto psi = influence(g.residual[i] / sigma[k]);
      square[k] += std::pow(psi[0] * sigma[k], 2), slope[k] += psi[1], ++rows[k];
      leverage[k] += g.rows.row(i).dot(out * g.rows.row(i).transpose()) / (sigma[k] * sigma[k]);
    }
    used = leverage[0];
    for (int k = 0; k < 2; ++k) {
      const double free = std::max(rows[k] - leverage[k], 1.0);
      const double share = std::max(slope[k] / std::max(rows[k], 1.0), 0.1);
      sigma[k] = std::max(std::sqrt(square[k] / free) / share, kMinDeviation);
    }
  }
  const double r = correlation(point, g, sigma, used);
  return out * ((1 + r) / (1 - r));
}

// Mean of (P(x + e) - x)(P(x + e) - x)' over draws of e from N(0, covariance), P the nearest in
// the metric of the covariance's inverse that is at least `lower`. The covariance itself where no
// bound is within reach. x >= lower. Seeded: same input, same bits.
Eigen::MatrixXd bounded_moments(const Eigen::VectorXd& x, const Eigen::MatrixXd& covariance,
                                const Eigen::VectorXd& lower) {
  const Eigen::VectorXd deviation = covariance.diagonal().cwiseMax(0).cwiseSqrt();
  if ((x - lower - kReach * deviation).minCoeff() >= 0) return covariance;
  const Eigen::Index n = x.size();
  const double jitter = 1e-12 * covariance.diagonal().maxCoeff();
  const Eigen::MatrixXd whiten =
      inverse_cholesky_factor(covariance + jitter * Eigen::MatrixXd::Identity(n, n));
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  Eigen::MatrixXd moments = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd z(n);
  for (int draw = 0; draw < kDraws; ++draw) {
    for (double& v : z) v = normal(random);
    for (const double sign : {1.0, -1.0}) {
      const Eigen::VectorXd error = bounded_least_squares(whiten, whiten * x + sign * z, lower) - x;
      moments += error * error.transpose() / (2.0 * kDraws);
    }
  }
  return moments;
}

}  // namespace

PointCovariance covariance(const PointData& point, const Bases& bases, const PointCurves& curves) {
  PointCovariance out;
  out.nuisance.resize(point.experiments.size());
  if (!has_unknowns(point, curves)) return out;
  const Linearised linear = linearise(point, bases, curves);
  const Eigen::MatrixXd all = solve(point, curves, linear);
  if (!all.allFinite()) return out;
  Eigen::Index at = 0;
  for (std::size_t kind = 0; kind < kCurveKinds; ++kind) {
    if (!curves.is_identified[kind]) continue;
    const Eigen::Index n = curves.increments[kind].size();
    out.increments[kind] =
        bounded_moments(curves.increments[kind], all.block(at, at, n, n), curves.lower[kind]);
    at += n;
  }
  out.more = all.block(at, at, curves.more.size(), curves.more.size());
  at += curves.more.size();
  for (std::size_t e = 0; e < point.experiments.size(); ++e)
    for (int k = 0; k < kNuisances; ++k)
      if (point.experiments[e].unknown[k] > 0) out.nuisance[e][k] = std::sqrt(all(at, at)), ++at;
  return out;
}

}  // namespace palpate::fit
