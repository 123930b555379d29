#include <algorithm>
#include <cmath>
#include <limits>

#include "libfit/recordings/batch/steps.hpp"
#include "libfit/recordings/contact_point/approach.hpp"

namespace palpate::recordings {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr Eigen::Index kMinFreeRows = 8;
constexpr double kWideShare = 0.5;  // of what a wider view would move the contact point

ContactEstimate contact_of(const Signal& signal, const Approach& approach,
                           const SignalSettings& settings, const importers::RawRecording& raw,
                           std::string& estimator) {
  if (!signal.is_axial && raw.contact_m) {
    estimator = "given";
    ContactEstimate known;
    known.travel_m = raw.contact_m->dot(signal.inward);
    return known;
  }
  if (settings.known_contact) {
    estimator = settings.known_contact->estimator;
    ContactEstimate known;
    known.travel_m = settings.known_contact->travel_m;
    known.deviation_m = settings.known_contact->deviation_m;
    return known;
  }
  estimator = settings.contact;
  ContactEstimate found =
      contact_estimator_named(settings.contact)->estimate(approach.curve, settings);
  if (!found.by.empty()) estimator += ": " + std::string(found.by);
  if (approach.wide_contact_m)
    found.deviation_m =
        std::hypot(found.deviation_m, kWideShare * (*approach.wide_contact_m - found.travel_m));
  return found;
}

// The tip at the contact travel, between two rows of the loading.
Vec3 contact_position(const Signal& signal, const Approach& approach, double travel_m) {
  Eigen::Index i = 0;
  while (i + 1 < approach.travel.size() && approach.travel[i] < travel_m) ++i;
  const Vec3 here = signal.position_m.row(approach.range.begin + i);
  return here + (travel_m - approach.travel[i]) * signal.inward;
}

double speed_of(const Signal& signal, const Approach& approach, double contact_m) {
  if (signal.time_s.empty()) return kNan;
  Eigen::Index first = 0;
  while (first + 2 < approach.travel.size() && approach.travel[first] < contact_m) ++first;
  const Eigen::Index last = approach.travel.size() - 1;
  const double dt =
      signal.time_s[approach.range.begin + last] - signal.time_s[approach.range.begin + first];
  return dt > 0 ? (approach.travel[last] - approach.travel[first]) / dt : kNan;
}

// Takes the free push (its mean, or its line over travel) off all rows and axes, and says in `out`
// how noisy it is. Returns the correlation of neighbours in that noise; 0 where nothing is free.
double take_off_bias(Signal& signal, const Approach& approach, const ContactEstimate& contact,
                     const SignalSettings& settings, Conditioned& out) {
  const double margin_m = std::max(
      3 * contact.deviation_m, 0.01 * (approach.travel.maxCoeff() - approach.travel.minCoeff()));
  Eigen::Index free = 0;
  while (free < approach.travel.size() && approach.travel[free] < contact.travel_m - margin_m)
    ++free;
  if (free < kMinFreeRows) {  // less of a margin, before none is left
    for (free = 0; free < approach.travel.size() && approach.travel[free] < contact.travel_m;
         ++free) {
    }
  }
  if (free < kMinFreeRows || contact.begins_in_contact) {
    out.reasons.emplace_back(
        out.contact.estimator == "given"
            ? "the contact point is given and nothing before it; no bias was taken off"
            : "begins in contact: no free travel from which to take the bias");
    if (out.contact.estimator != "given") out.grade = std::max(out.grade, Grade::fair);
    out.noise_N = approach.noise_N;
    return 0;
  }
  const Eigen::VectorXd travel = approach.travel.head(free);
  const Line line = fit_line(travel, approach.push.head(free));
  out.noise_N = line.deviation;
  const double correlation = std::clamp(line.correlation, 0.0, 0.95);
  if (settings.drift == Drift::none) return correlation;
  const Eigen::VectorXd all = signal.travel_m();
  const auto take_off = [&](auto&& axis) {
    const Eigen::VectorXd before = axis.segment(approach.range.begin, free);
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

}  // namespace

ContactEstimate find_contact(const importers::RawRecording& raw, const SignalSettings& settings,
                             const std::string& file, const std::vector<RowRange>& cycles,
                             Signal& signal, Conditioned& out) {
  Approach approach = approach_of(signal, signal.range.loading, cycles);
  check_contact(signal, approach, file);
  check_sign(signal, approach, file);
  focus_on_contact(signal, exponent_of(settings.tip), approach);
  const ContactEstimate contact =
      contact_of(signal, approach, settings, raw, out.contact.estimator);
  signal.contact_m = out.contact.travel_m = contact.travel_m;
  out.contact.deviation_m = contact.deviation_m;
  const Eigen::VectorXd before_N = signal.push_N();
  signal.correlation = take_off_bias(signal, approach, contact, settings, out);
  signal.bias_N = before_N - signal.push_N();
  out.contact_m = raw.contact_m;
  if (!signal.is_axial && !raw.contact_m)
    out.contact_m = contact_position(signal, approach, contact.travel_m);
  out.speed_m_s = speed_of(signal, approach, contact.travel_m);
  return contact;
}

}  // namespace palpate::recordings
