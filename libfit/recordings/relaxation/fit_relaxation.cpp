#include "libfit/recordings/relaxation/fit_relaxation.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "libfit/core/statistics.hpp"

namespace palpate::recordings {
namespace {

constexpr int kHeldOutIterations = 3;  // from the solution with all rows
constexpr double k95 = 1.96;

double mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.) /
         static_cast<double>(std::max<std::size_t>(1, values.size()));
}

// True if held-out errors fall by more than one standard error of their differences.
bool is_gain(const std::vector<double>& before, const std::vector<double>& after) {
  const auto n = static_cast<double>(before.size());
  double sum = 0, squares = 0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    const double less = before[i] - after[i];
    sum += less, squares += less * less;
  }
  const double variance = std::max(0., squares - sum * sum / n) / std::max(1., n - 1);
  return sum / n > std::sqrt(variance / n);
}

// True if rows show every branch: its share, and that its time is above their shortest.
bool is_told(const RelaxationFit& fit) {
  for (Eigen::Index k = 0; k < fit.relaxation.branches(); ++k)
    if (fit.is_faster[k] || !(fit.covariance(k, k) < 0.5 * 0.5)) return false;
  return true;
}

// Sorts branches by time.
SeriesValues sorted(const SeriesValues& values) {
  const std::size_t n = values.branch.size() / 2;
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, {}, [&](std::size_t k) { return values.branch[n + k]; });
  SeriesValues out = values;
  for (std::size_t k = 0; k < n; ++k)
    out.branch[k] = values.branch[order[k]], out.branch[n + k] = values.branch[n + order[k]];
  return out;
}

// Fills in how far the fitted forces are off.
void compare(const SeriesSearch& with, const std::vector<std::vector<TimedPress>>& points,
             const SeriesValues& values, RelaxationFit& fit) {
  double left_N = 0, readings = 0;
  for (std::size_t g = 0; g < points.size(); ++g) {
    const Eigen::VectorXd of_group_N = with.solution(g, values).fitted_N;
    for (std::size_t r = 0; r < points[g].size(); ++r) {
      const TimedPress& p = points[g][r];
      const Eigen::Index first = with.groups()[g].first_row(r);
      for (Eigen::Index i = 0; i < p.rows(); ++i) {
        if (!(p.readings[i] > 0) || !(p.depth_m[i] > 0)) continue;
        const double left = p.push_N[i] - of_group_N[first + i];
        left_N += left * left, readings += 1;
      }
    }
  }
  fit.rms_N = std::sqrt(left_N / std::max(1., readings));
}

// Covariance, intervals and pictures at the solution.
void describe(const SeriesSearch& with, const std::vector<std::vector<TimedPress>>& points,
              const SeriesValues& values, RelaxationFit& fit) {
  const Eigen::Index branches = values.branches();
  fit.relaxation = values.relaxation();
  compare(with, points, values, fit);
  if (branches == 0) return;
  fit.covariance = series_covariance(with, values).topLeftCorner(2 * branches, 2 * branches);
  const Eigen::VectorXd wide =
      (k95 * fit.covariance.diagonal().cwiseMax(0).cwiseSqrt()).array().exp();
  fit.share_low = fit.relaxation.share.cwiseQuotient(wide.head(branches));
  fit.share_high = fit.relaxation.share.cwiseProduct(wide.head(branches));
  fit.time_low_s = fit.relaxation.time_s.cwiseQuotient(wide.tail(branches));
  fit.time_high_s = fit.relaxation.time_s.cwiseProduct(wide.tail(branches));
  for (Eigen::Index k = 0; k < branches; ++k) {
    const double at = values.branch[branches + k];
    fit.is_slower.push_back(with.is_slowest(at));
    fit.is_faster.push_back(with.is_fastest(at));
    if (fit.is_slower.back()) fit.time_high_s[k] = kInfinity;
    if (fit.is_faster.back()) fit.time_low_s[k] = 0;
  }
}

// Between rows of a recording in contact: the lower quartile of their steps, which is short after a
// ramp and long where a stand ends.
double short_step(const TimedPress& press) {
  std::vector<double> steps;
  for (Eigen::Index i = 1; i < press.rows(); ++i)
    if (press.depth_m[i] > 0) steps.push_back(press.time_s[i] - press.time_s[i - 1]);
  return lower_quantile(std::move(steps), 0.25);
}

}  // namespace

RelaxationFit::Band RelaxationFit::band(const Eigen::VectorXd& time_s) const {
  Band out;
  out.middle = stiffening(relaxation, time_s);
  out.low = out.high = out.middle;
  const Eigen::Index branches = relaxation.branches();
  for (Eigen::Index i = 0; i < time_s.size(); ++i) {
    Eigen::VectorXd by(2 * branches);  // of psi, by the logarithms of shares and times
    for (Eigen::Index k = 0; k < branches; ++k) {
      const double ago = time_s[i] / relaxation.time_s[k];
      by[k] = relaxation.share[k] * std::exp(-ago);
      by[branches + k] = by[k] * ago;
    }
    const double deviation = branches > 0 ? std::sqrt(std::max(0., by.dot(covariance * by))) : 0;
    out.low[i] = std::max(1., out.middle[i] - k95 * deviation);
    out.high[i] = out.middle[i] + k95 * deviation;
  }
  return out;
}

RelaxationFit fit_relaxation(const std::vector<std::vector<TimedPress>>& points, int exactly) {
  RelaxationFit fit;
  std::vector<double> steps;
  for (const auto& presses : points)
    for (const TimedPress& one : presses) {
      double from_s = kInfinity, to_s = 0;
      for (Eigen::Index i = 1; i < one.rows(); ++i) {
        if (!(one.depth_m[i] > 0)) continue;
        from_s = std::min(from_s, one.time_s[i - 1]), to_s = one.time_s[i];
      }
      fit.longest_s = std::max(fit.longest_s, to_s - from_s);
      if (to_s > from_s) steps.push_back(short_step(one));
    }
  if (steps.empty() || !(fit.longest_s > 0)) return fit;
  fit.shortest_s =
      std::max(std::min(2 * median(steps), fit.longest_s / 4), runtime::kMinRelaxation_s);
  fit.longest_s = std::clamp(fit.longest_s, 4 * fit.shortest_s, runtime::kMaxRelaxation_s);

  const SeriesSearch powers(points, SlowCurve::powers, fit.shortest_s, fit.longest_s),
      free(points, SlowCurve::free, fit.shortest_s, fit.longest_s);
  const SeriesValues none = powers.refined(powers.start()), one = powers.with_another(none),
                     other = free.refined(one);
  const bool is_free =
      mean(free.held_out_squares(other, 0)) < mean(powers.held_out_squares(one, 0));
  const SeriesSearch& with = is_free ? free : powers;
  fit.curve = is_free ? SlowCurve::free : SlowCurve::powers;

  const auto described = [&](const SeriesValues& values) {
    RelaxationFit out = fit;
    describe(with, points, sorted(values), out);
    return out;
  };
  SeriesValues found = is_free ? free.refined(free.start()) : none;
  RelaxationFit best = described(found);
  std::vector<double> before = with.held_out_squares(found, kHeldOutIterations);
  std::vector<double> held_out{std::sqrt(mean(before))};
  for (int branches = 1; branches <= (exactly < 0 ? runtime::kMaxBranches : exactly); ++branches) {
    const SeriesValues next = branches > 1 ? with.with_another(found) : is_free ? other : one;
    RelaxationFit more = described(next);
    if (exactly < 0) {
      const std::vector<double> errors = with.held_out_squares(next, kHeldOutIterations);
      held_out.push_back(std::sqrt(mean(errors)));
      if (!is_gain(before, errors) || !is_told(more)) break;
      before = errors;
    }
    found = next, best = std::move(more);
  }
  best.held_out = held_out;
  return best;
}

}  // namespace palpate::recordings
