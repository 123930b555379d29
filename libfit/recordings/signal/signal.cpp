// Readings on one clock, and their picture.

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "libfit/core/text.hpp"
#include "libfit/recordings/signal/signal.hpp"

namespace palpate::recordings {
namespace {

constexpr Eigen::Index kMinRows = 5;  // for a curve; of equal readings, so many are no chance

void check_times(const std::vector<double>& time_s, const std::vector<std::size_t>& line,
                 const std::string& file) {
  for (std::size_t i = 1; i < time_s.size(); ++i)
    if (!(time_s[i] > time_s[i - 1]))
      throw Error(file_line(file, line[std::min(i, line.size() - 1)]),
                  time_s[i] == time_s[i - 1] ? "the time stamp repeats" : "time goes back",
                  "Sort the rows by time and remove double ones.");
}

Points along_first_axis(const std::vector<double>& values) {
  Points points = Points::Zero(values.size(), 3);
  points.col(0) = Eigen::Map<const Eigen::VectorXd>(values.data(), points.rows());
  return points;
}

// Positions at the times of the force, where both clocks run.
void interpolate(Signal& signal, const std::vector<double>& force_time_s, const Points& force_N,
                 const Points& torque_Nm) {
  const Signal before = signal;
  signal.time_s.clear(), signal.line.clear();
  std::vector<Eigen::Index> kept;
  std::vector<Vec3> position;
  std::size_t j = 0;
  for (std::size_t i = 0; i < force_time_s.size(); ++i) {
    const double t = force_time_s[i];
    if (t < before.time_s.front() || t > before.time_s.back()) continue;
    while (j + 2 < before.time_s.size() && before.time_s[j + 1] < t) ++j;
    const double share = (t - before.time_s[j]) / (before.time_s[j + 1] - before.time_s[j]);
    const Eigen::Index row = j;
    position.push_back((1 - share) * before.position_m.row(row) +
                       share * before.position_m.row(row + 1));
    kept.push_back(i);
    signal.time_s.push_back(t);
    signal.line.push_back(before.line[j]);
  }
  signal.position_m.resize(position.size(), 3);
  for (std::size_t i = 0; i < position.size(); ++i) signal.position_m.row(i) = position[i];
  signal.force_N = force_N(kept, Eigen::all);
  if (torque_Nm.rows() > 0) signal.torque_Nm = torque_Nm(kept, Eigen::all);
}

// A twentieth of the rows, or those before the tip has gone a twentieth of its range: before a long
// hold the free part is shorter.
Eigen::Index free_rows(const Points& position_m, double range_m) {
  const Eigen::Index most = std::max<Eigen::Index>(1, position_m.rows() / 20);
  Eigen::Index rows = 1;
  while (rows < most && (position_m.row(rows) - position_m.row(0)).norm() < 0.05 * range_m) ++rows;
  return rows;
}

// True if the tip goes half as fast or less over these rows, until it has gone 90 % of its path in
// them, as since the force (times sign) was half of that there: a force that is held, of a body
// that creeps.
bool is_sinking(const Signal& signal, const Eigen::VectorXd& force, double half_N, double sign,
                Eigen::Index first, Eigen::Index last) {
  if (signal.time_s.empty()) return false;
  const auto path_m = [&](Eigen::Index a, Eigen::Index b) {
    return (signal.position_m.row(b) - signal.position_m.row(a)).norm();
  };
  const auto speed = [&](Eigen::Index a, Eigen::Index b) {
    return path_m(a, b) / (signal.time_s[b] - signal.time_s[a]);
  };
  double most_m = 0;
  for (Eigen::Index i = first + 1; i < last; ++i) most_m = std::max(most_m, path_m(first, i));
  Eigen::Index gone = first + 1, half = first;
  while (path_m(first, gone) < 0.9 * most_m) ++gone;
  while (half > 0 && sign * force[half] > sign * half_N) --half;
  return half < first && speed(first, gone) < 0.5 * speed(half, first);
}

// Readings stuck at one value, on the far half of what an axis feels, with the tip moving
// meanwhile: the near half holds the free part. A coarse sensor, whose step is above 0.2 % of its
// range, stands still on the path, too; of it only its largest value counts.
void mark_stuck(Signal& signal, const Eigen::VectorXd& force, double range_m) {
  const double first_N = force.head(free_rows(signal.position_m, range_m)).mean(),
               up = force.maxCoeff() - first_N, down = first_N - force.minCoeff();
  const double sign = up >= down ? 1 : -1, max_N = std::max(up, down);
  const double min_N = (quantum_of(force) > 2e-3 * max_N ? 1 - 0.02 : 0.5) * max_N;
  for (Eigen::Index first = 0, last = 0; first < force.size(); first = last) {
    for (last = first + 1; last < force.size() && force[last] == force[first]; ++last) {
    }
    if (last - first < kMinRows || sign * (force[first] - first_N) <= min_N) continue;
    const auto run = signal.position_m.middleRows(first, last - first);
    if ((run.colwise().maxCoeff() - run.colwise().minCoeff()).norm() > 0.03 * range_m &&
        !is_sinking(signal, force, (force[first] + first_N) / 2, sign, first, last))
      std::fill(signal.is_saturated.begin() + first, signal.is_saturated.begin() + last, 1);
  }
}

void mark_saturated(Signal& signal, double force_limit_N) {
  signal.is_saturated.assign(signal.rows(), 0);
  const double range_m =
      (signal.position_m.colwise().maxCoeff() - signal.position_m.colwise().minCoeff()).norm();
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::VectorXd force = signal.force_N.col(axis);
    mark_stuck(signal, force, range_m);
    for (Eigen::Index i = 0; i < force.size(); ++i)
      if (std::abs(force[i]) >= force_limit_N) signal.is_saturated[i] = 1;
  }
}

void check_rows(const Signal& signal, const std::string& file) {
  if (signal.rows() >= kMinRows) return;
  throw Error(file_line(file, signal.line.empty() ? 1 : signal.line.front()),
              fmt::format("has {}{}, too few for a curve", signal.rows(),
                          signal.rows() == 1 ? " sample" : " samples"),
              fmt::format("Record at least {} rows.", kMinRows));
}

// Forces of three axes; of a travel of one axis, along it.
Points forces_of(const importers::RawRecording& raw, const std::optional<Vec3>& inward,
                 const std::string& file) {
  const bool has_axes = raw.force_N.rows() > 0;
  if (has_axes != raw.is_axial()) return has_axes ? raw.force_N : along_first_axis(raw.push_N);
  if (!inward && has_axes)
    throw Error(file, "has a depth of one axis and a force of three",
                "Say `normal`, or name one force column.");
  if (!inward)
    throw Error(file, "has one force column and positions of three axes",
                "Say `normal`: the force is taken along it.");
  if (!has_axes) return along_first_axis(raw.push_N).col(0) * inward->transpose();
  const Eigen::VectorXd push_N = raw.force_N * *inward;
  return along_first_axis({push_N.begin(), push_N.end()});
}

// Positions, forces and torques at common times, which rise.
void put_in_time(const importers::RawRecording& raw, double force_delay_s, const std::string& file,
                 Points force_N, Points torque_Nm, Signal& signal) {
  check_times(signal.time_s, raw.line, file);
  check_times(raw.force_time_s, raw.line, file);
  const bool has_own_clock = !raw.force_time_s.empty();
  std::vector<double> force_time_s = has_own_clock ? raw.force_time_s : signal.time_s;
  for (double& t : force_time_s) t -= force_delay_s;
  if (has_own_clock || force_delay_s != 0) {
    interpolate(signal, force_time_s, force_N, torque_Nm);
    return;
  }
  signal.force_N = std::move(force_N);
  signal.torque_Nm = std::move(torque_Nm);
}

// About `count` of the rows [begin, end), equally spaced, the last among them.
void spread(Eigen::Index begin, Eigen::Index end, Eigen::Index count,
            std::set<Eigen::Index>& rows) {
  const Eigen::Index last = end - 1 - begin, steps = std::min(count - 1, last);
  for (Eigen::Index k = 0; k <= steps; ++k)
    rows.insert(begin + (steps > 0 ? last * k / steps : last));
}

std::set<Eigen::Index> rows_shown(const Signal& signal) {
  std::set<Eigen::Index> rows;
  const Eigen::VectorXd &travel_m = signal.recorded_travel_m, &push_N = signal.recorded_push_N;
  const Eigen::Index n = push_N.size(), most = 198;  // a picture is 400 points wide
  const RowRange& in = signal.range.loading;
  const bool has_press = signal.bias_N.size() > 0 && in.rows() > 1 && n > most;
  spread(0, n, has_press ? most / 2 : most, rows);
  if (has_press) {
    const double deepest_m = travel_m[in.end - 1],
                 from_m = signal.contact_m - (deepest_m - signal.contact_m);
    Eigen::Index begin = in.end - 1;
    while (begin > in.begin && travel_m[begin - 1] >= from_m) --begin;
    spread(begin, in.end, most / 2, rows);
  }
  Eigen::Index row = 0;
  for (const Eigen::VectorXd* column : {&push_N, &travel_m}) {
    column->maxCoeff(&row);
    rows.insert(row);
  }
  return rows;
}

}  // namespace

Signal align(const importers::RawRecording& raw, const SignalSettings& settings,
             const std::optional<Vec3>& inward, const std::string& file) {
  Signal signal;
  signal.is_axial = raw.is_axial();
  signal.position_m = raw.is_axial() ? along_first_axis(raw.travel_m) : raw.position_m;
  signal.time_s = raw.time_s;
  signal.line = raw.line;
  if (raw.torque_Nm.rows() > 0 && raw.is_axial())
    throw Error(file, "has a torque of three axes and a depth of one",
                "Name `position` columns, or leave the torque out.");
  check_rows(signal, file);
  if (!raw.is_axial() && inward) signal.inward = *inward;
  Points force_N = forces_of(raw, inward, file);
  if (!signal.time_s.empty()) {
    put_in_time(raw, settings.force_delay_s, file, std::move(force_N), raw.torque_Nm, signal);
  } else {
    if (settings.force_delay_s != 0)
      throw Error(file, "has no time, so a force delay cannot be taken off",
                  "Name the time column, or leave out `force_delay`.");
    signal.force_N = std::move(force_N);
    signal.torque_Nm = raw.torque_Nm;
  }
  check_rows(signal, file);
  mark_saturated(signal, settings.force_limit_N);
  const Vec3 first = signal.force_N.row(0);
  signal.position_m -= settings.compliance_m_N * (signal.force_N.rowwise() - first.transpose());
  return signal;
}

SignalTrace trace_of(const Signal& signal) {
  SignalTrace trace;
  const Eigen::VectorXd &travel_m = signal.recorded_travel_m, &push_N = signal.recorded_push_N;
  if (push_N.size() == 0) return trace;
  for (const Eigen::Index row : rows_shown(signal)) {
    trace.time_s.push_back(signal.time_s.empty()
                               ? std::numeric_limits<float>::quiet_NaN()
                               : static_cast<float>(signal.time_s[row] - signal.time_s[0]));
    trace.travel_m.push_back(static_cast<float>(travel_m[row]));
    trace.push_N.push_back(static_cast<float>(push_N[row]));
    trace.phase.push_back(signal.phase.empty() ? std::int8_t{4}
                                               : static_cast<std::int8_t>(signal.phase[row]));
    trace.is_used.push_back(std::ranges::any_of(signal.range.used, [&](const RowRange& range) {
      return row >= range.begin && row < range.end;
    }));
  }
  if (signal.bias_N.size() == 0) return trace;
  Eigen::Index low = 0, high = 0;  // a line over travel
  const double range_m = travel_m.maxCoeff(&high) - travel_m.minCoeff(&low);
  if (range_m > 0) trace.drift_N_m = (signal.bias_N[high] - signal.bias_N[low]) / range_m;
  trace.bias_N = signal.bias_N[low] - trace.drift_N_m * travel_m[low];
  return trace;
}

}  // namespace palpate::recordings
