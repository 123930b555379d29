#include "libfit/fit/rows/noise.hpp"

#include <algorithm>
#include <cmath>

#include "libfit/fit/spline/monotone_least_squares.hpp"

namespace palpate::fit {
namespace {

constexpr std::size_t kFewestRows = 20;
constexpr int kRounds = 8;
constexpr double kClip = 3;         // deviations
constexpr double kMinBase = 0.1;    // of the common deviation
constexpr double kSignificant = 3;  // errors of the estimate

}  // namespace

double NoiseModel::deviation(double force) const { return std::hypot(base, share * force); }

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

}  // namespace palpate::fit
