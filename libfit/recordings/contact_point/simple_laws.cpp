#include "libfit/recordings/contact_point/contact_point.hpp"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace palpate::recordings {
namespace {

constexpr double kShortest = 1. / 60, kLongest = 3;  // lengths of an exponential, over the travel
constexpr Eigen::Index kMinFree = 3, kMinRising = 4;

struct ExponentialTrial {
  double contact_m = 0, width_m = 0, squares = kInfinity;
};

// push = bias + a (exp((travel - contact) / length) - 1) after the contact point, by least squares
// for one length and all contact points: sums over what is deeper serve them all.
class Exponentials {
 public:
  explicit Exponentials(const PressCurve& curve) : curve_(curve), push_(curve.push_N) {
    const double mean = push_.dot(curve.count) / curve.count.sum();
    push_.array() -= mean;
    all_[0] = curve.count.sum();
    all_[1] = push_.dot(curve.count);
    all_[2] = push_.cwiseAbs2().dot(curve.count);
  }

  // Calls take(ExponentialTrial) at `steps` contact points between each two means.
  template <class Take>
  void each_contact(double length_m, int steps, const Take& take) const {
    const Eigen::VectorXd& x = curve_.travel_m;
    const Eigen::Index n = x.size();
    double s0 = 0, s1 = 0, s2 = 0, y0 = 0, y1 = 0;  // of means deeper than the contact point
    for (Eigen::Index i = n - 1; i >= kMinFree; --i) {
      const double w = curve_.count[i], h = std::exp((x[i] - x[n - 1]) / length_m);
      s0 += w, s1 += w * h, s2 += w * h * h, y0 += w * push_[i], y1 += w * push_[i] * h;
      if (n - i < kMinRising) continue;
      const double gap = (x[i] - x[i - 1]) / steps;
      for (int k = 0; k < steps; ++k) {
        const double contact = x[i] - gap * (k + 0.5);
        const double u = std::exp((contact - x[n - 1]) / length_m);
        const double g1 = s1 - u * s0, g2 = s2 - 2 * u * s1 + u * u * s0, gy = y1 - u * y0;
        const double a = (all_[0] * gy - g1 * all_[1]) / (all_[0] * g2 - g1 * g1);
        const double bias = (all_[1] - a * g1) / all_[0];
        if (a > 0) take({contact, gap, all_[2] - bias * all_[1] - a * gy});
      }
    }
  }
  ExponentialTrial best(double length_m, int steps = kContactSteps) const {
    ExponentialTrial least;
    each_contact(length_m, steps, [&](const ExponentialTrial& trial) {
      if (trial.squares < least.squares) least = trial;
    });
    return least;
  }

 private:
  const PressCurve& curve_;
  Eigen::VectorXd push_;
  double all_[3] = {};
};

// Length of the best exponential: the best of a scan, then golden sections about it. 0 where the
// best of the scan is far from explaining the curve.
double best_length_m(const Exponentials& laws, double range_m, double noise_squares) {
  constexpr int kLengths = 24;
  const double step = std::log(kLongest / kShortest) / (kLengths - 1);
  double least = kInfinity, at = 0;
  for (int k = 0; k < kLengths; ++k) {
    const double log_length = std::log(kShortest * range_m) + step * k;
    const double squares = laws.best(std::exp(log_length), 1).squares;
    if (squares < least) least = squares, at = log_length;
  }
  if (!(least < square(30) * noise_squares)) return 0;
  return std::exp(minimum_between(at - step, at + step, 24, [&](double log_length) {
    return laws.best(std::exp(log_length)).squares;
  }));
}

// Correlation of neighbours' misfits of a law; there is none where it holds.
double correlation(const PressCurve& curve, const ExponentialTrial& best, double length_m) {
  const Eigen::Index n = curve.travel_m.size();
  const Eigen::VectorXd g = ((curve.travel_m.array() - best.contact_m) / length_m).max(0).exp();
  Eigen::MatrixX2d basis(n, 2);
  basis << Eigen::VectorXd::Ones(n), g / g[n - 1];
  const Eigen::VectorXd root = curve.count.cwiseSqrt();
  const Eigen::MatrixX2d weighted = root.asDiagonal() * basis;
  const Eigen::VectorXd left =
      curve.push_N - basis * weighted.householderQr().solve(root.cwiseProduct(curve.push_N));
  return left.head(n - 1).dot(left.tail(n - 1)) / left.squaredNorm();
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

std::optional<LawFit> contact_of_simple_law(const PressCurve& curve,
                                            std::span<const double> exponents,
                                            double squares_to_beat) {
  const Eigen::Index n = curve.travel_m.size();
  if (n < kMinFree + kMinRising + 4) return std::nullopt;
  const double range_m = curve.travel_m[n - 1] - curve.travel_m[0];
  const double readings = curve.count.sum() / static_cast<double>(n);
  const Exponentials laws(curve);
  const double noise_variance = square(curve.noise_N) * readings;  // of one reading
  const double length_m = best_length_m(laws, range_m, noise_variance * static_cast<double>(n - 4));
  if (length_m == 0) return std::nullopt;
  const ExponentialTrial best = laws.best(length_m);
  const double variance =
      std::max(best.squares / static_cast<double>(n - 4), square(1e-6 * curve.push_N.maxCoeff()));
  // The log likelihood of a law that is clearly better is 10 more.
  if (!(variance <= square(kHolds) * noise_variance) ||
      correlation(curve, best, length_m) > kCorrelationByChance / std::sqrt(n) ||
      static_cast<double>(n) * std::log(squares_to_beat / best.squares) < 20)
    return std::nullopt;

  double sum = 0, first = 0, second = 0;
  const auto add = [&](double weight, double contact_m, double deviation_m) {
    const double at = (contact_m - curve.travel_m[0]) / range_m;
    sum += weight, first += weight * at;
    second += weight * (at * at + square(deviation_m / range_m));
  };
  const auto likelihood = [&](double squares) {
    return std::exp(-(squares - best.squares) / (2 * variance));
  };
  // Lengths as far as they are likely: from the best outwards until they no longer are.
  double step = 1e-5;
  while (step < 0.5 && likelihood(laws.best(length_m * std::exp(step)).squares) > 0.6 &&
         likelihood(laws.best(length_m * std::exp(-step)).squares) > 0.6)
    step *= 1.5;
  const int half = 12;
  for (int k = -half; k <= half; ++k) {
    const double length = length_m * std::exp(4 * step * k / half);
    if (length > kShortest * range_m && length < kLongest * range_m)
      laws.each_contact(length, kContactSteps, [&](const ExponentialTrial& trial) {
        add(likelihood(trial.squares) * trial.width_m / range_m / (2 * half + 1), trial.contact_m,
            trial.width_m / std::sqrt(12.0));
      });
  }
  for (const double exponent : exponents) {
    const PowerProfile profile(curve, n, exponent);
    const double contact_m = profile.best_contact_m();
    const auto fit = profile.at(contact_m);
    if (!std::isfinite(fit.squares) || contact_m < curve.travel_m[kMinFree]) continue;
    const double deviation_m = profile.deviation_m(contact_m, fit);
    add(likelihood(fit.squares) * std::sqrt(2 * M_PI) * deviation_m / range_m /
            static_cast<double>(exponents.size()),
        contact_m, deviation_m);
  }
  LawFit out;
  const double mean = first / sum;
  out.contact.travel_m = curve.travel_m[0] + mean * range_m;
  out.contact.deviation_m = range_m * std::sqrt(std::max(0.0, second / sum - mean * mean));
  out.squares = best.squares;
  return out;
}

}  // namespace palpate::recordings
