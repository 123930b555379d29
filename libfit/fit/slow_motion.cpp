#include <algorithm>
#include <vector>

#include "libfit/fit/fit_steps.hpp"
#include "libfit/fit/point/local_curves.hpp"

namespace palpate::fit {
namespace {

// Below this share of an experiment's largest force a quotient is that of the next row above it.
constexpr double kLeastForce = 0.02;
// A tool with less than this share of its force in slow motion has left the body.
constexpr double kLeastQuotient = 0.1;
// A press unloads below this share of its deepest row so far: rings then release one by one, and a
// body does not.
constexpr double kUnloading = 0.98;

// Rows of each experiment, one after the other, up to the first that is not good.
std::vector<std::vector<Eigen::Index>> usable_experiments(const Samples& samples) {
  std::vector<std::vector<Eigen::Index>> out;
  bool is_good = true;
  for (std::size_t row = 0; row < samples.status.size(); ++row) {
    if (row == 0 || samples.experiment[row] != samples.experiment[row - 1]) {
      out.emplace_back();
      is_good = true;
    }
    is_good = is_good && samples.status[row] == RowStatus::good;
    if (is_good) out.back().push_back(row);
  }
  return out;
}

// Normal forces of an experiment, in the samples' time or in slow motion.
std::vector<double> normal_forces(const Samples& samples, const std::vector<Eigen::Index>& rows,
                                  const Bases& bases, const CurveSet& curves) {
  const Eigen::Index point = samples.point[rows.front()];
  const Vec3 inward = samples.point_normal.row(point);
  const Points force =
      local_answer(curves_at(bases, curves, point, samples, point), samples, rows).force;
  std::vector<double> out;
  for (Eigen::Index i = 0; i < force.rows(); ++i) out.push_back(inward.dot(Vec3(force.row(i))));
  return out;
}

}  // namespace

Samples in_slow_motion(const Samples& timed, const FittedCurves& curves) {
  Samples out = timed;
  out.time_s.resize(0);
  const Bases bases = bases_of(curves.curves);
  for (const std::vector<Eigen::Index>& rows : usable_experiments(timed)) {
    if (rows.empty()) continue;
    const std::int32_t point = timed.point[rows.front()];
    if (curves.status[point] == FitStatus::failed) continue;
    const auto fast = normal_forces(timed, rows, bases, curves.curves),
               slow = normal_forces(out, rows, bases, curves.curves);
    const double least = kLeastForce * *std::ranges::max_element(slow);
    std::vector<double> quotient;
    for (std::size_t i = 0; i < slow.size(); ++i)
      quotient.push_back(slow[i] > least && slow[i] > 0 ? fast[i] / slow[i] : 0);
    const auto first = std::ranges::find_if(quotient, [](double q) { return q > kLeastQuotient; });
    double before = first != quotient.end() ? *first : 1, deepest_m = 0;
    const bool is_press = timed.kind[rows.front()] == ExperimentKind::press;
    for (std::size_t i = 0; i < slow.size(); ++i) {
      const Eigen::Index row = rows[i];
      const bool is_significant = slow[i] > least && slow[i] > 0;
      const double depth_m = timed.deflection.row(row).dot(timed.point_normal.row(point));
      deepest_m = std::max(deepest_m, depth_m);
      const bool is_unloading = is_press && depth_m < kUnloading * deepest_m;
      if (is_unloading || (is_significant && quotient[i] < kLeastQuotient)) {
        out.status[row] = RowStatus::no_contact;
        continue;
      }
      if (is_significant) before = quotient[i];
      out.force.row(row) /= before;
      out.torque.row(row) /= before;
      out.force_error[row] /= before;
    }
  }
  return out;
}

}  // namespace palpate::fit
