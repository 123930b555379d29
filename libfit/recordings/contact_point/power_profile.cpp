#include "libfit/recordings/contact_point/contact_point.hpp"

#include <algorithm>
#include <cmath>

namespace palpate::recordings {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kScan = 64;  // trial contact points before the minimum is refined
constexpr double kMaxCorrelation = 0.95;
constexpr int kRefinements = 26;  // golden sections: to 4e-6 of two trials

double square(double x) { return x * x; }

}  // namespace

PowerProfile::AmplitudeFit PowerProfile::at(double contact_m) const {
  double n = 0, g1 = 0, g2 = 0, f1 = 0, fg = 0;
  for (Eigen::Index i = 0; i < means_; ++i) {
    const double w = curve_.count[i], g = basis(i, contact_m), f = curve_.push_N[i];
    n += w;
    g1 += w * g;
    g2 += w * g * g;
    f1 += w * f;
    fg += w * f * g;
  }
  const double determinant = n * g2 - g1 * g1;
  if (!(determinant > 1e-12 * n * g2)) return {};
  AmplitudeFit fit;
  fit.amplitude = (n * fg - g1 * f1) / determinant;
  fit.bias_N = (f1 - fit.amplitude * g1) / n;
  if (!(fit.amplitude > 0)) return {};
  fit.squares = 0;
  for (Eigen::Index i = 0; i < means_; ++i)
    fit.squares += curve_.count[i] * square(residual(i, contact_m, fit));
  return fit;
}

double PowerProfile::residual(Eigen::Index i, double contact_m, const AmplitudeFit& fit) const {
  return curve_.push_N[i] - fit.bias_N - fit.amplitude * basis(i, contact_m);
}

double PowerProfile::best_contact_m() const {
  const double first = curve_.travel_m[0], last = curve_.travel_m[means_ - 1], range = last - first;
  const double low = first - range, step = (last - low) / kScan;
  int best = 0;
  double least = kInfinity;
  for (int k = 0; k < kScan; ++k)
    if (const double squares = at(low + step * k).squares; squares < least) {
      least = squares;
      best = k;
    }
  double a = low + step * (best - 1), b = low + step * (best + 1);
  constexpr double kGolden = 0.6180339887498949;
  double c = b - kGolden * (b - a), d = a + kGolden * (b - a), at_c = at(c).squares,
         at_d = at(d).squares;
  for (int i = 0; i < kRefinements; ++i) {
    if (at_c < at_d) {
      b = d;
      d = c;
      at_d = at_c;
      c = b - kGolden * (b - a);
      at_c = at(c).squares;
    } else {
      a = c;
      c = d;
      at_c = at_d;
      d = a + kGolden * (b - a);
      at_d = at(d).squares;
    }
  }
  return (a + b) / 2;
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
    if (lag == 1) geometric = (1 + r) / (1 - std::min(r, kMaxCorrelation));
    time += 2 * r;
  }
  return std::max(time, geometric);
}

}  // namespace palpate::recordings
