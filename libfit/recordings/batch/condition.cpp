#include "libfit/recordings/batch/condition.hpp"

#include <algorithm>
#include <cmath>

#include "libfit/core/text.hpp"
#include "libfit/recordings/batch/grade.hpp"
#include "libfit/recordings/batch/rows.hpp"
#include "libfit/recordings/contact_point/approach.hpp"
#include "libfit/recordings/contact_point/bias.hpp"
#include "libfit/recordings/contact_point/contact_point.hpp"
#include "libfit/recordings/signal/phases.hpp"
#include "libfit/recordings/signal/scatter.hpp"

namespace palpate::recordings {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kMaxSaturated = 0.7;  // share of the depth
constexpr double kManySpikes = 0.01;   // of the rows of a good recording

ContactEstimate contact_of(const Signal& signal, const Approach& way,
                           const SignalSettings& settings, const importers::RawRecording& raw,
                           std::string& estimator) {
  if (!signal.is_axial && raw.contact_m) {
    estimator = "given";
    ContactEstimate given;
    given.travel_m = raw.contact_m->dot(signal.inward);
    return given;
  }
  estimator = settings.contact;
  return contact_estimator_named(settings.contact)->estimate(way.curve, settings);
}

// Where the tip was at the contact travel, between two rows of the way in.
Vec3 contact_position(const Signal& signal, const Approach& way, double travel_m) {
  Eigen::Index i = 0;
  while (i + 1 < way.travel.size() && way.travel[i] < travel_m) ++i;
  const Vec3 here = signal.position_m.row(way.range.begin + i);
  return here + (travel_m - way.travel[i]) * signal.inward;
}

double hysteresis_of(const Signal& signal, const Approach& way, const RowRange& back,
                     double contact_m) {
  if (back.rows() < 5) return kNan;
  const auto work_J = [&](const RowRange& range) {
    const PressCurve curve = mean_curve(signal.travel_m().segment(range.begin, range.rows()),
                                        signal.push_N().segment(range.begin, range.rows()), 200);
    double sum = 0;
    for (Eigen::Index i = 1; i < curve.travel_m.size(); ++i)
      if (curve.travel_m[i - 1] >= contact_m)
        sum += (curve.travel_m[i] - curve.travel_m[i - 1]) *
               (curve.push_N[i] + curve.push_N[i - 1]) / 2;
    return sum;
  };
  const double in_J = work_J(way.range);
  return in_J > 0 ? 1 - work_J(back) / in_J : kNan;
}

double speed_of(const Signal& signal, const Approach& way, double contact_m) {
  if (signal.time_s.empty()) return kNan;
  Eigen::Index first = 0;
  while (first + 2 < way.travel.size() && way.travel[first] < contact_m) ++first;
  const Eigen::Index last = way.travel.size() - 1;
  const double dt = signal.time_s[static_cast<std::size_t>(way.range.begin + last)] -
                    signal.time_s[static_cast<std::size_t>(way.range.begin + first)];
  return dt > 0 ? (way.travel[last] - way.travel[first]) / dt : kNan;
}

}  // namespace

Conditioned condition(const importers::RawRecording& raw, const SignalSettings& given,
                      const std::optional<Vec3>& inward, const std::string& file,
                      bool drop_invalid) {
  Conditioned out;
  SignalSettings settings = given;
  if (settings.radius_m <= 0 && raw.probe_radius_m) settings.radius_m = *raw.probe_radius_m;
  out.tip_radius_m = settings.radius_m;
  out.name = raw.name;
  out.is_axial = raw.is_axial();
  out.dropped_rows = raw.dropped_rows;
  out.is_force_from_signal = raw.is_force_from_signal;
  out.inward = inward ? inward : raw.normal;
  if (out.is_axial && settings.kind != ExperimentKind::press)
    throw Error(file, "a drag or path needs positions of three axes",
                "Name `position` columns, or say kind = \"press\".");

  Signal signal = align(raw, settings, out.inward, file, drop_invalid, out.dropped_rows);
  if (const std::size_t spikes = replace_spikes(signal); spikes > 0) {
    out.reasons.push_back(std::to_string(spikes) +
                          " single readings stand out of their "
                          "neighbours and were left out");
    if (static_cast<double>(spikes) > kManySpikes * static_cast<double>(signal.rows()))
      out.grade = Grade::fair;
  }
  if (!signal.is_axial && !out.inward) {  // where the tip went until it felt most
    Eigen::Index most = 0;
    signal.force_N.rowwise().squaredNorm().maxCoeff(&most);
    const Vec3 way = signal.position_m.row(most) - signal.position_m.row(0);
    if (!(way.norm() > 0))
      throw Error(place(file, signal, 0), "the tip does not move before the force is largest",
                  "Say `normal` in the manifest.");
    signal.inward = way.normalized();
    out.inward = signal.inward;
  }
  if (settings.smooth_s > 0) {
    if (signal.time_s.empty())
      throw Error(file, "has no time to filter over",
                  "Name the time column, or leave out `smooth`.");
    smooth(signal, settings.smooth_s);
  }

  const auto phases = find_phases(signal);
  RowRange range = main_approach(signal, phases);
  if (range.rows() >= 2 && settings.kind == ExperimentKind::press)
    range = loading_part(signal, range);
  if (range.rows() < 2)
    throw Error(place(file, signal, 0), "the tip never goes in",
                "Check the normal, or turn the depth around: depth = \"-NAME\".");
  std::vector<RowRange> cycles;
  if (settings.use == Use::mean) {
    if (settings.kind != ExperimentKind::press)
      throw Error(file, "use = \"mean\" is for presses", "Say use = \"approach\".");
    cycles = cycles_like(signal, phases, range);
  }
  const Approach way = way_in(signal, range, cycles);
  check_contact(signal, way, file);
  const ContactEstimate contact = contact_of(signal, way, settings, raw, out.estimator);
  const double correlation = take_off_bias(signal, way, contact, settings, out);
  out.contact_travel_m = contact.travel_m;
  out.contact_deviation_m = contact.deviation_m;
  out.contact_m = raw.contact_m;
  if (!signal.is_axial && !raw.contact_m)
    out.contact_m = contact_position(signal, way, contact.travel_m);

  const RowRange back = retract_after(signal, phases, range);
  out.hysteresis = hysteresis_of(signal, way, back, contact.travel_m);
  out.speed_m_s = speed_of(signal, way, contact.travel_m);
  if (settings.use == Use::retract && back.rows() < 5)
    throw Error(place(file, signal, signal.rows() - 1), "has no way back",
                "Say use = \"approach\".");
  const RowRange used = settings.kind == ExperimentKind::press
                            ? (settings.use == Use::retract ? back : range)
                            : RowRange{range.begin, settings.kind == ExperimentKind::drag
                                                        ? end_of_drag(signal, phases, range)
                                                        : signal.rows()};
  take_rows(signal, used, cycles, contact.travel_m, settings, correlation, out);
  if (out.deflection_m.rows() < 3)
    throw Error(place(file, signal, range.end - 1),
                "has " + std::to_string(out.deflection_m.rows()) + " rows in contact",
                "Press deeper, or record more rows.");
  const double saturated = saturated_share(out);
  if (saturated > kMaxSaturated)
    throw Error(place(file, signal, range.end - 1),
                "the force is saturated over " + number(100 * saturated) + " % of the depth",
                "Use a sensor with a larger range, or press less deep.");
  out.young_Pa = kNan;
  if (contact.amplitude > 0 && settings.tip == Tip::sphere && settings.radius_m > 0)
    out.young_Pa = 0.75 * contact.amplitude / std::sqrt(settings.radius_m) *
                   (1 - settings.poisson * settings.poisson);
  grade(settings, contact, correlation, out);
  return out;
}

}  // namespace palpate::recordings
