#include <algorithm>
#include <cmath>

#include "libfit/fit/point/point_problem.hpp"

namespace palpate::fit {
namespace {

constexpr double kExactRows = 1e-5;   // of the force: rows this close to a curve need no smoothing
constexpr double kClearNoise = 1e-3;  // of the force: what a dozen steps leave will not go away
// Iterations that tell noise from a curve not yet found; what a family has beside curves is found
// late, and gets all.
constexpr int kFirstLook = 12;

constexpr std::size_t kFewestRows = 20;
constexpr int kRounds = 8;
constexpr double kClip = 3;         // deviations
constexpr double kMinBase = 0.1;    // of the common deviation
constexpr double kSignificant = 3;  // errors of the estimate

// Standard deviation of a row's force as it grows with the force: sqrt(base^2 + (share f)^2), the
// usual law of a load cell and its amplifier.
struct NoiseModel {
  double base = 1, share = 0;

  double deviation(double force) const { return std::hypot(base, share * force); }
};

// The model nearest to residuals: sizes of weighted residuals over the forces predicted, by
// reweighted least squares on their squares, those beyond three deviations clipped. Both parts are
// zero or more; `base` is at least a tenth of the rows' common deviation, so that light touches
// cannot take the whole weight. Constant (share 0) where growing noise is not significant: its
// estimate must exceed three of its own errors. Fewer than 20 rows give a constant, too.
// Source: Carroll and Ruppert, Transformation and Weighting in Regression (1988), chapter 3.
NoiseModel estimate_noise(const std::vector<double>& force, const std::vector<double>& size) {
  const double common = robust_deviation(size);
  NoiseModel model{common, 0};
  if (size.size() < kFewestRows || !(common > 0)) return model;
  double error = 0;  // of share^2
  for (int round = 0; round < kRounds; ++round) {
    // Squares have a variance of about 2 sigma^4: weighted least squares of e^2 on 1 and f^2.
    double w00 = 0, w01 = 0, w11 = 0, r0 = 0, r1 = 0;
    for (std::size_t i = 0; i < size.size(); ++i) {
      const double sigma = model.deviation(force[i]), f2 = force[i] * force[i];
      const double e2 = std::pow(std::min(size[i], kClip * sigma), 2);
      const double w = 0.5 / std::pow(sigma, 4);
      w00 += w, w01 += w * f2, w11 += w * f2 * f2;
      r0 += w * e2, r1 += w * e2 * f2;
    }
    const double det = w00 * w11 - w01 * w01;
    if (!(det > 1e-12 * w00 * w11)) return {common, 0};
    double base2 = (w11 * r0 - w01 * r1) / det, share2 = (w00 * r1 - w01 * r0) / det;
    if (share2 < 0) share2 = 0, base2 = r0 / w00;
    const double least = std::pow(kMinBase * common, 2);
    if (base2 < least) base2 = least, share2 = std::max(0.0, (r1 - w01 * least) / w11);
    model = {std::sqrt(base2), std::sqrt(share2)};
    error = std::sqrt(w00 / det);
  }
  if (model.share * model.share < kSignificant * error) return {common, 0};
  return model;
}

// Below a thousandth of the weight floor residuals are rounding: no outlier is told from them.
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
  again.more_noise = noise;
  refine(point, bases, scale, again);
  again.scale = scale;
  again.noise = noise;
  return again;
}

// Whether the rows' weights were changed by what their residuals say of growing noise.
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

}  // namespace

void solve_point(const PointData& point, const Bases& bases, PointCurves& curves) {
  curves.weight.clear();
  for (const PointExperiment& e : point.experiments) curves.weight.push_back(e.weight);
  if (!has_unknowns(point, curves)) return;
  PointCurves start = curves;
  for (WeakPrior& weak_prior : curves.weak_prior) weak_prior.strength = kWeakPrior;
  const int first_look = curves.more.size() > 0 ? kMaxIterations : kFirstLook;
  refine(point, bases, scale_of(point, bases, curves), curves, first_look);

  // What the best curves leave unexplained is the rows' scatter, and weak priors weigh by it.
  const auto noise_of = [](const PointCurves& c, double scale) {
    return scale / std::sqrt(3.0) / root_mean_square_weight(c);
  };
  double scale = scale_of(point, bases, curves);
  double noise = noise_of(curves, scale);
  if (noise < kClearNoise && first_look < kMaxIterations) {
    refine(point, bases, scale, curves);
    scale = scale_of(point, bases, curves), noise = noise_of(curves, scale);
  }
  curves.scale = scale, curves.noise = noise;
  if (noise < kExactRows) return;
  start.nuisance = curves.nuisance;
  curves = refine_noisy(point, bases, start, scale, noise);
  if (point.has_errors || !reweight(point, bases, curves)) return;
  start.weight = curves.weight;
  scale = scale_of(point, bases, curves), noise = noise_of(curves, scale);
  curves = refine_noisy(point, bases, start, scale, noise);
}

}  // namespace palpate::fit
