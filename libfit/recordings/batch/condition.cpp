#include "libfit/recordings/batch/condition.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "libfit/core/text.hpp"
#include "libfit/recordings/contact_point/approach.hpp"
#include "libfit/recordings/contact_point/contact_point.hpp"
#include "libfit/recordings/signal/signal.hpp"
#include "libfit/recordings/signal/trace.hpp"

namespace palpate::recordings {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kMaxSaturated = 0.7;  // share of the depth
constexpr double kManySpikes = 0.01;   // of the rows of a good recording
constexpr Eigen::Index kMinFreeRows = 8;
constexpr double kWideShare = 0.5;      // of what a wider view would move the contact point
constexpr double kOtherCycle = 0.1;     // of the force: cycles of a good recording differ by less
constexpr double kTopOfPress = 0.1;     // of the travel, where cycles are compared
constexpr double kMinSignal = 20;       // force over noise of a fair recording
constexpr double kContactShare = 0.02;  // contact deviation over depth of a good recording

ContactEstimate contact_of(const Signal& signal, const Approach& approach,
                           const SignalSettings& settings, const importers::RawRecording& raw,
                           std::string& estimator) {
  if (!signal.is_axial && raw.contact_m) {
    estimator = "given";
    ContactEstimate given;
    given.travel_m = raw.contact_m->dot(signal.inward);
    return given;
  }
  if (settings.known_contact) {
    estimator = settings.has_common_contact ? "common" : "given";
    ContactEstimate given;
    given.travel_m = settings.known_contact->travel_m;
    given.deviation_m = settings.known_contact->deviation_m;
    return given;
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

// Where the tip was at the contact travel, between two rows of the way in.
Vec3 contact_position(const Signal& signal, const Approach& approach, double travel_m) {
  Eigen::Index i = 0;
  while (i + 1 < approach.travel.size() && approach.travel[i] < travel_m) ++i;
  const Vec3 here = signal.position_m.row(approach.range.begin + i);
  return here + (travel_m - approach.travel[i]) * signal.inward;
}

// Share of the work below contact that the way from the deepest reading back does not return. Both
// ways end at that reading, whichever phase it counts to: without it on one side an elastic press
// of 25 readings loses a third.
double hysteresis_of(const Signal& signal, const RowRange& way_in, const RowRange& back,
                     double contact_m) {
  if (back.rows() < 5) return kNan;
  const Eigen::VectorXd depth_m = (signal.travel_m().array() - contact_m).max(0),
                        push_N = signal.push_N();
  Eigen::Index deepest = 0;
  depth_m.segment(way_in.begin, back.end - way_in.begin).maxCoeff(&deepest);
  deepest += way_in.begin;
  const auto work_J = [&](Eigen::Index first, Eigen::Index last) {
    double sum = 0;
    for (Eigen::Index i = first + 1; i <= last; ++i)
      sum += (depth_m[i] - depth_m[i - 1]) * (push_N[i] + push_N[i - 1]) / 2;
    return sum;
  };
  const double in_J = work_J(way_in.begin, deepest);
  return in_J > 0 ? 1 + work_J(deepest, back.end - 1) / in_J : kNan;
}

double speed_of(const Signal& signal, const Approach& approach, double contact_m) {
  if (signal.time_s.empty()) return kNan;
  Eigen::Index first = 0;
  while (first + 2 < approach.travel.size() && approach.travel[first] < contact_m) ++first;
  const Eigen::Index last = approach.travel.size() - 1;
  const double dt = signal.time_s[static_cast<std::size_t>(approach.range.begin + last)] -
                    signal.time_s[static_cast<std::size_t>(approach.range.begin + first)];
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
    out.reasons.push_back(
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

// Lowers the grade of a recording to what its rows, noise (neighbours correlate by `correlation`)
// and contact point allow, with a reason each, and fills in the apparent modulus.
void grade(const SignalSettings& settings, const ContactEstimate& contact, double correlation,
           Conditioned& out) {
  const auto note = [&](Grade least, const std::string& reason) {
    out.grade = std::max(out.grade, least);
    out.reasons.push_back(reason);
  };
  const auto good =
      static_cast<Eigen::Index>(std::count(out.status.begin(), out.status.end(), RowStatus::good));
  double depth_m = 0, force_N = 0;
  for (Eigen::Index i = 0; i < out.deflection_m.rows(); ++i)
    if (out.status[static_cast<std::size_t>(i)] == RowStatus::good) {
      depth_m = std::max(depth_m, out.deflection_m.row(i).norm());
      force_N = std::max(force_N, out.force_N.row(i).norm());
    }
  if (good < out.deflection_m.rows())
    note(Grade::fair, fmt::format("{} of {} rows are saturated", out.deflection_m.rows() - good,
                                  out.deflection_m.rows()));
  if (force_N < kMinSignal * out.noise_N)
    note(Grade::poor, "the largest force is " + number(force_N / out.noise_N) + " times the noise");
  if (depth_m > 0 && contact.deviation_m > kContactShare * depth_m)
    note(contact.deviation_m > 5 * kContactShare * depth_m ? Grade::poor : Grade::fair,
         "the contact point is uncertain by " + number(100 * contact.deviation_m / depth_m) +
             " % of the depth");
  if (out.dropped_rows > 0)
    note(Grade::fair, fmt::format("{} unusable rows were left out", out.dropped_rows));
  if (correlation > 0.9)
    note(Grade::fair, "the noise before contact is a slow wave (neighbours correlate by " +
                          number(correlation) + ")");
  out.apparent_Pa = apparent_modulus_Pa(force_N, depth_m, settings);
}

// What the recording says of itself beside its rows.
Conditioned described(const importers::RawRecording& raw, const SignalSettings& settings,
                      const std::optional<Vec3>& inward, const std::string& file) {
  Conditioned out;
  out.source.tip_radius_m = settings.radius_m;
  out.name = raw.name;
  out.is_axial = raw.is_axial();
  out.dropped_rows = raw.dropped_rows;
  out.source.is_force_from_signal = raw.is_force_from_signal;
  out.source.cantilever = raw.cantilever;
  out.source.format = raw.format, out.source.taken = raw.taken;
  out.inward = inward ? inward : raw.normal;
  if (out.is_axial && settings.kind != ExperimentKind::press)
    throw Error(file, "a drag or path needs positions of three axes",
                "Name `position` columns, or say kind = \"press\".");
  return out;
}

void leave_out_spikes(Signal& signal, Conditioned& out) {
  const std::size_t spikes = replace_spikes(signal);
  if (spikes == 0) return;
  out.reasons.push_back(
      fmt::format("{} single readings stand out of their neighbours and were left out", spikes));
  if (static_cast<double>(spikes) > kManySpikes * static_cast<double>(signal.rows()))
    out.grade = Grade::fair;
}

// Where nobody says it: where the tip went until it felt most.
void find_inward(const std::string& file, Signal& signal, Conditioned& out) {
  if (signal.is_axial || out.inward) return;
  Eigen::Index most = 0;
  signal.force_N.rowwise().squaredNorm().maxCoeff(&most);
  const Vec3 move = signal.position_m.row(most) - signal.position_m.row(0);
  if (!(move.norm() > 0))
    throw Error(place(file, signal, 0), "the tip does not move before the force is largest",
                "Say `normal` in the manifest.");
  signal.inward = move.normalized();
  out.inward = signal.inward;
}

void filter(const SignalSettings& settings, const std::string& file, Signal& signal) {
  if (!(settings.smooth_s > 0)) return;
  if (signal.time_s.empty())
    throw Error(file, "has no time to filter over", "Name the time column, or leave out `smooth`.");
  smooth(signal, settings.smooth_s);
}

// Push over the deepest part of a way in that all of them reach, above where it begins.
double push_at_depth_N(const Signal& signal, const RowRange& way, double from_m, double to_m) {
  const Eigen::VectorXd travel = signal.travel_m(), push = signal.push_N();
  const Eigen::Index free = std::max<Eigen::Index>(1, way.rows() / 20);
  double sum = 0, n = 0;
  for (Eigen::Index i = way.begin; i < way.end; ++i)
    if (travel[i] >= from_m && travel[i] <= to_m) sum += push[i], n += 1;
  return n > 0 ? sum / n - push.segment(way.begin, free).mean() : kNan;
}

// The press that the settings ask for, of those that go as deep, and a word on there being others.
RowRange chosen_cycle(const Signal& signal, const std::vector<Phase>& phases, const RowRange& main,
                      const SignalSettings& settings, const std::string& file, Conditioned& out) {
  const std::vector<RowRange> presses = presses_like(signal, phases, main);
  const auto count = static_cast<int>(presses.size());
  if (settings.cycle > std::max(1, count))
    throw Error(file,
                fmt::format("holds {} as deep as its deepest, and cycle = {} is asked for",
                            counted(count, "press", "presses"), settings.cycle),
                "Say cycle = \"first\", \"last\" or a number that is there.");
  if (count < 2) return main;
  std::size_t taken = presses.size() - 1;
  if (settings.cycle > 0) taken = static_cast<std::size_t>(settings.cycle - 1);
  if (settings.cycle == kDeepestCycle)
    taken = static_cast<std::size_t>(std::ranges::find(presses, main.begin, &RowRange::begin) -
                                     presses.begin());
  if (taken >= presses.size()) return main;
  const Eigen::VectorXd travel = signal.travel_m();
  double reach_m = travel[main.end - 1];
  for (const RowRange& way : presses) reach_m = std::min(reach_m, travel[way.end - 1]);
  const double from_m = reach_m - kTopOfPress * (reach_m - travel[main.begin]),
               first_N = push_at_depth_N(signal, presses.front(), from_m, reach_m),
               last_N = push_at_depth_N(signal, presses.back(), from_m, reach_m),
               change = last_N / first_N - 1;
  std::string note = fmt::format("holds {} as deep; number {} is taken",
                                 counted(count, "press", "presses"), taken + 1);
  if (std::isfinite(change) && std::abs(change) > kOtherCycle) {
    note += fmt::format(", and the last is {} {} than the first", percent(std::abs(change), 0),
                        change < 0 ? "softer" : "stiffer");
    out.grade = std::max(out.grade, Grade::fair);
  }
  out.reasons.push_back(note);
  return presses[taken];
}

// Where the tip goes in. loadings: of a press in cycles that go deeper and deeper.
struct WaysIn {
  std::vector<RowRange> loadings, cycles;
  RowRange range, whole;  // the part that loads, and all of it
  std::optional<Eigen::Index> broken;
};

WaysIn ways_in(const Signal& signal, const std::vector<Phase>& phases,
               const SignalSettings& settings, const std::string& file, Conditioned& recording) {
  WaysIn out;
  const bool is_press = settings.kind == ExperimentKind::press;
  const bool presses_once = is_press && settings.use == Use::approach;
  if (!is_press && (settings.use == Use::mean || settings.cycle != kDeepestCycle))
    throw Error(file, "`cycle` is for presses", "Leave it out, or say kind = \"press\".");
  if (presses_once && settings.cycle == kDeepestCycle)
    out.loadings = first_loadings(signal, phases);
  out.range = out.loadings.empty() ? main_approach(signal, phases) : out.loadings.front();
  if (is_press && settings.use != Use::mean && out.loadings.empty() && out.range.rows() >= 2)
    out.range = chosen_cycle(signal, phases, out.range, settings, file, recording);
  for (const RowRange& way : out.loadings.empty() ? std::vector{out.range} : out.loadings)
    if (presses_once && !out.broken) out.broken = break_in_row(signal, way);
  if (out.broken) {  // beyond it there is no curve of the body
    const Eigen::Index end = *out.broken + 1;
    std::erase_if(out.loadings, [&](const RowRange& way) { return way.begin >= end; });
    for (RowRange& way : out.loadings) way.end = std::min(way.end, end);
    out.range.end = std::min(out.range.end, end);
  }
  out.whole = out.range;
  if (out.range.rows() >= 2 && is_press && !out.broken) out.range = loading_part(signal, out.range);
  if (out.range.rows() < 2)
    throw Error(place(file, signal, 0), "the tip never goes in",
                "Check the normal, or turn the depth around: depth = \"-NAME\".");
  if (settings.use == Use::mean) out.cycles = cycles_like(signal, phases, out.range);
  return out;
}

// The contact point, with the bias taken off. Returns how neighbours correlate in the noise.
double find_contact(const importers::RawRecording& raw, const SignalSettings& settings,
                    const std::string& file, const WaysIn& ways, Signal& signal,
                    ContactEstimate& contact, SeenSignal& seen, Conditioned& out) {
  Approach approach = approach_of(signal, ways.range, ways.cycles);
  check_contact(signal, approach, file);
  check_sign(signal, approach, file);
  if (settings.keeps_way_in || (settings.has_common_contact && !settings.known_contact)) {
    out.way_in.travel_m = signal.travel_m()(approach.rows);
    out.way_in.push_N = signal.push_N()(approach.rows);
  }
  focus_on_contact(signal, exponent_of(settings.tip), approach);
  contact = contact_of(signal, approach, settings, raw, out.contact.estimator);
  seen.approach = ways.range, seen.contact_m = contact.travel_m;
  seen.bias_N = signal.push_N();
  const double correlation = take_off_bias(signal, approach, contact, settings, out);
  seen.bias_N -= signal.push_N();
  out.contact.travel_m = contact.travel_m;
  out.contact.deviation_m = contact.deviation_m;
  out.contact_m = raw.contact_m;
  if (!signal.is_axial && !raw.contact_m)
    out.contact_m = contact_position(signal, approach, contact.travel_m);
  out.speed_m_s = speed_of(signal, approach, contact.travel_m);
  return correlation;
}

void tell_break(const Signal& signal, const std::optional<Eigen::Index>& broken, Conditioned& out) {
  out.breaks = broken.has_value();
  if (!broken) return;
  out.reasons.push_back("the force falls from " + number(signal.push_N()[*broken]) + " N at " +
                        millimetres(signal.travel_m()[*broken] - out.contact.travel_m) +
                        ": the tool breaks in, and deeper rows were left out");
}

RowRange used_rows(const Signal& signal, const std::vector<Phase>& phases,
                   const SignalSettings& settings, const WaysIn& ways, const RowRange& back) {
  switch (settings.kind) {
    case ExperimentKind::press:
      if (settings.use == Use::retract) return back;
      return ways.loadings.empty() ? ways.range : ways.loadings.back();
    case ExperimentKind::drag:
      return {ways.range.begin, end_of_drag(signal, phases, ways.range)};
    default:
      return {ways.range.begin, signal.rows()};
  }
}

void check_rows(const Conditioned& out, const std::string& where) {
  if (out.deflection_m.rows() < 3)
    throw Error(where, fmt::format("has {} rows in contact", out.deflection_m.rows()),
                "Press deeper, or record more rows.");
  const double saturated = saturated_share(out);
  if (saturated > kMaxSaturated)
    throw Error(where, "the force is saturated over " + number(100 * saturated) + " % of the depth",
                "Use a sensor with a larger range, or press less deep.");
}

// Deflections are from the centre's place at first touch: only where that is on the body changes.
void move_to_surface(const SignalSettings& settings, const std::string& file, Conditioned& out) {
  if (out.is_axial || !out.contact_m || !out.inward) return;
  if (!(settings.radius_m > 0))
    throw Error(file, "has positions of the ball's centre, and its radius is unknown",
                "Say it in the manifest: probe = { radius = \"5 mm\" }.");
  *out.contact_m += settings.radius_m * *out.inward;
}

double young_of(const ContactEstimate& contact, const SignalSettings& settings) {
  if (!(contact.amplitude > 0 && settings.tip == Tip::sphere && settings.radius_m > 0)) return kNan;
  return 0.75 * contact.amplitude / std::sqrt(settings.radius_m) *
         (1 - settings.poisson * settings.poisson);
}

// As `condition` says; what of the signal is seen by then goes to `seen`.
Conditioned condition_seen(const importers::RawRecording& raw, const SignalSettings& given,
                           const std::optional<Vec3>& inward, const std::string& file,
                           bool drop_invalid, SeenSignal& seen) {
  SignalSettings settings = given;
  if (settings.radius_m <= 0 && raw.probe_radius_m) settings.radius_m = *raw.probe_radius_m;
  Conditioned out = described(raw, settings, inward, file);
  Signal signal = align(raw, settings, out.inward, file, drop_invalid, out.dropped_rows);
  const Points recorded_N = signal.force_N;
  leave_out_spikes(signal, out);
  find_inward(file, signal, out);
  seen.time_s = signal.time_s;
  seen.travel_m = signal.travel_m(), seen.push_N = recorded_N * signal.inward;
  filter(settings, file, signal);

  const auto phases = find_phases(signal);
  seen.phase = phases;
  WaysIn ways = ways_in(signal, phases, settings, file, out);
  ContactEstimate contact;
  const double correlation = find_contact(raw, settings, file, ways, signal, contact, seen, out);
  if (settings.kind == ExperimentKind::press)
    out.history =
        timed_press(signal, contact.travel_m, signal.is_axial ? std::nullopt : out.contact_m,
                    out.noise_N, correlation);
  const RowRange back = retract_after(signal, phases, ways.whole);
  out.hysteresis = hysteresis_of(signal, ways.whole, back, contact.travel_m);
  if (settings.use == Use::retract && back.rows() < 5)
    throw Error(place(file, signal, signal.rows() - 1), "has no way back",
                "Say use = \"approach\".");
  if (!ways.loadings.empty()) {
    ways.cycles.assign(ways.loadings.begin(), ways.loadings.end() - 1);
    if (!ways.broken) take_cycles(signal, phases, contact.travel_m, correlation, out);
  }
  tell_break(signal, ways.broken, out);
  const RowRange used = used_rows(signal, phases, settings, ways, back);
  seen.used = ways.cycles, seen.used.push_back(used);
  take_rows(signal, used, ways.cycles, contact.travel_m, settings, correlation, out);
  if (settings.is_position_of_center) move_to_surface(settings, file, out);
  check_rows(out, place(file, signal, ways.range.end - 1));
  out.young_Pa = young_of(contact, settings);
  grade(settings, contact, correlation, out);
  return out;
}

}  // namespace

Conditioned condition(const importers::RawRecording& raw, const SignalSettings& settings,
                      const std::optional<Vec3>& inward, const std::string& file, bool drop_invalid,
                      SignalTrace* refused) {
  SeenSignal seen;
  try {
    Conditioned out = condition_seen(raw, settings, inward, file, drop_invalid, seen);
    out.trace = trace_of(seen);
    return out;
  } catch (const Error&) {
    if (refused) *refused = trace_of(seen);
    throw;
  }
}

double apparent_modulus_Pa(double force_N, double depth_m, const SignalSettings& settings) {
  if (!(force_N > 0) || !(depth_m > 0)) return kNan;
  const double elastic = 1 - 0.25;  // nu = 1/2
  if (settings.radius_m <= 0) return force_N / (depth_m * depth_m);
  return settings.tip == Tip::flat
             ? elastic * force_N / (2 * settings.radius_m * depth_m)
             : 0.75 * elastic * force_N / (std::sqrt(settings.radius_m * depth_m) * depth_m);
}

}  // namespace palpate::recordings
