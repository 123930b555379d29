#include <algorithm>
#include <cmath>
#include <vector>

#include "libfit/core/statistics.hpp"
#include "libfit/recordings/signal/signal.hpp"

// Single readings that stand out, and noise.

namespace palpate::recordings {
namespace {

constexpr Eigen::Index kReach = 3;  // rows on either side that a reading is compared with

double median_of(double a, double b, double c) {
  return std::max(std::min(a, b), std::min(std::max(a, b), c));
}

std::vector<double> second_differences(const Eigen::VectorXd& values) {
  std::vector<double> sizes;
  for (Eigen::Index i = 1; i + 1 < values.size(); ++i)
    sizes.push_back(std::abs(values[i - 1] - 2 * values[i] + values[i + 1]));
  return sizes;
}

// Least excess over its neighbours that makes a reading a spike, for a whole axis: 6 deviations of
// the noise, which are 5 of the difference (one in 2 million), and 2 % of the force's range without
// its ends.
double min_spike_N(const Eigen::VectorXd& force) {
  std::vector<double> sorted(force.begin(), force.end());
  std::sort(sorted.begin(), sorted.end());
  const auto tail = static_cast<std::size_t>(0.05 * static_cast<double>(sorted.size()));
  return std::max(6 * upper_median(second_differences(force)) / kMedianOfNormal / std::sqrt(6.0),
                  0.02 * (sorted[sorted.size() - 1 - tail] - sorted[tail]));
}

void find_spikes(const Eigen::VectorXd& force, std::vector<char>& is_spike) {
  const double min_N = min_spike_N(force);
  if (!(min_N > 0)) return;
  for (Eigen::Index i = kReach; i + kReach < force.size(); ++i) {
    const double before = median_of(force[i - 1], force[i - 2], force[i - 3]),
                 after = median_of(force[i + 1], force[i + 2], force[i + 3]);
    std::vector<double> steps{
        std::abs(force[i - 1] - force[i - 2]), std::abs(force[i - 2] - force[i - 3]),
        std::abs(force[i + 1] - force[i + 2]), std::abs(force[i + 2] - force[i + 3])};
    std::sort(steps.begin(), steps.end());  // one or two of them may touch another spike
    const double off_before = force[i] - before, off_after = force[i] - after;
    is_spike[i] |=
        off_before * off_after > 0 && std::min(std::abs(off_before), std::abs(off_after)) >
                                          std::max(min_N, 5 * steps[1]);  // else a peak
  }
}

// Value at t of the line fitted to rows [begin, end) with Gaussian weights about t.
Eigen::RowVector3d local_line(const std::vector<double>& time_s, const Points& values,
                              Eigen::Index begin, Eigen::Index end, double t, double sigma_s) {
  double w0 = 0, w1 = 0, w2 = 0;
  Eigen::RowVector3d v0 = Eigen::RowVector3d::Zero(), v1 = v0;
  for (Eigen::Index i = begin; i < end; ++i) {
    const double s = (time_s[i] - t) / sigma_s;
    const double w = std::exp(-0.5 * s * s);
    w0 += w;
    w1 += w * s;
    w2 += w * s * s;
    v0 += w * values.row(i);
    v1 += w * s * values.row(i);
  }
  const double determinant = w0 * w2 - w1 * w1;
  return determinant > 1e-9 * w0 * w0 ? Eigen::RowVector3d((w2 * v0 - w1 * v1) / determinant)
                                      : Eigen::RowVector3d(v0 / w0);
}

Line least_squares(const Eigen::VectorXd& x, const Eigen::VectorXd& y) {
  const double mx = x.mean(), my = y.mean();
  const Eigen::ArrayXd dx = x.array() - mx, dy = y.array() - my;
  Line line;
  const double xx = dx.square().sum();
  line.slope = xx > 0 ? (dx * dy).sum() / xx : 0;
  line.at_0 = my - line.slope * mx;
  const Eigen::ArrayXd left = dy - line.slope * dx;
  const double squares = left.square().sum();
  const auto n = static_cast<double>(x.size());
  line.deviation = n > 2 ? std::sqrt(squares / (n - 2)) : 0;
  if (squares > 0 && x.size() > 2)
    line.correlation = (left.head(x.size() - 1) * left.tail(x.size() - 1)).sum() / squares;
  return line;
}

}  // namespace

std::size_t replace_spikes(Signal& signal) {
  const Eigen::Index rows = signal.rows();
  signal.is_spike.assign(rows, 0);
  if (rows < 4 * kReach) return 0;
  for (int axis = 0; axis < 3; ++axis) find_spikes(signal.force_N.col(axis), signal.is_spike);
  for (std::size_t i = 0; i < signal.is_spike.size(); ++i)
    if (signal.is_saturated[i]) signal.is_spike[i] = 0;
  const std::size_t spikes = std::ranges::count(signal.is_spike, 1);
  if (static_cast<double>(spikes) > 0.1 * static_cast<double>(rows)) {  // that is the signal
    signal.is_spike.assign(signal.is_spike.size(), 0);
    return 0;
  }
  for (Eigen::Index first = 0; first < rows; ++first) {
    if (!signal.is_spike[first]) continue;
    Eigen::Index last = first;  // neither end of a signal can be a spike
    while (signal.is_spike[last]) ++last;
    const Vec3 before = signal.force_N.row(first - 1), after = signal.force_N.row(last);
    for (Eigen::Index i = first; i < last; ++i) {
      const double share =
          static_cast<double>(i - first + 1) / static_cast<double>(last - first + 1);
      signal.force_N.row(i) = (1 - share) * before + share * after;
    }
    first = last;
  }
  return spikes;
}

void smooth(Signal& signal, double sigma_s) {
  const Points force = signal.force_N, position = signal.position_m, torque = signal.torque_Nm;
  Eigen::Index begin = 0, end = 0;
  for (Eigen::Index i = 0; i < signal.rows(); ++i) {
    const double t = signal.time_s[i], reach_s = 4 * sigma_s;  // weights beyond are below 4e-4
    while (signal.time_s[begin] < t - reach_s) ++begin;
    while (end < signal.rows() && signal.time_s[end] <= t + reach_s) ++end;
    signal.force_N.row(i) = local_line(signal.time_s, force, begin, end, t, sigma_s);
    if (torque.rows() > 0)
      signal.torque_Nm.row(i) = local_line(signal.time_s, torque, begin, end, t, sigma_s);
    signal.position_m.row(i) = local_line(signal.time_s, position, begin, end, t, sigma_s);
  }
}

double neighbour_scatter(const Eigen::VectorXd& values) {
  return upper_median(second_differences(values)) / kMedianOfNormal / std::sqrt(6.0);
}

double quantum_of(const Eigen::VectorXd& values) {
  std::vector<double> sorted(values.begin(), values.end());
  std::sort(sorted.begin(), sorted.end());
  double least = kInfinity;
  for (std::size_t i = 1; i < sorted.size(); ++i)
    if (sorted[i] - sorted[i - 1] > 1e-9 * (sorted.back() - sorted.front()))
      least = std::min(least, sorted[i] - sorted[i - 1]);
  const Eigen::Index n = values.size();
  const auto repeats = (values.tail(n - 1).array() == values.head(n - 1).array()).count();
  // Noise of one step repeats 0.27 of the readings.
  return static_cast<double>(repeats) > 0.4 * static_cast<double>(n) && std::isfinite(least) ? least
                                                                                             : 0;
}

Line fit_line(const Eigen::VectorXd& x, const Eigen::VectorXd& y) {
  const Line line = least_squares(x, y);
  const Eigen::ArrayXd off = (y.array() - line.at_0 - line.slope * x.array()).abs();
  if (off.size() < 8) return line;
  const double most = 5 * upper_median({off.begin(), off.end()}) / kMedianOfNormal;
  std::vector<Eigen::Index> kept;
  for (Eigen::Index i = 0; i < off.size(); ++i)
    if (off[i] <= most) kept.push_back(i);
  return std::ssize(kept) < off.size() ? least_squares(x(kept), y(kept)) : line;
}

}  // namespace palpate::recordings
