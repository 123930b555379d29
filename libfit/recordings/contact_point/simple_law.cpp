#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "libfit/recordings/contact_point/contact_point.hpp"

namespace palpate::recordings {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kShortest = 1. / 60, kLongest = 3;  // lengths of an exponential, over the travel
constexpr int kLengths = 24, kRefinements = 24;
constexpr int kSteps = 8;          // trial contact points between two means
constexpr double kWithin = 4;      // deviations of the length that are looked at
constexpr double kGoodFit = 1.5;   // residual over noise up to which a law holds
constexpr double kPromising = 30;  // likewise, of a scanned one
constexpr double kEvidence = 10;   // log likelihood that a law must gain on another
constexpr Eigen::Index kMinFree = 3, kMinRising = 4;
constexpr double kInChance = 2;  // deviations of a correlation of white noise

double square(double x) { return x * x; }

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
  ExponentialTrial best(double length_m, int steps = kSteps) const {
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
  const double step = std::log(kLongest / kShortest) / (kLengths - 1);
  double least = kInfinity, at = 0;
  for (int k = 0; k < kLengths; ++k) {
    const double log_length = std::log(kShortest * range_m) + step * k;
    const double squares = laws.best(std::exp(log_length), 1).squares;
    if (squares < least) least = squares, at = log_length;
  }
  if (!(least < square(kPromising) * noise_squares)) return 0;
  constexpr double kGolden = 0.6180339887498949;
  const auto squares_at = [&](double log_length) {
    return laws.best(std::exp(log_length)).squares;
  };
  double a = at - step, b = at + step, c = b - kGolden * (b - a), d = a + kGolden * (b - a);
  double at_c = squares_at(c), at_d = squares_at(d);
  for (int i = 0; i < kRefinements; ++i) {
    if (at_c < at_d) {
      b = d, d = c, at_d = at_c;
      at_c = squares_at(c = b - kGolden * (b - a));
    } else {
      a = c, c = d, at_c = at_d;
      at_d = squares_at(d = a + kGolden * (b - a));
    }
  }
  return std::exp((a + b) / 2);
}

// How far neighbours' misfits of a law go together: they do not where it holds.
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
  if (!(variance <= square(kGoodFit) * noise_variance)) return std::nullopt;
  if (correlation(curve, best, length_m) > kInChance / std::sqrt(n)) return std::nullopt;
  if (static_cast<double>(n) * std::log(squares_to_beat / best.squares) < 2 * kEvidence)
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
    const double length = length_m * std::exp(kWithin * step * k / half);
    if (length > kShortest * range_m && length < kLongest * range_m)
      laws.each_contact(length, kSteps, [&](const ExponentialTrial& trial) {
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
