#include "libfit/recordings/contact_point/contact_point.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace palpate::recordings {
namespace {

// The minimum of a function that falls, then rises between a and b, by golden sections.
template <class Value>
double minimum_between(double a, double b, int sections, const Value& value) {
  constexpr double kGolden = 0.6180339887498949;
  double c = b - kGolden * (b - a), d = a + kGolden * (b - a), at_c = value(c), at_d = value(d);
  for (int i = 0; i < sections; ++i) {
    if (at_c < at_d) {
      b = d, d = c, at_d = at_c;
      at_c = value(c = b - kGolden * (b - a));
    } else {
      a = c, c = d, at_c = at_d;
      at_d = value(d = a + kGolden * (b - a));
    }
  }
  return (a + b) / 2;
}

}  // namespace

PowerProfile::AmplitudeFit PowerProfile::at(double contact_m) const {
  // Weighted moments of 1, the power and the travel, the last two in units of their largest.
  const double range = curve_.travel_m[means_ - 1] - curve_.travel_m[0];
  const double largest = basis(means_ - 1, contact_m);
  if (!(range > 0) || !(contact_m < curve_.travel_m[means_ - 2])) return {};
  const int unknowns = has_slope_ ? 3 : 2;
  Mat3 moments = Mat3::Identity();
  moments.topLeftCorner(unknowns, unknowns).setZero();
  Vec3 right = Vec3::Zero();
  for (Eigen::Index i = 0; i < means_; ++i) {
    const double w = curve_.count[i], g = basis(i, contact_m) / largest;
    const Vec3 x(1, g, (curve_.travel_m[i] - curve_.travel_m[0]) / range);
    moments.topLeftCorner(unknowns, unknowns) +=
        w * x.head(unknowns) * x.head(unknowns).transpose();
    right.head(unknowns) += w * curve_.push_N[i] * x.head(unknowns);
  }
  const Eigen::LDLT<Mat3> factor(moments);
  const auto pivots = factor.vectorD();
  if (!(pivots.minCoeff() > 1e-12 * pivots.maxCoeff())) return {};
  const Vec3 found = factor.solve(right);
  AmplitudeFit fit;
  fit.bias_N = found[0];
  fit.amplitude = found[1] / largest;
  fit.slope_N_m = has_slope_ ? found[2] / range : 0;
  if (!(fit.amplitude > 0)) return {};
  fit.squares = 0;
  for (Eigen::Index i = 0; i < means_; ++i)
    fit.squares += curve_.count[i] * square(residual(i, contact_m, fit));
  return fit;
}

double PowerProfile::residual(Eigen::Index i, double contact_m, const AmplitudeFit& fit) const {
  return curve_.push_N[i] - fit.bias_N - fit.amplitude * basis(i, contact_m) -
         fit.slope_N_m * (curve_.travel_m[i] - curve_.travel_m[0]);
}

double PowerProfile::best_contact_m() const {
  const double first = curve_.travel_m[0], last = curve_.travel_m[means_ - 1], range = last - first;
  const double step = 2 * range / 64, closer = std::numbers::sqrt2;
  std::vector<double> trial;
  for (int k = -1; k < 64; ++k) trial.push_back(first - range + step * k);
  for (double depth = step / closer; depth > range / static_cast<double>(means_); depth /= closer)
    trial.push_back(last - depth);
  trial.push_back(last);
  std::size_t best = 1;
  double least = kInfinity;
  for (std::size_t k = 1; k + 1 < trial.size(); ++k)
    if (const double squares = at(trial[k]).squares; squares < least) {
      least = squares;
      best = k;
    }
  // To 4e-6 of two trials.
  return minimum_between(trial[best - 1], trial[best + 1], 26,
                         [&](double contact_m) { return at(contact_m).squares; });
}

double PowerProfile::rms_N(double contact_m, const AmplitudeFit& fit) const {
  double sum = 0;
  for (Eigen::Index i = 0; i < means_; ++i) sum += square(residual(i, contact_m, fit));
  return std::sqrt(sum / static_cast<double>(means_));
}

double PowerProfile::deviation_m(double contact_m, const AmplitudeFit& fit) const {
  const double range = curve_.travel_m[means_ - 1] - curve_.travel_m[0];
  const double variance = fit.squares / static_cast<double>(std::max<Eigen::Index>(1, means_ - 3));
  double step = range / static_cast<double>(means_), rise = 0;
  for (int i = 0; i < 8; ++i, step *= 1.6) {  // a step that the profile feels
    rise = at(contact_m - step).squares + at(contact_m + step).squares - 2 * fit.squares;
    if (std::isfinite(rise) && rise > 2 * variance) break;
  }
  if (!(rise > 0) || !std::isfinite(rise)) return range;
  return std::min(range,
                  std::sqrt(2 * variance * step * step / rise * correlation_time(contact_m, fit)));
}

double PowerProfile::basis(Eigen::Index i, double contact_m) const {
  const double depth = curve_.travel_m[i] - contact_m;
  if (depth <= 0) return 0;
  return exponent_ == 1.5 ? depth * std::sqrt(depth)
         : exponent_ == 1 ? depth
                          : std::pow(depth, exponent_);
}

// Readings per independent one: 1 + 2 (r1 + r2 + ...), r the correlations of residuals until the
// first that is not positive, since drift has a long memory; or what r1 alone would make of it.
double PowerProfile::correlation_time(double contact_m, const AmplitudeFit& fit) const {
  Eigen::VectorXd left(means_);
  for (Eigen::Index i = 0; i < means_; ++i) left[i] = residual(i, contact_m, fit);
  const double alone = left.squaredNorm();
  double time = 1, geometric = 1;
  for (Eigen::Index lag = 1; alone > 0 && lag < means_ / 4; ++lag) {
    const double r = left.head(means_ - lag).dot(left.tail(means_ - lag)) / alone;
    if (r <= 0) break;
    if (lag == 1) geometric = (1 + r) / (1 - std::min(r, 0.95));
    time += 2 * r;
  }
  return std::max(time, geometric);
}

}  // namespace palpate::recordings
