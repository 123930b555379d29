#include "libfit/recordings/contact_point/contact_point.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace palpate::recordings {
namespace {

// Logarithm of the probability of a first slope, known to be normal: it is 0, or anything up to
// the steepest, 0.1 full forces per range, one as likely as the other.
double log_begins(double slope, double deviation) {
  const double x = slope / deviation, root_two_pi = 2.5066282746310002,
               flat = std::exp(-0.5 * x * x) / (root_two_pi * deviation),
               rising = 0.5 * std::erfc(-x * M_SQRT1_2) / 0.1;
  return flat + rising > 1e-300 ? std::log(flat + rising)
                                : -0.5 * x * x - std::log(root_two_pi * deviation);
}

// Means in units of their range and rise; `spread` is the variance of each over the common one.
struct Scaled {
  Eigen::VectorXd z, y, spread;
  double range_m = 1, min_variance = 0;
  double readings = 0;      // that say something of their own
  Eigen::Index silent = 0;  // first means that all repeat one value of a coarse sensor
};

Scaled scaled(const PressCurve& curve) {
  Scaled s;
  const Eigen::Index n = curve.travel_m.size();
  s.range_m = curve.travel_m[n - 1] - curve.travel_m[0];
  const double rise_N = curve.push_N.maxCoeff() - curve.push_N.minCoeff();
  s.z = (curve.travel_m.array() - curve.travel_m[0]) / s.range_m;
  s.y = (curve.push_N.array() - curve.push_N[0]) / rise_N;
  s.spread = curve.count.mean() / curve.count.array();
  // Readings that repeat a value say it once; those before the first other value may be free, or
  // in contact with less force than the sensor's step.
  const double quantum = curve.quantum_N / rise_N;
  for (Eigen::Index i = 0, last = 0; quantum > 0 && i < n; i = last) {
    for (last = i; last < n && std::abs(s.y[last] - s.y[i]) < 1e-9; ++last) {
    }
    s.spread.segment(i, last - i) *= static_cast<double>(last - i);
    if (i == 0 && last >= 8) s.silent = last;
  }
  s.readings = (curve.count.mean() / curve.count.array() / s.spread.array()).sum();
  s.min_variance = std::max(square(kDigits), square(quantum) / 12);
  return s;
}

// Force and slope at a travel, with their covariance in units of the noise's variance, given all
// deeper means; and what these cost.
struct State {
  double f = 0, g = 0, ff = 0, fg = 0, gg = 0;
  double log_determinant = 0, squares = 0;

  void go_back(double h, double intensity) {
    f -= h * g;
    ff += -2 * h * fg + h * h * gg + intensity * h * h * h / 3;
    fg += -h * gg - intensity * h * h / 2;
    gg += intensity * h;
  }
  void see(double y, double variance) {
    const double s = ff + variance, e = y - f, kf = ff / s, kg = fg / s;
    log_determinant += std::log(s);
    squares += e * e / s;
    f += kf * e;
    g += kg * e;
    gg -= kg * fg;
    fg -= kf * fg;
    ff -= kf * ff;
  }
};

// Moments of the first means, taken as free.
struct Free {
  double weight = 0, mean = 0, squares = 0, log_determinant = 0;
  void see(double y, double variance) {
    const double w = 1 / variance, e = y - mean;
    squares += e * e * w * weight / (weight + w);
    weight += w;
    mean += e * w / weight;
    log_determinant += std::log(variance);
  }
};

struct ContactPointTrial {
  double contact = 0, width = 0, log_weight = -kInfinity;
  Eigen::Index free = 0;
};

class Posterior {
 public:
  explicit Posterior(const Scaled& data) : data_(data) {
    Free free;
    if (data.silent > 0) free.see(data.y[0], 1);
    free_.push_back(free);
    for (Eigen::Index i = 0; i < data.y.size(); ++i) {
      if (i >= data.silent) free.see(data.y[i], data.spread[i]);
      free_.push_back(free);
    }
  }

  void add(double intensity, std::vector<ContactPointTrial>& trials) const {
    const Eigen::Index n = data_.y.size();
    State state;
    state.f = data_.y[n - 1];
    state.ff = 1e4 / data_.min_variance;  // any force and slope: full scales
    state.gg = 100 * state.ff;
    state.see(data_.y[n - 1], data_.spread[n - 1]);
    for (Eigen::Index i = n - 2; i >= 0; --i) {  // contact between means i and i + 1
      const double gap = data_.z[i + 1] - data_.z[i];
      if (n - 1 - i >= 3)
        for (int k = 0; k < kContactSteps; ++k) {
          State at = state;
          const double h = gap * (k + 0.5) / kContactSteps;
          at.go_back(h, intensity);
          trials.push_back({data_.z[i + 1] - h, gap / kContactSteps, cost_free(at, i + 1), i + 1});
        }
      state.go_back(gap, intensity);
      if (i >= data_.silent) state.see(data_.y[i], data_.spread[i]);
    }
    if (data_.silent > 0) state.see(data_.y[0], 1);
    trials.push_back(
        {data_.z[0], 1,
         log_likelihood(state.log_determinant, state.squares, state.g, std::sqrt(state.gg)) -
             kTouchCost,
         0});
  }

 private:
  double cost_free(const State& at, Eigen::Index free) const {
    const Free& before = free_[free];
    const double s = at.ff + 1 / before.weight, e = before.mean - at.f;
    return log_likelihood(
        at.log_determinant + before.log_determinant + std::log(before.weight) + std::log(s),
        at.squares + before.squares + e * e / s, at.g + at.fg / s * e,
        std::sqrt(std::max(1e-300, at.gg - at.fg * at.fg / s)));
  }
  double log_likelihood(double log_determinant, double squares, double slope,
                        double deviation) const {
    const double n = std::max(1.0, data_.readings - 2);
    const double variance = std::max(squares / n, data_.min_variance);
    return -0.5 * (log_determinant + n * std::log(variance) + squares / variance) +
           log_begins(slope, deviation * std::sqrt(variance));
  }

  const Scaled& data_;
  std::vector<Free> free_;
};

// (1 + r) / (1 - r) of the free means with correlation r between neighbours, which few do not show.
double correlation_time(const Scaled& data, Eigen::Index free) {
  if (free < 12 || data.silent > 0) return 1;  // repeats are counted already
  const double r = std::clamp(fit_line(data.z.head(free), data.y.head(free)).correlation, 0.0, 0.9);
  return (1 + r) / (1 - r);
}

}  // namespace

ContactEstimate contact_of_smooth_curve(const PressCurve& curve, const SignalSettings&) {
  const Scaled data = scaled(curve);
  const Posterior posterior(data);
  std::vector<ContactPointTrial> trials;
  for (int k = 0; k < 28; ++k)  // slope^2 over noise^2: 1 to 10^13.5
    posterior.add(std::pow(10, 13.5 * k / 27), trials);
  const auto best = std::ranges::max_element(trials, {}, &ContactPointTrial::log_weight);
  const double tau = correlation_time(data, best->free);
  double sum = 0, first = 0, second = 0, before = 0;
  for (const ContactPointTrial& trial : trials) {
    const double weight = trial.width * std::exp((trial.log_weight - best->log_weight) / tau);
    if (trial.free < 3)  // means: less is no free travel
      before += weight;
    else {
      sum += weight;
      first += weight * trial.contact;
      second += weight * square(trial.contact);
    }
  }
  ContactEstimate out;
  out.travel_m = curve.travel_m[0];
  out.deviation_m = data.range_m;
  out.begins_in_contact = !(sum > before);
  if (out.begins_in_contact) return out;
  const double mean = first / sum;
  out.travel_m += mean * data.range_m;
  const double step = 1 / static_cast<double>(data.z.size()) / kContactSteps;
  out.deviation_m =
      data.range_m * std::sqrt(std::max(second / sum - mean * mean, step * step / 12));
  return out;
}

}  // namespace palpate::recordings
