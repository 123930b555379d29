#include <algorithm>
#include <cassert>
#include <cmath>

#include "libfit/recordings/signal/signal.hpp"

namespace palpate::recordings {
namespace {

constexpr double kReach = 4;  // standard deviations: weights beyond are below 4e-4

// Value at t of the line fitted to rows [begin, end) with Gaussian weights about t.
Eigen::RowVector3d local_line(const std::vector<double>& time_s, const Points& values,
                              Eigen::Index begin, Eigen::Index end, double t, double sigma_s) {
  double w0 = 0, w1 = 0, w2 = 0;
  Eigen::RowVector3d v0 = Eigen::RowVector3d::Zero(), v1 = v0;
  for (Eigen::Index i = begin; i < end; ++i) {
    const double s = (time_s[static_cast<std::size_t>(i)] - t) / sigma_s;
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

}  // namespace

void smooth(Signal& signal, double sigma_s) {
  assert(!signal.time_s.empty());
  if (!(sigma_s > 0)) return;
  const Points force = signal.force_N, position = signal.position_m, torque = signal.torque_Nm;
  Eigen::Index begin = 0, end = 0;
  for (Eigen::Index i = 0; i < signal.rows(); ++i) {
    const double t = signal.time_s[static_cast<std::size_t>(i)];
    while (signal.time_s[static_cast<std::size_t>(begin)] < t - kReach * sigma_s) ++begin;
    while (end < signal.rows() &&
           signal.time_s[static_cast<std::size_t>(end)] <= t + kReach * sigma_s)
      ++end;
    signal.force_N.row(i) = local_line(signal.time_s, force, begin, end, t, sigma_s);
    if (torque.rows() > 0)
      signal.torque_Nm.row(i) = local_line(signal.time_s, torque, begin, end, t, sigma_s);
    signal.position_m.row(i) = local_line(signal.time_s, position, begin, end, t, sigma_s);
  }
}

}  // namespace palpate::recordings
