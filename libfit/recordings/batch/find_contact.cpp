#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "libfit/core/text.hpp"
#include "libfit/recordings/batch/batch.hpp"

namespace palpate::recordings {
namespace {

constexpr Eigen::Index kMinRows = 8;
constexpr double kLeastExplained = 0.5;  // beside long free travel, whose waves look like a toe

// The approach as the estimators and the checks see it: W rows, and means of them and of others.
struct Approach {
  RowRange range;
  Eigen::VectorXd travel, push;    // W
  double noise_N = 0;              // of one reading, without contact
  std::vector<Eigen::Index> rows;  // of the signal, that the curve is the means of
  PressCurve curve;
  std::optional<double> wide_contact_m;  // of a curve with more free travel
};

// Push of the deepest part, a twentieth or a hundredth of the means, over that of the first part.
double rise_of(const PressCurve& curve) {
  const Eigen::Index n = curve.push_N.size();
  const Eigen::Index deep = std::max<Eigen::Index>(1, n / 20),
                     deepest = std::max<Eigen::Index>(1, n / 100),
                     free = std::max<Eigen::Index>(1, n / 10);
  return std::max(curve.push_N.tail(deep).mean(), curve.push_N.tail(deepest).mean()) -
         curve.push_N.head(free).mean();
}

// The means of the approach's rows.
void take_means(const Signal& signal, Approach& approach) {
  approach.curve =
      mean_curve(signal.travel_m()(approach.rows), signal.push_N()(approach.rows), 400);
  const double per_mean =
      static_cast<double>(approach.rows.size()) / static_cast<double>(approach.curve.push_N.size());
  approach.curve.noise_N = approach.noise_N / std::sqrt(per_mean);
}

// The rows of `range`, and in the means those of `more` too. Saturated rows are in no mean.
Approach approach_of(const Signal& signal, const RowRange& range,
                     const std::vector<RowRange>& more) {
  Approach approach;
  approach.range = range;
  approach.travel = signal.travel_m().segment(range.begin, range.rows());
  approach.push = signal.push_N().segment(range.begin, range.rows());
  const auto free = static_cast<Eigen::Index>(0.1 * static_cast<double>(range.rows()));
  approach.noise_N = free >= kMinRows
                         ? fit_line(approach.travel.head(free), approach.push.head(free)).deviation
                         : neighbour_scatter(approach.push);
  Eigen::Index believed = 0;  // a saturated force tells nothing about contact
  while (believed < range.rows() && !signal.is_saturated[range.begin + believed]) ++believed;
  if (believed < kMinRows) believed = range.rows();
  std::vector<Eigen::Index>& rows = approach.rows;
  for (Eigen::Index i = 0; i < believed; ++i) rows.push_back(range.begin + i);
  const double deepest_m = approach.travel.head(believed).maxCoeff();
  for (const RowRange& other : more)
    for (Eigen::Index i = other.begin; i < other.end; ++i)
      if (signal.position_m.row(i).dot(signal.inward) <= deepest_m) rows.push_back(i);
  take_means(signal, approach);
  return approach;
}

// Spends the means around the contact point where the press is a small part of the travel: leaves
// out what lies farther before it than forty, then twelve times the depth, as the power law of this
// exponent has it. `least_explained` rises where that is so, or the press is under a fifth of it.
void focus_on_contact(const Signal& signal, double exponent, Approach& approach) {
  std::optional<double> found_m;                      // on the curve as it is
  for (const double free_depths : {40., 40., 12.}) {  // that a pass keeps
    const Eigen::Index means = approach.curve.travel_m.size();
    const double first_m = approach.curve.travel_m[0], last_m = approach.curve.travel_m[means - 1];
    if (!found_m) found_m = contact_of_whole_curve_m(approach.curve, exponent);
    const double contact_m = *found_m;
    if (last_m - contact_m < 0.2 * (last_m - first_m))
      approach.curve.least_explained = kLeastExplained;
    const double least_m = 3 * (last_m - first_m) / static_cast<double>(means);
    const double from_m = last_m - (1 + free_depths) * std::max(last_m - contact_m, least_m);
    if (!(from_m > first_m + 0.2 * (last_m - first_m))) continue;  // too little to leave out
    const Eigen::VectorXd travel_m = signal.travel_m();
    std::vector<Eigen::Index> near;
    std::ranges::copy_if(approach.rows, std::back_inserter(near),
                         [&](Eigen::Index row) { return travel_m[row] >= from_m; });
    if (near.size() < 40) return;
    approach.wide_contact_m = std::exchange(found_m, std::nullopt);
    approach.rows = std::move(near);
    take_means(signal, approach);
    approach.curve.least_explained = kLeastExplained;
  }
}

// Refuses an approach that holds no contact: too few rows, a force that falls (its sign is
// reversed), saturates at once, or stays in the noise.
void check_contact(const Signal& signal, const Approach& approach, const std::string& file) {
  const bool is_short = approach.curve.push_N.size() < 5;
  const Eigen::VectorXd travel_m = signal.travel_m();
  const double range_m = travel_m.maxCoeff() - travel_m.minCoeff(),
               // With fewer rows a bend may be a turn.
      scatter_m = travel_m.size() < 40 ? 0 : neighbour_scatter(travel_m);
  const double in_m = travel_m[approach.range.end - 1] - travel_m[approach.range.begin];
  const bool is_part = is_short || in_m < 0.5 * range_m;
  if (is_part && scatter_m > 0.005 * range_m)
    throw Error(place(file, signal, approach.range.begin),
                "the position scatters by " + millimetres(scatter_m) +
                    " from one reading to the next: no way in is seen",
                "Say smooth = \"0.1 s\", or longer; or record a position with less noise.");
  if (is_short)
    throw Error(place(file, signal, approach.range.begin),
                fmt::format("the tip goes in over {} rows alone", approach.curve.push_N.size()),
                "Record at least 5 rows on the way in; is the depth's sign right?");
  const double rise_N = rise_of(approach.curve), seen_N = 5 * approach.noise_N;
  if (rise_N < -seen_N && rise_N < 0)
    throw Error(place(file, signal, approach.range.end - 1),
                "the force falls as the tip goes in, to " + number(rise_N) +
                    " N: the sign of force or depth is reversed",
                "Say force_on = \"tool\" or \"body\", whichever it is not yet, or turn the depth "
                "around: depth = \"-NAME\".");
  const auto first = signal.is_saturated.begin() + approach.range.begin,
             last = signal.is_saturated.begin() + approach.range.end;
  if (!(rise_N > seen_N) && std::find(first, last, 1) != last)
    throw Error(place(file, signal, std::find(first, last, 1) - signal.is_saturated.begin()),
                "the force is saturated before it rises out of its noise of " +
                    number(approach.noise_N) + " N",
                "Use a sensor with a larger range.");
  if (!(rise_N > seen_N) || !(rise_N > 0))
    throw Error(place(file, signal, approach.range.end - 1),
                "no contact: the force rises by " + number(rise_N) +
                    " N on the way in, its noise is " + number(approach.noise_N) + " N",
                signal.is_axial ? "Press deeper, or remove the recording."
                                : "Press deeper; or, where the tool slides, say kind = \"scan\".");
}

// Refuses depth and force that both have the other sign: the recording first goes out by as much as
// it comes in, its force falls below zero meanwhile, and the approach, which is the retract then,
// bends as no press does. A curve comes out of that, too, and a modulus two times too large.
void check_sign(const Signal& signal, const Approach& approach, const std::string& file) {
  const RowRange& in = approach.range;
  const Eigen::VectorXd before_m = signal.travel_m().head(in.begin + 1);
  const double low_m = approach.travel[0], gain_m = approach.travel.tail(1)[0] - low_m;
  if (before_m.maxCoeff() < low_m + gain_m / 2) return;
  const PressCurve& curve = approach.curve;
  const Eigen::Index n = curve.push_N.size(), few = std::max<Eigen::Index>(1, n / 50);
  const double low_N = curve.push_N.head(few).mean(), high_N = curve.push_N.tail(few).mean();
  if (!(low_N < 0 && -low_N > std::abs(high_N))) return;
  double work_J = 0;
  for (Eigen::Index i = 1; i < n; ++i)
    work_J += (curve.travel_m[i] - curve.travel_m[i - 1]) *
              ((curve.push_N[i] + curve.push_N[i - 1]) / 2 - low_N);
  // Mean push over largest: a press has 0.4 (ball) or less, a punch 0.5 at most; mirrored, they
  // have 0.6 and 0.5 or more.
  if (work_J < 0.45 * (curve.travel_m[n - 1] - curve.travel_m[0]) * (high_N - low_N)) return;
  throw Error(
      place(file, signal, in.begin),
      "the tip first goes out, and the force falls to " + number(low_N) +
          " N there: depth and force both have the reversed sign",
      "Turn both around: depth = \"-NAME\", and force = \"-NAME\" or the other force_on; of "
      "three axes the normal points out of the body: turn it.");
}

ContactEstimate contact_of(const Signal& signal, const Approach& approach,
                           const SignalSettings& settings, const importers::RawRecording& raw) {
  if (!signal.is_axial && raw.contact_m) return {{raw.contact_m->dot(signal.inward)}};
  if (settings.known_contact) return {*settings.known_contact};
  ContactEstimate found =
      contact_estimator_named(settings.contact)->estimate(approach.curve, settings);
  found.estimator = settings.contact + (found.by.empty() ? "" : ": ") + std::string(found.by);
  if (approach.wide_contact_m)
    found.deviation_m =
        std::hypot(found.deviation_m, 0.5 * (*approach.wide_contact_m - found.travel_m));
  return found;
}

// The first row of the loading at a travel or beyond; as many as there are where none is.
Eigen::Index first_row_at(const Approach& approach, double travel_m) {
  Eigen::Index i = 0;
  while (i < approach.travel.size() && approach.travel[i] < travel_m) ++i;
  return i;
}

// The tip at the contact travel, between two rows of the loading.
Vec3 contact_position(const Signal& signal, const Approach& approach, double travel_m) {
  const Eigen::Index i = std::min(first_row_at(approach, travel_m), approach.travel.size() - 1);
  const Vec3 here = signal.position_m.row(approach.range.begin + i);
  return here + (travel_m - approach.travel[i]) * signal.inward;
}

double speed_of(const Signal& signal, const Approach& approach, double contact_m) {
  if (signal.time_s.empty()) return kNan;
  const Eigen::Index last = approach.travel.size() - 1,
                     first = std::min(first_row_at(approach, contact_m), last - 1);
  const double dt =
      signal.time_s[approach.range.begin + last] - signal.time_s[approach.range.begin + first];
  return dt > 0 ? (approach.travel[last] - approach.travel[first]) / dt : kNan;
}

// Takes the free push (its mean, or its line over travel) off all rows and axes, and says in `out`
// how noisy it is. Without free rows, a pull at the contact is taken off the push: no tool can be
// pulled there, so that it is of the sensor. Returns the correlation of neighbours in that noise; 0
// where nothing is free.
double take_off_bias(Signal& signal, const Approach& approach, const ContactEstimate& contact,
                     const SignalSettings& settings, Conditioned& out) {
  const double margin_m = std::max(
      3 * contact.deviation_m, 0.01 * (approach.travel.maxCoeff() - approach.travel.minCoeff()));
  Eigen::Index free = first_row_at(approach, contact.travel_m - margin_m);
  constexpr Eigen::Index kMinFreeRows = 8;
  if (free < kMinFreeRows)  // less of a margin, before none is left
    free = first_row_at(approach, contact.travel_m);
  if (free < kMinFreeRows || contact.begins_in_contact) {
    const double pull_N = -approach.push[std::min(free, approach.push.size() - 1)];
    const bool is_bias = pull_N > 0 && settings.drift != Drift::none;
    if (is_bias) signal.force_N.rowwise() += pull_N * signal.inward.transpose();
    const std::string taken =
        is_bias ? fmt::format("a pull of {:.3g} N at the contact was taken off as bias", pull_N)
                : "no bias was taken off";
    out.reasons.push_back((out.contact.estimator == "given"
                               ? "the contact point is given and nothing before it; "
                               : "begins in contact, without free travel; ") +
                          taken);
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

std::string place(const std::string& file, const Signal& signal, Eigen::Index row) {
  return file_line(file, signal.line[std::clamp<Eigen::Index>(row, 0, signal.rows() - 1)]);
}

ContactEstimate find_contact(const importers::RawRecording& raw, const SignalSettings& settings,
                             const std::string& file, const std::vector<RowRange>& cycles,
                             Signal& signal, Conditioned& out) {
  Approach approach = approach_of(signal, signal.range.loading, cycles);
  check_contact(signal, approach, file);
  check_sign(signal, approach, file);
  focus_on_contact(signal, exponent_of(settings.tip), approach);
  const ContactEstimate contact = contact_of(signal, approach, settings, raw);
  out.contact = contact, signal.contact_m = contact.travel_m;
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
