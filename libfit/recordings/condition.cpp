#include "libfit/recordings/condition.hpp"

#include <algorithm>
#include <cmath>

#include "libfit/recordings/contact.hpp"
#include "libfit/recordings/phases.hpp"
#include "libfit/recordings/rows.hpp"

namespace palpate::recordings {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr int kMeans = 400;         // of the way in, for the contact fit
constexpr double kFreeShare = 0.1;  // of the way in, taken as free to start with
constexpr double kSeenInNoise = 5;  // a rise below this is no contact
constexpr double kEndShare = 0.1;   // of the travel, within which the largest force ends the way in
constexpr Eigen::Index kLeastFreeRows = 8;
constexpr double kMostSaturated = 0.7;  // share of the depth
constexpr double kLeastSignal = 20;     // force over noise of a fair recording
constexpr double kContactShare = 0.02;  // contact deviation over depth of a good recording

std::string place(const std::string& file, const Signal& signal, Eigen::Index row) {
  return file + ":" +
         std::to_string(signal.line[static_cast<std::size_t>(
             std::clamp<Eigen::Index>(row, 0, signal.rows() - 1))]);
}

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

struct Line {
  double at_0 = 0, slope = 0, deviation = 0, correlation = 0;
};

Line fit_line(const Eigen::VectorXd& x, const Eigen::VectorXd& y) {
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

// Scatter of neighbouring readings, for recordings that have no free part.
double scatter_N(const Eigen::VectorXd& push) {
  std::vector<double> bent;
  for (Eigen::Index i = 1; i + 1 < push.size(); ++i)
    bent.push_back(std::abs(push[i - 1] - 2 * push[i] + push[i + 1]));
  if (bent.empty()) return 0;
  std::nth_element(bent.begin(), bent.begin() + static_cast<std::ptrdiff_t>(bent.size() / 2),
                   bent.end());
  return bent[bent.size() / 2] / 0.6745 / std::sqrt(6.0);
}

// The way in without its last rows where the force falls already: a soft cantilever springs back
// before the tip does.
RowRange loading_part(const Signal& signal, RowRange range) {
  const Eigen::VectorXd travel = signal.travel_m().segment(range.begin, range.rows());
  Eigen::Index most = 0;
  signal.push_N().segment(range.begin, range.rows()).maxCoeff(&most);
  if (travel[most] > travel.maxCoeff() - kEndShare * (travel.maxCoeff() - travel.minCoeff()))
    range.end = range.begin + most + 1;
  return range;
}

// The way in, as the estimators and the checks see it.
struct Approach {
  RowRange range;
  Eigen::VectorXd travel, push;
  double noise_N = 0;  ///< of one reading
  PressCurve curve;
};

Approach way_in(const Signal& signal, const RowRange& range) {
  Approach way;
  way.range = range;
  way.travel = signal.travel_m().segment(range.begin, range.rows());
  way.push = signal.push_N().segment(range.begin, range.rows());
  const auto free = static_cast<Eigen::Index>(kFreeShare * static_cast<double>(range.rows()));
  way.noise_N = free >= kLeastFreeRows
                    ? fit_line(way.travel.head(free), way.push.head(free)).deviation
                    : scatter_N(way.push);
  Eigen::Index believed = 0;  // a saturated force tells nothing about contact
  while (believed < range.rows() &&
         !signal.is_saturated[static_cast<std::size_t>(range.begin + believed)])
    ++believed;
  if (believed < kLeastFreeRows) believed = range.rows();
  way.curve = mean_curve(way.travel.head(believed), way.push.head(believed), kMeans);
  const double per_mean =
      static_cast<double>(believed) / static_cast<double>(way.curve.push_N.size());
  way.curve.noise_N = way.noise_N / std::sqrt(per_mean);
  return way;
}

// Push of the deepest part over that of the first part.
double rise_of(const PressCurve& curve) {
  const Eigen::Index n = curve.push_N.size();
  const Eigen::Index deep = std::max<Eigen::Index>(1, n / 20),
                     free = std::max<Eigen::Index>(1, n / 10);
  return curve.push_N.tail(deep).mean() - curve.push_N.head(free).mean();
}

void check_contact(const Signal& signal, const Approach& way, const std::string& file) {
  if (way.curve.push_N.size() < 5)
    throw Error(place(file, signal, way.range.begin),
                "the tip goes in over " + std::to_string(way.curve.push_N.size()) + " rows alone",
                "Record at least 5 rows on the way in; is the depth's sign right?");
  const double rise_N = rise_of(way.curve), seen_N = kSeenInNoise * way.noise_N;
  if (rise_N < -seen_N && rise_N < 0)
    throw Error(place(file, signal, way.range.end - 1),
                "the force falls as the tip goes in, to " + number(rise_N) +
                    " N: the sign of force or depth is reversed",
                "Say force_on = \"tool\" or \"body\", whichever it is not yet, or turn the depth "
                "around: depth = \"-NAME\".");
  const auto first = signal.is_saturated.begin() + way.range.begin,
             last = signal.is_saturated.begin() + way.range.end;
  if (!(rise_N > seen_N) && std::find(first, last, 1) != last)
    throw Error(
        place(file, signal, std::find(first, last, 1) - signal.is_saturated.begin()),
        "the force is saturated before it rises out of its noise of " + number(way.noise_N) + " N",
        "Use a sensor with a larger range.");
  if (!(rise_N > seen_N) || !(rise_N > 0))
    throw Error(place(file, signal, way.range.end - 1),
                "no contact: the force rises by " + number(rise_N) +
                    " N on the way in, its noise is " + number(way.noise_N) + " N",
                "Press deeper, or remove the recording.");
}

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

// Takes the free push off all rows, and says how noisy it is.
void take_off_bias(Signal& signal, const Approach& way, const ContactEstimate& contact,
                   const SignalSettings& settings, Conditioned& out, double& correlation) {
  const double margin_m =
      std::max(3 * contact.deviation_m, 0.01 * (way.travel.maxCoeff() - way.travel.minCoeff()));
  Eigen::Index free = 0;
  while (free < way.travel.size() && way.travel[free] < contact.travel_m - margin_m) ++free;
  if (free < kLeastFreeRows) {  // less of a margin, before none is left
    for (free = 0; free < way.travel.size() && way.travel[free] < contact.travel_m; ++free) {
    }
  }
  if (free < kLeastFreeRows || contact.begins_in_contact) {
    out.reasons.push_back(out.estimator == "given"
                              ? "the contact point is the file's own; no bias was taken off"
                              : "begins in contact: no free travel from which to take the bias");
    if (out.estimator != "given") out.grade = std::max(out.grade, Grade::fair);
    out.noise_N = way.noise_N;
    return;
  }
  const Eigen::VectorXd travel = way.travel.head(free);
  const Line line = fit_line(travel, way.push.head(free));
  out.noise_N = line.deviation;
  correlation = std::clamp(line.correlation, 0.0, 0.95);
  if (settings.drift == Drift::none) return;
  const Eigen::VectorXd all = signal.travel_m();
  for (int axis = 0; axis < 3; ++axis) {
    const Line drift = fit_line(travel, signal.force_N.col(axis).segment(way.range.begin, free));
    if (settings.drift == Drift::line)
      signal.force_N.col(axis).array() -= drift.at_0 + drift.slope * all.array();
    else
      signal.force_N.col(axis).array() -=
          signal.force_N.col(axis).segment(way.range.begin, free).mean();
  }
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

void grade(const SignalSettings& settings, const ContactEstimate& contact, double correlation,
           Conditioned& out) {
  const auto note = [&](Grade least, const std::string& reason) {
    out.grade = std::max(out.grade, least), out.reasons.push_back(reason);
  };
  const auto good =
      static_cast<Eigen::Index>(std::count(out.status.begin(), out.status.end(), RowStatus::good));
  double depth_m = 0, force_N = 0;
  for (Eigen::Index i = 0; i < out.deflection_m.rows(); ++i)
    if (out.status[static_cast<std::size_t>(i)] == RowStatus::good)
      depth_m = std::max(depth_m, out.deflection_m.row(i).norm()),
      force_N = std::max(force_N, out.force_N.row(i).norm());
  if (good < out.deflection_m.rows())
    note(Grade::fair, std::to_string(out.deflection_m.rows() - good) + " of " +
                          std::to_string(out.deflection_m.rows()) + " rows are saturated");
  if (force_N < kLeastSignal * out.noise_N)
    note(Grade::poor, "the largest force is " + number(force_N / out.noise_N) + " times the noise");
  if (depth_m > 0 && contact.deviation_m > kContactShare * depth_m)
    note(contact.deviation_m > 5 * kContactShare * depth_m ? Grade::poor : Grade::fair,
         "the contact point is uncertain by " + number(100 * contact.deviation_m / depth_m) +
             " % of the depth");
  if (out.dropped_rows > 0)
    note(Grade::fair, std::to_string(out.dropped_rows) + " unusable rows were left out");
  if (correlation > 0.9)
    note(Grade::fair, "the noise before contact is a slow wave (neighbours correlate by " +
                          number(correlation) + ")");
  out.apparent_Pa = apparent_modulus_Pa(force_N, depth_m, settings);
}

}  // namespace

double apparent_modulus_Pa(double force_N, double depth_m, const SignalSettings& settings) {
  if (!(force_N > 0) || !(depth_m > 0)) return kNan;
  const double elastic = 1 - 0.25;  // nu = 1/2
  if (settings.radius_m <= 0) return force_N / (depth_m * depth_m);
  return settings.tip == Tip::flat
             ? elastic * force_N / (2 * settings.radius_m * depth_m)
             : 0.75 * elastic * force_N / (std::sqrt(settings.radius_m * depth_m) * depth_m);
}

Conditioned condition(const importers::RawRecording& raw, const SignalSettings& given,
                      const std::optional<Vec3>& inward, const std::string& file,
                      bool drop_invalid) {
  Conditioned out;
  SignalSettings settings = given;
  if (settings.radius_m <= 0 && raw.probe_radius_m) settings.radius_m = *raw.probe_radius_m;
  out.name = raw.name, out.is_axial = raw.is_axial(), out.dropped_rows = raw.dropped_rows;
  out.inward = inward ? inward : raw.normal;
  if (out.is_axial && settings.kind != ExperimentKind::press)
    throw Error(file, "a drag or path needs positions of three axes",
                "Name `position` columns, or say kind = \"press\".");

  Signal signal = align(raw, settings, out.inward, file, drop_invalid, out.dropped_rows);
  if (!signal.is_axial && !out.inward) {  // where the tip went until it felt most
    Eigen::Index most = 0;
    signal.force_N.rowwise().squaredNorm().maxCoeff(&most);
    const Vec3 way = signal.position_m.row(most) - signal.position_m.row(0);
    if (!(way.norm() > 0))
      throw Error(place(file, signal, 0), "the tip does not move before the force is largest",
                  "Say `normal` in the manifest.");
    signal.inward = way.normalized(), out.inward = signal.inward;
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
  const Approach way = way_in(signal, range);
  check_contact(signal, way, file);
  const ContactEstimate contact = contact_of(signal, way, settings, raw, out.estimator);
  double correlation = 0;
  take_off_bias(signal, way, contact, settings, out, correlation);
  out.contact_travel_m = contact.travel_m, out.contact_deviation_m = contact.deviation_m;
  out.contact_m = raw.contact_m;
  if (!signal.is_axial && !raw.contact_m)
    out.contact_m = contact_position(signal, way, contact.travel_m);

  const RowRange back = retract_after(signal, phases, range);
  out.hysteresis = hysteresis_of(signal, way, back, contact.travel_m);
  out.speed_m_s = speed_of(signal, way, contact.travel_m);
  if (settings.uses_retract && back.rows() < 5)
    throw Error(place(file, signal, signal.rows() - 1), "has no way back",
                "Say use = \"approach\".");
  const RowRange used = settings.kind == ExperimentKind::press
                            ? (settings.uses_retract ? back : range)
                            : RowRange{range.begin, settings.kind == ExperimentKind::drag
                                                        ? end_of_drag(signal, phases, range)
                                                        : signal.rows()};
  take_rows(signal, used, contact.travel_m, settings, correlation, out);
  if (out.deflection_m.rows() < 3)
    throw Error(place(file, signal, range.end - 1),
                "has " + std::to_string(out.deflection_m.rows()) + " rows in contact",
                "Press deeper, or record more rows.");
  const double saturated = saturated_share(out);
  if (saturated > kMostSaturated)
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
