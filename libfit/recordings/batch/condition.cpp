#include "libfit/recordings/batch/batch.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "libfit/core/text.hpp"

namespace palpate::recordings {
namespace {

constexpr double kContactShare = 0.02;  // contact deviation over depth of a good recording

// Work that loading takes below contact, and work that unloading returns.
struct PressWork {
  double in_J = kNan, out_J = kNan;
  /// Standard deviation of their difference, by noise, drift of the bias and travel of a reading.
  double deviation_J = 0;
  double most_N = 0;  ///< at the deepest reading

  double lost_share() const { return 1 - out_J / in_J; }
};

// Loading ends and unloading begins at the deepest reading, whichever phase it counts to: without
// it on one side an elastic press of 25 readings loses a third. Both are NaN where unloading is not
// recorded, or ends while more than a percent of the work is still stored.
PressWork press_work(const Signal& signal, const Eigen::VectorXd& push_N, double noise_N) {
  const RowRange &approach = signal.range.approach, &back = signal.range.unloading;
  if (back.rows() < 5) return {};
  const Eigen::VectorXd depth_m = (signal.travel_m().array() - signal.contact_m).max(0);
  Eigen::Index deepest = 0;
  depth_m.segment(approach.begin, back.end - approach.begin).maxCoeff(&deepest);
  deepest += approach.begin;
  const auto work_J = [&](Eigen::Index first, Eigen::Index last) {
    double sum = 0;
    for (Eigen::Index i = first + 1; i <= last; ++i)
      sum += (depth_m[i] - depth_m[i - 1]) * (push_N[i] + push_N[i - 1]) / 2;
    return sum;
  };
  const double in_J = work_J(approach.begin, deepest),
               out_m = depth_m.segment(deepest, back.end - deepest).minCoeff();
  Eigen::Index passed = approach.begin;  // as deep as unloading ends
  while (passed < deepest && depth_m[passed] < out_m) ++passed;
  if (!(in_J > 0) || work_J(approach.begin, passed) > 0.01 * in_J) return {};
  Eigen::Index free = 0;  // readings at the end, without contact
  while (free < back.rows() && depth_m[back.end - 1 - free] == 0) ++free;
  const Eigen::Index last = (free + 3) / 4;
  const double drift_N = last > 0 ? push_N.segment(back.end - last, last).mean() : 0;
  double squares_m2 = 0;
  for (Eigen::Index i = approach.begin + 1; i + 1 < back.end; ++i)
    squares_m2 += std::pow((depth_m[i + 1] - depth_m[i - 1]) / 2, 2);
  const auto loaded =
      (depth_m.segment(approach.begin, deepest + 1 - approach.begin).array() > 0).count();
  const double step_m = depth_m[deepest] / static_cast<double>(loaded);
  const Vec3 deviations_J(noise_N * std::sqrt(squares_m2), drift_N * depth_m[deepest],
                          2 * step_m * push_N[deepest] / kSeenInErrors);
  return {in_J, -work_J(deepest, back.end - 1), deviations_J.norm(), push_N[deepest]};
}

// Interpolates y at a place of x, which rises, between rows from `row` on; moves that there.
double interpolated(const Eigen::Ref<const Eigen::VectorXd>& x, const Eigen::VectorXd& y, double at,
                    Eigen::Index& row) {
  while (row + 2 < x.size() && x[row + 1] < at) ++row;
  const double step = x[row + 1] - x[row];
  const double share = step > 0 ? std::clamp((at - x[row]) / step, 0.0, 1.0) : 0;
  return (1 - share) * y[row] + share * y[row + 1];
}

// Interpolates the push to `delay_s` after each position. Precondition: the signal has a clock.
Eigen::VectorXd push_after_N(const Signal& signal, double delay_s) {
  const Eigen::Map<const Eigen::VectorXd> time_s(signal.time_s.data(), signal.rows());
  const Eigen::VectorXd push_N = signal.push_N();
  Eigen::VectorXd later_N(push_N.size());
  for (Eigen::Index i = 0, row = 0; i < push_N.size(); ++i)
    later_N[i] = interpolated(time_s, push_N, time_s[i] + delay_s, row);
  return later_N;
}

// Finds the delay of the force that makes both works equal, below the time of loading.
std::optional<double> delay_of(const Signal& signal, double noise_N) {
  if (signal.time_s.empty()) return std::nullopt;
  const auto loses = [&](double delay_s) {
    return press_work(signal, push_after_N(signal, delay_s), noise_N).lost_share() > 0;
  };
  const RowRange& approach = signal.range.approach;
  double least_s = 0, most_s = signal.time_s[approach.end - 1] - signal.time_s[approach.begin];
  if (!loses(most_s)) return std::nullopt;
  for (int halved = 0; halved < 30; ++halved) {
    const double tried_s = (least_s + most_s) / 2;
    (loses(tried_s) ? most_s : least_s) = tried_s;
  }
  return most_s;
}

// A force that lags the position by a travel s returns 2 s F more work than it takes, F the force
// at the turn, and a passive body does not. The travel is added to the contact's deviation.
void question_delay(const Signal& signal, const PressWork& work, Conditioned& out) {
  const double excess_J = work.out_J - work.in_J;
  if (!(excess_J > kMinEffect * work.in_J)) return;
  if (out.contact.estimator != "given" && work.most_N > 0)
    out.contact.deviation_m = std::hypot(out.contact.deviation_m, excess_J / (2 * work.most_N));
  std::string reason = "unloading returns " + percent(work.out_J / work.in_J, 0) +
                       " of the work of loading, which no passive body does: ";
  if (excess_J < kSeenInErrors * work.deviation_J) {
    out.reasons.push_back(reason + "noise, drift or few readings may be why");
    return;
  }
  out.grade = std::max(out.grade, Grade::fair);
  reason += "the force is later than the position, or the drive has backlash";
  if (const auto delay_s = delay_of(signal, out.noise_N))
    reason += "; force_delay = \"" + number(*delay_s, 2) + " s\" closes the loop";
  out.reasons.push_back(reason);
}

double apparent_modulus_Pa(double force_N, double depth_m, const SignalSettings& settings) {
  if (!(force_N > 0) || !(depth_m > 0)) return kNan;
  const double elastic = 1 - 0.25;  // nu = 1/2
  if (settings.radius_m <= 0) return force_N / (depth_m * depth_m);
  return settings.tip == Tip::flat
             ? elastic * force_N / (2 * settings.radius_m * depth_m)
             : 0.75 * elastic * force_N / (std::sqrt(settings.radius_m * depth_m) * depth_m);
}

// Lowers the grade of a recording to what its rows, noise (neighbours correlate by `correlation`)
// and contact point allow, with a reason each, and fills in the apparent modulus.
void grade(const SignalSettings& settings, double correlation, Conditioned& out) {
  const auto note = [&](Grade least, const std::string& reason) {
    out.grade = std::max(out.grade, least);
    out.reasons.push_back(reason);
  };
  const Eigen::Index good = std::ranges::count(out.status, RowStatus::good);
  double depth_m = 0, force_N = 0;
  for (Eigen::Index i = 0; i < out.deflection_m.rows(); ++i)
    if (out.status[i] == RowStatus::good) {
      depth_m = std::max(depth_m, out.deflection_m.row(i).norm());
      force_N = std::max(force_N, out.force_N.row(i).norm());
    }
  if (good < out.deflection_m.rows())
    note(Grade::fair, fmt::format("{} of {} rows are saturated", out.deflection_m.rows() - good,
                                  out.deflection_m.rows()));
  if (force_N < kMinForceInNoise * out.noise_N)
    note(Grade::poor, "the largest force is " + number(force_N / out.noise_N) + " times the noise");
  if (depth_m > 0 && out.contact.deviation_m > kContactShare * depth_m)
    note(out.contact.deviation_m > 5 * kContactShare * depth_m ? Grade::poor : Grade::fair,
         "the contact point is uncertain by " + number(100 * out.contact.deviation_m / depth_m) +
             " % of the depth");
  if (settings.kind == ExperimentKind::press && settings.radius_m > 0 &&
      depth_m > 30 * settings.radius_m)  // presses are a few deep, and a prefix is 1000
    note(Grade::poor, "the press is " + number(depth_m / settings.radius_m) +
                          " radii of its tip deep: is the unit of radius right?");
  if (correlation > 0.9)
    note(Grade::fair, "the noise before contact is a slow wave (neighbours correlate by " +
                          number(correlation) + ")");
  out.apparent_Pa = apparent_modulus_Pa(force_N, depth_m, settings);
}

// Fills in the recording's own words beside its rows.
Conditioned described(const importers::RawRecording& raw, const SignalSettings& settings,
                      const std::optional<Vec3>& inward, const std::string& file) {
  Conditioned out;
  out.name = raw.name;
  out.is_axial = raw.is_axial();
  out.source = raw;
  out.inward = inward ? inward : raw.normal;
  if (!raw.place.empty()) out.reasons.push_back(raw.place);
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
  if (static_cast<double>(spikes) > 0.01 * static_cast<double>(signal.rows()))
    out.grade = Grade::fair;
}

// Without a normal: the tip's path to the row of the largest force.
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

// A filter of at most this share of the approach moves no contact. Presses in 2 s with noise of 2,
// 5 and 10 %: with 1/40 contacts are off by 32, 94 and 209 um (31, 96 and 193 without a filter),
// with 1/20 by 92, 129 and 1103; 1/80 leaves a position that scatters.
constexpr double kLongestFilter = 1.0 / 40;

void filter(const SignalSettings& settings, const std::string& file, Signal& signal) {
  if (!(settings.smooth_s > 0)) return;
  if (signal.time_s.empty())
    throw Error(file, "has no time to filter over", "Name the time column, or leave out `smooth`.");
  smooth(signal, settings.smooth_s);
}

void check_filter(const SignalSettings& settings, const std::string& file, const Signal& signal) {
  if (!(settings.smooth_s > 0)) return;
  const RowRange& in = signal.range.approach;
  const double most_s = kLongestFilter * (signal.time_s[in.end - 1] - signal.time_s[in.begin]);
  if (settings.smooth_s > most_s)
    throw Error(
        file,
        fmt::format("smooth = \"{} s\" is more than a fortieth of the way in, and bends the "
                    "curve",
                    number(settings.smooth_s)),
        "Leave `smooth` out, or say " + number(most_s, 2) + " s at most.");
}

void report_break(const Signal& signal, Conditioned& out) {
  const auto& row = signal.range.break_in;
  out.breaks = row.has_value();
  if (!row) return;
  out.reasons.push_back("the force falls from " + number(signal.push_N()[*row]) + " N at " +
                        millimetres(signal.travel_m()[*row] - out.contact.travel_m) +
                        ": the tool breaks in, and deeper rows were left out");
}

void check_rows(const Conditioned& out, const std::string& where) {
  if (out.deflection_m.rows() < 3)
    throw Error(where, fmt::format("has {} rows in contact", out.deflection_m.rows()),
                "Press deeper, or record more rows.");
  const auto first = std::ranges::find(out.status, RowStatus::rejected) - out.status.begin();
  const double saturated = 1 - static_cast<double>(first) / out.status.size();
  if (saturated > 0.7)
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

// The range that rows come from, beside those whose means they share.
RowRange main_range(const Signal& signal, const SignalSettings& settings) {
  const SignalRanges& range = signal.range;
  if (settings.kind == ExperimentKind::path) return {range.loading.begin, signal.rows()};
  if (settings.kind == ExperimentKind::drag) {
    const auto slid = signal.phase.begin() + range.loading.end;
    const auto end = std::find(slid, signal.phase.end(), Phase::retract);
    return {range.loading.begin, end - signal.phase.begin()};
  }
  return range.loading;
}

// Follows `condition`: read, aligned, filtered, in phases, in contact, in rows.
Conditioned condition_signal(const importers::RawRecording& raw, const SignalSettings& settings,
                             const std::optional<Vec3>& inward, const std::string& file,
                             Signal& signal) {
  if (settings.is_pass) check_pass_settings(settings, file);
  Conditioned out = described(raw, settings, inward, file);
  const bool is_press = settings.kind == ExperimentKind::press;
  signal = align(raw, settings, out.inward, file);
  const Points recorded_N = signal.force_N;
  leave_out_spikes(signal, out);
  find_inward(file, signal, out);
  signal.recorded_travel_m = signal.travel_m(), signal.recorded_push_N = recorded_N * signal.inward;
  filter(settings, file, signal);

  signal.phase = find_phases(signal);
  find_ranges(settings, file, signal, out);
  if (is_press) check_filter(settings, file, signal);
  SignalRanges& range = signal.range;
  range.unloading = retract_after(signal, range.approach);
  std::vector<RowRange> cycles;
  if (settings.use == Use::mean) cycles = cycles_like(signal, range.loading);
  const ContactEstimate contact = find_contact(raw, settings, file, cycles, signal, out);
  const double r = signal.correlation;
  if (is_press)
    out.history = timed_press(signal, signal.is_axial ? std::nullopt : out.contact_m, out.noise_N);
  const PressWork work =
      press_work(signal, signal.push_N(), out.noise_N * std::sqrt((1 + r) / (1 - r)));
  out.hysteresis = work.lost_share();
  if (is_press) question_delay(signal, work, out);
  report_break(signal, out);
  range.used = std::move(cycles), range.used.push_back(main_range(signal, settings));
  take_rows(signal, settings, out);
  if (settings.is_position_of_center) move_to_surface(settings, file, out);
  check_rows(out, place(file, signal, range.loading.end - 1));
  out.history.noise_N = out.noise_N, out.history.contact_deviation_m = out.contact.deviation_m;
  out.young_Pa = young_of(contact, settings);
  grade(settings, r, out);
  return out;
}

}  // namespace

Conditioned condition(const importers::RawRecording& raw, const SignalSettings& settings,
                      const std::optional<Vec3>& inward, const std::string& file,
                      SignalTrace* refused) {
  Signal signal;
  try {
    Conditioned out = condition_signal(raw, settings, inward, file, signal);
    out.trace = trace_of(signal);
    return out;
  } catch (const Error&) {
    if (refused) *refused = trace_of(signal);
    throw;
  }
}

}  // namespace palpate::recordings
