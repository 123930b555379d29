#include "libfit/fit/point/solve_point.hpp"

#include <algorithm>
#include <cmath>

#include "libfit/fit/point/point_problem.hpp"
#include "libfit/fit/rows/noise.hpp"

namespace palpate::fit {
namespace {

constexpr double kExactRows = 1e-5;   // of the force: rows this close to a curve need no smoothing
constexpr double kClearNoise = 1e-3;  // of the force: what a dozen steps leave will not go away
// Iterations that tell noise from a curve not yet found; what a family has beside curves is found
// late, and gets all.
constexpr int kFirstLook = 12;

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
  if (pack(curves, point).size() == 0) return;
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
