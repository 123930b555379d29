#include "libfit/fit/slow_motion.hpp"

#include <algorithm>
#include <vector>

#include "libfit/fit/point/replay.hpp"

namespace palpate::fit {
namespace {

// Below this share of an experiment's largest force a quotient is that of the next row above it.
constexpr double kLeastForce = 0.02;
// A tool that bears less of what it would in slow motion has left the body behind.
constexpr double kLeastQuotient = 0.1;
// Of the deepest so far: a press that is shallower is on its way out, where rings let go one by one
// and a body does not.
constexpr double kWayOut = 0.98;

struct ReplayableRows {
  Eigen::Index first, count;
};

// Rows of each experiment, one after the other, up to the first that is not good.
std::vector<ReplayableRows> usable_experiments(const Samples& samples) {
  std::vector<ReplayableRows> out;
  for (Eigen::Index i = 0; i < samples.rows();) {
    ReplayableRows rows{i, 0};
    bool is_good = true;
    for (; i < samples.rows() && samples.experiment[static_cast<std::size_t>(i)] ==
                                     samples.experiment[static_cast<std::size_t>(rows.first)];
         ++i) {
      is_good = is_good && samples.status[static_cast<std::size_t>(i)] == RowStatus::good;
      rows.count += is_good;
    }
    out.push_back(rows);
  }
  return out;
}

// Normal forces of an experiment, with times or in slow motion.
std::vector<double> normal_forces(const Samples& samples, const ReplayableRows& rows,
                                  const Bases& bases, const CurveSet& curves, bool is_timed) {
  const auto point = static_cast<Eigen::Index>(samples.point[static_cast<std::size_t>(rows.first)]);
  const Vec3 inward = samples.point_normal.row(point);
  const runtime::Quadric quadric = quadric_of(inward, offset_gradient(samples, point));
  std::vector<double> way;
  for (Eigen::Index i = 0; i < rows.count; ++i)
    for (int k = 0; k < 3; ++k) way.push_back(samples.deflection(rows.first + i, k));
  std::vector<runtime::Vec3d> force(static_cast<std::size_t>(rows.count));
  runtime::replay_drag<double>(bases.views, controls_at(curves, point), quadric,
                               {way.data(), static_cast<int>(rows.count),
                                is_timed ? samples.time_s.data() + rows.first : nullptr},
                               nullptr, force.data());
  std::vector<double> out;
  for (const runtime::Vec3d& f : force) out.push_back(inward.dot(Vec3(f.x, f.y, f.z)));
  return out;
}

}  // namespace

Samples in_slow_motion(const Samples& timed, const FittedCurves& curves) {
  Samples out = timed;
  out.time_s.resize(0);
  const Bases bases = bases_of(curves.curves);
  for (const ReplayableRows& rows : usable_experiments(timed)) {
    if (rows.count == 0) continue;
    const auto point = static_cast<std::size_t>(timed.point[static_cast<std::size_t>(rows.first)]);
    if (curves.status[point] == FitStatus::failed) continue;
    const auto fast = normal_forces(timed, rows, bases, curves.curves, true),
               slow = normal_forces(timed, rows, bases, curves.curves, false);
    const double least = kLeastForce * *std::ranges::max_element(slow);
    std::vector<double> quotient;
    for (std::size_t i = 0; i < slow.size(); ++i)
      quotient.push_back(slow[i] > least && slow[i] > 0 ? fast[i] / slow[i] : 0);
    const auto told = std::ranges::find_if(quotient, [](double q) { return q > kLeastQuotient; });
    double before = told != quotient.end() ? *told : 1, deepest_m = 0;
    const bool is_press = timed.kind[static_cast<std::size_t>(rows.first)] == ExperimentKind::press;
    for (std::size_t i = 0; i < slow.size(); ++i) {
      const Eigen::Index row = rows.first + static_cast<Eigen::Index>(i);
      const bool is_told = slow[i] > least && slow[i] > 0;
      const double depth_m =
          timed.deflection.row(row).dot(timed.point_normal.row(static_cast<Eigen::Index>(point)));
      deepest_m = std::max(deepest_m, depth_m);
      const bool is_way_out = is_press && depth_m < kWayOut * deepest_m;
      if (is_way_out || (is_told && quotient[i] < kLeastQuotient)) {
        out.status[static_cast<std::size_t>(row)] = RowStatus::no_contact;
        continue;
      }
      if (is_told) before = quotient[i];
      out.force.row(row) /= before;
      out.torque.row(row) /= before;
      out.force_error[row] /= before;
    }
  }
  return out;
}

}  // namespace palpate::fit
