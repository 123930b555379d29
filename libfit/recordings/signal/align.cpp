#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "libfit/core/text.hpp"
#include "libfit/recordings/signal/signal.hpp"

namespace palpate::recordings {
namespace {

constexpr Eigen::Index kMinRows = 5;
constexpr Eigen::Index kStuckRows = 5;  // equal readings in a row that chance does not make
constexpr double kCoarse = 2e-3;        // of the force's range: a larger step is a coarse sensor
constexpr double kExtremeShare = 0.02;  // likewise, within which a reading is the largest
constexpr double kStuckTravelShare = 0.03;  // of the whole travel, gone while the force stood still
constexpr double kFreeTravelShare = 0.05;
constexpr double kMostOfWay = 0.9;
constexpr double kSinkingSpeed = 0.5;  // as of creep in timed_press.cpp

// Rows whose time is later than that of all rows kept before.
std::vector<Eigen::Index> rows_in_time(const std::vector<double>& time_s,
                                       const std::vector<std::size_t>& line,
                                       const std::string& file, bool drop_invalid,
                                       std::size_t& dropped) {
  std::vector<Eigen::Index> rows;
  for (std::size_t i = 0; i < time_s.size(); ++i) {
    if (!rows.empty() && !(time_s[i] > time_s[rows.back()])) {
      if (!drop_invalid)
        throw Error(file_line(file, line[std::min(i, line.size() - 1)]),
                    time_s[i] == time_s[rows.back()] ? "the time stamp repeats" : "time goes back",
                    "Sort the rows by time and remove double ones, or import with --drop-invalid "
                    "to skip and count them.");
      ++dropped;
      continue;
    }
    rows.push_back(static_cast<Eigen::Index>(i));
  }
  return rows;
}

template <class T>
std::vector<T> picked(const std::vector<T>& from, const std::vector<Eigen::Index>& rows) {
  std::vector<T> out;
  for (const Eigen::Index row : rows) out.push_back(from[row]);
  return out;
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
    kept.push_back(static_cast<Eigen::Index>(i));
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
  while (rows < most &&
         (position_m.row(rows) - position_m.row(0)).norm() < kFreeTravelShare * range_m)
    ++rows;
  return rows;
}

// Whether the tip goes much slower over these rows, until it has gone most of its way in them, than
// since the force (times sign) was half of that there: a force that is held, of a body that creeps.
bool is_sinking(const Signal& signal, const Eigen::VectorXd& force, double half_N, double sign,
                Eigen::Index first, Eigen::Index last) {
  if (signal.time_s.empty()) return false;
  const auto way_m = [&](Eigen::Index a, Eigen::Index b) {
    return (signal.position_m.row(b) - signal.position_m.row(a)).norm();
  };
  const auto speed = [&](Eigen::Index a, Eigen::Index b) {
    return way_m(a, b) / (signal.time_s[b] - signal.time_s[a]);
  };
  double most_m = 0;
  for (Eigen::Index i = first + 1; i < last; ++i) most_m = std::max(most_m, way_m(first, i));
  Eigen::Index gone = first + 1, half = first;
  while (way_m(first, gone) < kMostOfWay * most_m) ++gone;
  while (half > 0 && sign * force[half] > sign * half_N) --half;
  return half < first && speed(first, gone) < kSinkingSpeed * speed(half, first);
}

// Readings stuck at one value, on the far half of what an axis feels, with the tip moving
// meanwhile: the near half holds the free part. A coarse sensor stands still on the way, too; of it
// only its largest value counts.
void mark_stuck(Signal& signal, const Eigen::VectorXd& force, double range_m) {
  const double first_N = force.head(free_rows(signal.position_m, range_m)).mean(),
               up = force.maxCoeff() - first_N, down = first_N - force.minCoeff();
  const double sign = up >= down ? 1 : -1, max_N = std::max(up, down);
  const double min_N = (quantum_of(force) > kCoarse * max_N ? 1 - kExtremeShare : 0.5) * max_N;
  for (Eigen::Index first = 0, last = 0; first < force.size(); first = last) {
    for (last = first + 1; last < force.size() && force[last] == force[first]; ++last) {
    }
    if (last - first < kStuckRows || sign * (force[first] - first_N) <= min_N) continue;
    const auto run = signal.position_m.middleRows(first, last - first);
    if ((run.colwise().maxCoeff() - run.colwise().minCoeff()).norm() >
            kStuckTravelShare * range_m &&
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

// Positions, forces and torques at common times, of rows whose time rises.
void put_in_time(const importers::RawRecording& raw, double force_delay_s, const std::string& file,
                 bool drop_invalid, std::size_t& dropped, Points force_N, Points torque_Nm,
                 Signal& signal) {
  const auto rows = rows_in_time(signal.time_s, raw.line, file, drop_invalid, dropped);
  const bool has_own_clock = !raw.force_time_s.empty();
  signal.position_m = signal.position_m(rows, Eigen::all).eval();
  signal.time_s = picked(signal.time_s, rows);
  signal.line = picked(signal.line, rows);
  std::vector<double> force_time_s = has_own_clock ? raw.force_time_s : signal.time_s;
  const auto force_rows =
      has_own_clock ? rows_in_time(force_time_s, raw.line, file, drop_invalid, dropped) : rows;
  if (has_own_clock) force_time_s = picked(force_time_s, force_rows);
  force_N = force_N(force_rows, Eigen::all).eval();
  if (torque_Nm.rows() > 0) torque_Nm = torque_Nm(force_rows, Eigen::all).eval();
  for (double& t : force_time_s) t -= force_delay_s;
  check_rows(signal, file);
  if (has_own_clock || force_delay_s != 0) {
    interpolate(signal, force_time_s, force_N, torque_Nm);
    return;
  }
  signal.force_N = std::move(force_N);
  signal.torque_Nm = std::move(torque_Nm);
}

}  // namespace

Signal align(const importers::RawRecording& raw, const SensorSettings& settings,
             const std::optional<Vec3>& inward, const std::string& file, bool drop_invalid,
             std::size_t& dropped) {
  Signal signal;
  signal.is_axial = raw.is_axial();
  signal.position_m = raw.is_axial() ? along_first_axis(raw.travel_m) : raw.position_m;
  signal.time_s = raw.time_s;
  signal.line = raw.line;
  signal.retract_begins = raw.retract_begins;
  if (raw.torque_Nm.rows() > 0 && raw.is_axial())
    throw Error(file, "has a torque of three axes and a depth of one",
                "Name `position` columns, or leave the torque out.");
  const bool has_force = raw.force_N.rows() > 0 || !raw.push_N.empty();
  if (signal.position_m.rows() == 0 || !has_force)
    throw Error(file,
                "names no " + std::string(has_force ? "depth or position" : "force") + " column",
                "Add it to `columns` in the manifest.");
  check_rows(signal, file);
  if (!raw.is_axial() && inward) signal.inward = *inward;
  Points force_N = forces_of(raw, inward, file);
  if (!signal.time_s.empty()) {
    put_in_time(raw, settings.force_delay_s, file, drop_invalid, dropped, std::move(force_N),
                raw.torque_Nm, signal);
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

}  // namespace palpate::recordings
