#include "libfit/recordings/contact_point/bias.hpp"

#include <algorithm>

#include "libfit/recordings/signal/scatter.hpp"

namespace palpate::recordings {
namespace {

constexpr Eigen::Index kMinFreeRows = 8;

}  // namespace

double take_off_bias(Signal& signal, const Approach& way, const ContactEstimate& contact,
                     const SignalSettings& settings, Conditioned& out) {
  const double margin_m =
      std::max(3 * contact.deviation_m, 0.01 * (way.travel.maxCoeff() - way.travel.minCoeff()));
  Eigen::Index free = 0;
  while (free < way.travel.size() && way.travel[free] < contact.travel_m - margin_m) ++free;
  if (free < kMinFreeRows) {  // less of a margin, before none is left
    for (free = 0; free < way.travel.size() && way.travel[free] < contact.travel_m; ++free) {
    }
  }
  if (free < kMinFreeRows || contact.begins_in_contact) {
    out.reasons.push_back(out.estimator == "given"
                              ? "the contact point is the file's own; no bias was taken off"
                              : "begins in contact: no free travel from which to take the bias");
    if (out.estimator != "given") out.grade = std::max(out.grade, Grade::fair);
    out.noise_N = way.noise_N;
    return 0;
  }
  const Eigen::VectorXd travel = way.travel.head(free);
  const Line line = fit_line(travel, way.push.head(free));
  out.noise_N = line.deviation;
  const double correlation = std::clamp(line.correlation, 0.0, 0.95);
  if (settings.drift == Drift::none) return correlation;
  const Eigen::VectorXd all = signal.travel_m();
  const auto take_off = [&](auto&& axis) {
    const Eigen::VectorXd before = axis.segment(way.range.begin, free);
    const Line drift = fit_line(travel, before);
    if (settings.drift == Drift::line)
      axis.array() -= drift.at_0 + drift.slope * all.array();
    else
      axis.array() -= before.mean();
  };
  for (int axis = 0; axis < 3; ++axis) {
    take_off(signal.force_N.col(axis));
    if (signal.torque_Nm.rows() > 0) take_off(signal.torque_Nm.col(axis));
  }
  return correlation;
}

}  // namespace palpate::recordings
