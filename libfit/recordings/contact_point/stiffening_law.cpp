#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "libfit/recordings/contact_point/contact_point.hpp"

namespace palpate::recordings {
namespace {

// Deviations of s1 to s3 that are averaged over: of Hertz' half-space they are 0, and a layer twice
// as thick as the contact is wide doubles the force.
constexpr std::array kStiffening{0.0, 0.5, 2.0};
// Odds of the first beside each other one. With 1, weak stiffening is taken for none: of ten laws
// 92 of 100 contacts are within two deviations with 120 readings and 87 with a cone; with 0.1 it is
// 97 of both, and the contact of a Hertz body errs by 32 um instead of 26.
constexpr double kHertzOdds = 0.1;
// Of the largest push, what the tip's power law has at the least: a body that stiffens eightfold. A
// law without this share is a steep power of a contact point far before the true one. Twice as much
// would exclude bodies whose force grows by e^1.5 over the tip's law.
constexpr double kLeastShare = 0.125;
constexpr int kUnknowns = 5;  // bias, a, and a times s1 to s3
constexpr int kTrials = 80;   // contact points of a scan

using LawMoments = Eigen::Matrix<double, kUnknowns, kUnknowns>;
using LawUnknowns = Eigen::Matrix<double, kUnknowns, 1>;

struct StiffeningTrial {
  double at = 0, squares = kInfinity, log_weight = -kInfinity;
};

// Least squares of the law's linear unknowns (bias, a, a s1, a s2, a s3) at one contact point.
// Travel is in units of its range, push of its rise, and depth of the largest one.
class StiffeningLaw {
 public:
  StiffeningLaw(const PressCurve& curve, Eigen::Index means, double exponent, double slope_N_m)
      : exponent_(exponent), range_m_(curve.travel_m[means - 1] - curve.travel_m[0]) {
    rise_N_ = curve.push_N.head(means).maxCoeff() - curve.push_N[0];
    const Eigen::ArrayXd travel_m = curve.travel_m.head(means).array() - curve.travel_m[0];
    travel_ = travel_m / range_m_;
    push_ = (curve.push_N.head(means).array() - curve.push_N[0] - slope_N_m * travel_m) / rise_N_;
    weight_ = curve.count.head(means) / curve.count.mean();
    push_squares_ = weight_.dot(push_.cwiseAbs2());
    least_variance_ =
        square(std::max(kDigits, curve.noise_N / rise_N_)) + square(curve.quantum_N / rise_N_) / 12;
  }

  double range_m() const { return range_m_; }
  double rise_N() const { return rise_N_; }
  double least_variance() const { return least_variance_; }
  double last() const { return travel_[travel_.size() - 4]; }  // a few means are in contact

  // The logarithm of the contact point's likelihood, averaged over kStiffening, where one mean has
  // this variance. left: filled with the residuals of the widest prior where wanted.
  StiffeningTrial at(double contact, double variance, Eigen::VectorXd* left = nullptr) const {
    LawMoments moments = LawMoments::Zero();
    LawUnknowns right = LawUnknowns::Zero();
    for (Eigen::Index i = 0; i < travel_.size(); ++i) {
      const LawUnknowns x = basis(i, contact);
      moments.selfadjointView<Eigen::Lower>().rankUpdate(x, weight_[i]);
      right += weight_[i] * push_[i] * x;
    }
    moments.triangularView<Eigen::StrictlyUpper>() = moments.transpose();
    StiffeningTrial trial{contact};
    std::array<double, kStiffening.size()> log_evidence{};
    LawUnknowns found;
    for (std::size_t k = 0; k < kStiffening.size(); ++k) {
      double squares = 0;
      log_evidence[k] = evidence(moments, right, kStiffening[k], variance, found, squares);
      trial.squares = std::min(trial.squares, squares);
    }
    log_evidence[0] += std::log(kHertzOdds);
    const double best = *std::ranges::max_element(log_evidence);
    double sum = 0;
    for (const double each : log_evidence) sum += std::exp(each - best);
    trial.log_weight = best + std::log(sum) - (contact < 0 ? kTouchCost : 0);
    if (left != nullptr) {
      left->resize(travel_.size());
      for (Eigen::Index i = 0; i < travel_.size(); ++i)
        (*left)[i] = push_[i] - basis(i, contact).dot(found);
    }
    return trial;
  }

 private:
  LawUnknowns basis(Eigen::Index i, double contact) const {
    const double depth = std::max(0.0, (travel_[i] - contact) / (1 - contact));
    LawUnknowns x;
    x[0] = 1;
    double power = exponent_ == 1.5 ? depth * std::sqrt(depth) : std::pow(depth, exponent_);
    for (int k = 1; k < kUnknowns; ++k, power *= depth) x[k] = power;
    return x;
  }

  // Log evidence for one deviation: normal priors of s1 to s3, flat ones of the bias and of
  // a, which is not less than its share.
  double evidence(const LawMoments& moments, const LawUnknowns& right, double deviation,
                  double variance, LawUnknowns& found, double& squares) const {
    LawMoments precision = moments;
    LawUnknowns towards = right;
    double log_prior = 0;
    for (int k = 2; k < kUnknowns; ++k) {
      if (deviation > 0) {
        precision(k, k) += variance / square(deviation);
        log_prior += std::log(variance / square(deviation));
      } else {
        precision.row(k).setZero(), precision.col(k).setZero();
        precision(k, k) = 1, towards[k] = 0;
      }
    }
    const Eigen::LLT<LawMoments> factor(precision);
    found = factor.solve(towards);
    squares = std::max(0.0, push_squares_ - found.dot(towards));
    const double amplitude_variance = variance * factor.solve(LawUnknowns::Unit(1))[1];
    const double positive =
        std::erfc((kLeastShare - found[1]) / std::sqrt(2 * amplitude_variance)) / 2;
    const double log_determinant = 2 * factor.matrixLLT().diagonal().array().log().sum();
    return (log_prior - log_determinant - squares / variance) / 2 +
           std::log(std::max(positive, 1e-300));
  }

  double exponent_, range_m_, rise_N_ = 0, push_squares_ = 0, least_variance_ = 0;
  Eigen::VectorXd travel_, push_, weight_;
};

// Variance of one mean as the best trial leaves it, more where neighbours' residuals go together.
double variance_left(const StiffeningLaw& law, const StiffeningTrial& best, double guess,
                     double& misfit) {
  Eigen::VectorXd left;
  law.at(best.at, guess, &left);
  const auto n = static_cast<double>(left.size());
  misfit = std::sqrt(left.squaredNorm() / n);
  const double r =
      std::min(left.head(left.size() - 1).dot(left.tail(left.size() - 1)) / left.squaredNorm() +
                   kUnknowns / n,
               0.95);
  const double variance =
      std::max(law.least_variance(), best.squares / std::max(1.0, n - kUnknowns));
  return r > kCorrelationByChance / std::sqrt(n) ? variance * (1 + r) / (1 - r) : variance;
}

}  // namespace

LawFit contact_of_stiffening_law(const PressCurve& curve, Eigen::Index means, double exponent,
                                 double slope_N_m) {
  const StiffeningLaw law(curve, means, exponent, slope_N_m);
  double low = -0.5, high = law.last(), variance = law.least_variance(), misfit = 0;
  LawFit out;
  std::vector<StiffeningTrial> trials(kTrials);
  for (int round = 0; round < 4; ++round) {  // each finer than the last
    const double step = (high - low) / kTrials;
    const auto scan = [&] {
      for (int k = 0; k < kTrials; ++k) trials[k] = law.at(low + step * (k + 0.5), variance);
    };
    scan();
    StiffeningTrial best = *std::ranges::min_element(trials, {}, &StiffeningTrial::squares);
    double closer = step / 2;
    for (int k = 0; k < 4; ++k, closer /= 3)
      for (const double at : {best.at - closer, best.at + closer})
        if (const StiffeningTrial trial = law.at(std::min(at, law.last()), variance);
            trial.squares < best.squares)
          best = trial;
    variance = variance_left(law, best, variance, misfit);
    scan();
    const double top =
        std::ranges::max_element(trials, {}, &StiffeningTrial::log_weight)->log_weight;
    double sum = 0, first = 0, second = 0, from = high, to = low;
    for (const StiffeningTrial& trial : trials) {
      const double weight = std::exp(trial.log_weight - top);
      sum += weight, first += weight * trial.at, second += weight * square(trial.at);
      if (trial.log_weight < top - 14) continue;  // unlikely by 10^6
      from = std::min(from, trial.at - step), to = std::max(to, trial.at + step);
    }
    const double mean = first / sum;
    out.contact.travel_m = curve.travel_m[0] + mean * law.range_m();
    out.contact.deviation_m =
        law.range_m() * std::sqrt(std::max(second / sum - square(mean), square(step) / 12));
    out.squares = best.squares * square(law.rise_N()) * curve.count.mean();
    out.rms_N = misfit * law.rise_N();
    if (to - from > 20 * step) break;  // fine enough
    low = from, high = std::min(to, law.last());
  }
  return out;
}

}  // namespace palpate::recordings
