#include <algorithm>
#include <cmath>
#include <random>

#include "libfit/core/linear_algebra.hpp"
#include "libfit/fit/point/point.hpp"

namespace palpate::fit {
namespace {

// Standard deviation of a row's force as it grows with the force: sqrt(base^2 + (share f)^2), the
// usual law of a load cell and its amplifier.
struct NoiseModel {
  double base = 1, share = 0;

  double deviation(double force) const { return std::hypot(base, share * force); }
};

// The model nearest to residuals: sizes of weighted residuals over the forces predicted, by
// reweighted least squares on their squares, those beyond three deviations clipped. Both parts are
// zero or more; `base` is at least a tenth of the rows' common deviation, so that light touches
// cannot take all of the weight. Constant (share 0) where growing noise is not significant: its
// estimate must exceed three of its own errors. Fewer than 20 rows yield a constant, too.
// Source: Carroll and Ruppert, Transformation and Weighting in Regression (1988), chapter 3.
NoiseModel estimate_noise(const std::vector<double>& force, const std::vector<double>& size) {
  const double common = robust_deviation(size);
  NoiseModel model{common, 0};
  if (size.size() < 20 || !(common > 0)) return model;
  double error = 0;  // of share^2
  for (int round = 0; round < 8; ++round) {
    // Squares have a variance of about 2 sigma^4: weighted least squares of e^2 on 1 and f^2.
    double w00 = 0, w01 = 0, w11 = 0, r0 = 0, r1 = 0;
    for (std::size_t i = 0; i < size.size(); ++i) {
      const double sigma = model.deviation(force[i]), f2 = force[i] * force[i];
      const double e2 = std::pow(std::min(size[i], 3 * sigma), 2);
      const double w = 0.5 / std::pow(sigma, 4);
      w00 += w, w01 += w * f2, w11 += w * f2 * f2;
      r0 += w * e2, r1 += w * e2 * f2;
    }
    const double det = w00 * w11 - w01 * w01;
    if (!(det > 1e-12 * w00 * w11)) return {common, 0};
    double base2 = (w11 * r0 - w01 * r1) / det, share2 = (w00 * r1 - w01 * r0) / det;
    if (share2 < 0) share2 = 0, base2 = r0 / w00;
    const double least = std::pow(0.1 * common, 2);
    if (base2 < least) base2 = least, share2 = std::max(0.0, (r1 - w01 * least) / w11);
    model = {std::sqrt(base2), std::sqrt(share2)};
    error = std::sqrt(w00 / det);
  }
  if (model.share * model.share < 3 * error) return {common, 0};
  return model;
}

// Below a thousandth of the weight floor residuals are rounding: no outlier differs from them.
double scale_of(const PointData& point, const Bases& bases, const PointCurves& curves) {
  return std::max(residual_scale(point, bases, curves), 1e-3);
}

// Curves from `start` with weak priors that weigh by the rows' noise.
PointCurves refine_noisy(const PointData& point, const Bases& bases, const PointCurves& start,
                         double scale, double noise) {
  PointCurves again = start;
  for (std::size_t kind = 0; kind < kCurveKinds; ++kind)
    if (again.is_identified[kind])
      again.weak_prior[kind].strength =
          again.weak_prior[kind].per_noise * noise / start.increments[kind].sum();
  again.constants_noise = noise;
  refine(point, bases, scale, again);
  again.scale = scale;
  again.noise = noise;
  return again;
}

// Changes the rows' weights where their residuals show growing noise, and returns whether.
bool reweight(const PointData& point, const Bases& bases, PointCurves& curves) {
  const Linearised linear = linearise(point, bases, curves);
  std::vector<double> force, size;
  Eigen::Index at = 0;
  for (std::size_t e = 0; e < point.experiments.size(); ++e)
    for (std::size_t i = 0; i < point.experiments[e].row.size(); ++i, at += 3) {
      const double weight = curves.weight[e][i];
      if (!(weight > 0)) continue;
      const Vec3 off = linear.residual.segment<3>(at);
      size.push_back(off.norm() / weight);
      force.push_back((point.experiments[e].force[i] + off / weight).norm());
    }
  const NoiseModel model = estimate_noise(force, size);
  if (!(model.share > 0)) return false;
  const double before = root_mean_square_weight(curves);
  std::size_t k = 0;
  for (auto& weights : curves.weight)
    for (double& w : weights)
      if (w > 0) w = 1 / model.deviation(force[k++]);
  const double factor = before / root_mean_square_weight(curves);
  for (auto& weights : curves.weight)
    for (double& w : weights) w *= factor;
  return true;
}

constexpr double kMinDeviation = 1e-6;  // of a weighted residual: exact rows have no noise

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
  return r > 2 / std::sqrt(rows) ? std::min(r, 0.95) : 0;
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
  if ((x - lower - 3 * deviation).minCoeff() >= 0) return covariance;
  const Eigen::Index n = x.size();
  const double jitter = 1e-12 * covariance.diagonal().maxCoeff();
  const Eigen::MatrixXd whiten =
      inverse_cholesky_factor(covariance + jitter * Eigen::MatrixXd::Identity(n, n));
  constexpr int kDraws = 64;  // pairs of opposite sign: 6 % of a deviation
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

void solve_point(const PointData& point, const Bases& bases, PointCurves& curves) {
  curves.weight.clear();
  for (const PointExperiment& e : point.experiments) curves.weight.push_back(e.weight);
  if (!has_unknowns(point, curves)) return;
  PointCurves start = curves;
  for (WeakPrior& weak_prior : curves.weak_prior) weak_prior.strength = kWeakPrior;
  // 12 iterations divide noise from a curve not yet found; the constants of a family converge late,
  // and get all.
  const int first_look = curves.constants.size() > 0 ? kMaxIterations : 12;
  refine(point, bases, scale_of(point, bases, curves), curves, first_look);

  // The residual of the best curves is the rows' scatter, and weak priors weigh by it.
  const auto noise_of = [](const PointCurves& c, double scale) {
    return scale / std::sqrt(3.0) / root_mean_square_weight(c);
  };
  double scale = scale_of(point, bases, curves);
  double noise = noise_of(curves, scale);
  if (noise < 1e-3 && first_look < kMaxIterations) {  // more will not go away
    refine(point, bases, scale, curves);
    scale = scale_of(point, bases, curves), noise = noise_of(curves, scale);
  }
  curves.scale = scale, curves.noise = noise;
  if (noise < 1e-5) return;  // rows this close to a curve need no smoothing
  start.nuisance = curves.nuisance;
  curves = refine_noisy(point, bases, start, scale, noise);
  if (point.has_errors || !reweight(point, bases, curves)) return;
  start.weight = curves.weight;
  scale = scale_of(point, bases, curves), noise = noise_of(curves, scale);
  curves = refine_noisy(point, bases, start, scale, noise);
}

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
  out.constants = all.block(at, at, curves.constants.size(), curves.constants.size());
  at += curves.constants.size();
  for (std::size_t e = 0; e < point.experiments.size(); ++e)
    for (int k = 0; k < kNuisances; ++k)
      if (point.experiments[e].unknown[k] > 0) out.nuisance[e][k] = std::sqrt(all(at, at)), ++at;
  return out;
}

}  // namespace palpate::fit
