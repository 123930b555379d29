#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "libfit/core/text.hpp"
#include "libfit/recordings/batch/batch.hpp"

// Ranges of a signal, and rows of their readings.

namespace palpate::recordings {
namespace {

// Push over the deepest part of an approach that all of them reach, above where it begins.
double push_at_depth_N(const Signal& signal, const RowRange& approach, double from_m, double to_m) {
  const Eigen::VectorXd travel = signal.travel_m(), push = signal.push_N();
  const Eigen::Index free = std::max<Eigen::Index>(1, approach.rows() / 20);
  double sum = 0, n = 0;
  for (Eigen::Index i = approach.begin; i < approach.end; ++i)
    if (travel[i] >= from_m && travel[i] <= to_m) sum += push[i], n += 1;
  return n > 0 ? sum / n - push.segment(approach.begin, free).mean() : kNan;
}

// The press that the settings ask for, of those that go as deep, and a word on there being others.
RowRange chosen_cycle(const Signal& signal, const RowRange& main, const SignalSettings& settings,
                      const std::string& file, Conditioned& out) {
  const std::vector<RowRange> presses = presses_like(signal, main);
  const auto count = static_cast<int>(presses.size());
  if (settings.cycle > std::max(1, count))
    throw Error(file,
                fmt::format("holds {} as deep as its deepest, and cycle = {} is asked for",
                            counted(count, "press", "presses"), settings.cycle),
                "Say cycle = \"first\", \"last\" or a number that is there.");
  if (count < 2) return main;
  std::size_t taken = settings.cycle > 0 ? settings.cycle - 1 : presses.size() - 1;
  if (settings.cycle == kDeepestCycle)
    taken = std::ranges::find(presses, main.begin, &RowRange::begin) - presses.begin();
  if (taken >= presses.size()) return main;
  const Eigen::VectorXd travel = signal.travel_m();
  double reach_m = travel[main.end - 1];
  for (const RowRange& approach : presses) reach_m = std::min(reach_m, travel[approach.end - 1]);
  const double from_m = reach_m - 0.1 * (reach_m - travel[main.begin]),
               first_N = push_at_depth_N(signal, presses.front(), from_m, reach_m),
               last_N = push_at_depth_N(signal, presses.back(), from_m, reach_m),
               change = last_N / first_N - 1;
  std::string note = fmt::format("holds {} as deep; number {} is taken",
                                 counted(count, "press", "presses"), taken + 1);
  if (std::isfinite(change) && std::abs(change) > 0.1) {  // cycles of a good recording differ less
    note += fmt::format(", and the last is {} {} than the first", percent(std::abs(change), 0),
                        change < 0 ? "softer" : "stiffer");
    out.grade = std::max(out.grade, Grade::fair);
  }
  out.reasons.push_back(note);
  return presses[taken];
}

// The abscissa of each signal row: depth, or length of the path since contact.
Eigen::VectorXd abscissa(const Signal& signal, const RowRange& used, Eigen::Index touched,
                         double contact_travel_m, bool is_press) {
  if (is_press)
    return signal.travel_m().segment(used.begin, used.rows()).array() - contact_travel_m;
  Eigen::VectorXd at = Eigen::VectorXd::Constant(used.rows(), -1);
  // Path of the tip, in strides of a hundredth of its range so that noise does not lengthen it.
  const auto part = signal.position_m.middleRows(used.begin, used.rows());
  const double stride_m = 0.01 * (part.colwise().maxCoeff() - part.colwise().minCoeff()).norm();
  double path_m = 0;
  Vec3 last = part.row(touched);
  for (Eigen::Index i = touched; i < used.rows(); ++i) {
    const double step_m = (Vec3(part.row(i)) - last).norm();
    at[i] = path_m + step_m;
    if (step_m > stride_m) {
      path_m += step_m;
      last = part.row(i);
    }
  }
  return at;
}

// Error of a mean of `count` readings, of which neighbours correlate.
double error_of_mean_N(double noise_N, double count, double correlation) {
  return noise_N / std::sqrt(std::max(1.0, count * (1 - correlation) / (1 + correlation)));
}

// Every reading from the approach on, up to where the tool breaks in; the time of the first is what
// a tool takes to come to a pass (libfit/experiments/follow.cpp), of all NaN without a clock.
void take_readings(const Signal& signal, const Vec3& contact_m, Conditioned& out) {
  const Eigen::Index first = signal.range.approach.begin,
                     end = signal.range.break_in.value_or(signal.rows() - 1) + 1,
                     rows = end - first;
  out.deflection_m = signal.position_m.middleRows(first, rows).rowwise() - contact_m.transpose();
  out.force_N = signal.force_N.middleRows(first, rows);
  out.error_N = Eigen::VectorXd::Constant(rows, out.noise_N);
  out.time_s = Eigen::VectorXd::Constant(rows, kNan);
  for (Eigen::Index i = 0; i < rows; ++i) {
    if (!signal.time_s.empty())
      out.time_s[i] = 0.25 + signal.time_s[first + i] - signal.time_s[first];
    out.status.push_back(signal.is_saturated[first + i] ? RowStatus::rejected : RowStatus::good);
  }
}

// The approach without its last rows where the force falls already: a soft sensor springs back
// before the tip does.
RowRange loading_part(const Signal& signal, RowRange range) {
  const Eigen::VectorXd travel = signal.travel_m().segment(range.begin, range.rows());
  Eigen::Index most = 0;
  signal.push_N().segment(range.begin, range.rows()).maxCoeff(&most);
  if (travel[most] > travel.maxCoeff() - 0.1 * (travel.maxCoeff() - travel.minCoeff()))
    range.end = range.begin + most + 1;
  return range;
}

}  // namespace

void find_ranges(const SignalSettings& settings, const std::string& file, Signal& signal,
                 Conditioned& recording) {
  SignalRanges& out = signal.range;
  const bool is_press = settings.kind == ExperimentKind::press;
  const bool presses_once = is_press && settings.use == Use::approach;
  if (!is_press && (settings.use == Use::mean || settings.cycle != kDeepestCycle))
    throw Error(file, "`cycle` is for presses", "Leave it out, or say kind = \"press\".");
  RowRange& approach = out.approach;
  approach = main_approach(signal);
  if (presses_once && approach.rows() >= 2)
    approach = chosen_cycle(signal, approach, settings, file, recording);
  if (presses_once) out.break_in = break_in_row(signal, approach);
  // Beyond it there is no curve of the body.
  if (out.break_in) approach.end = std::min(approach.end, *out.break_in + 1);
  out.loading =
      approach.rows() >= 2 && is_press && !out.break_in ? loading_part(signal, approach) : approach;
  if (out.loading.rows() < 2)
    throw Error(place(file, signal, 0), "the tip never goes in",
                "Check the normal, or turn the depth around: depth = \"-NAME\".");
}

void take_rows(const Signal& signal, const SignalSettings& settings, Conditioned& out) {
  const RowRange& used = signal.range.used.back();
  const double contact_travel_m = signal.contact_m;
  const bool is_press = settings.kind == ExperimentKind::press;
  const Eigen::VectorXd travel = signal.travel_m().segment(used.begin, used.rows());
  Eigen::Index touched = 0;
  while (touched + 1 < travel.size() && travel[touched] < contact_travel_m) ++touched;
  const Eigen::VectorXd at = abscissa(signal, used, touched, contact_travel_m, is_press);
  const double most = at.maxCoeff();
  const Vec3 contact =
      signal.is_axial || !out.contact_m ? Vec3(contact_travel_m * signal.inward) : *out.contact_m;
  if (settings.is_pass) return take_readings(signal, contact, out);

  struct RowMean {
    Vec3 deflection = Vec3::Zero(), force = Vec3::Zero(), torque = Vec3::Zero();
    double count = 0, time_s = 0;
    bool is_saturated = false;
  };
  std::vector<RowMean> means(std::max(1, settings.rows));
  const auto add = [&](Eigen::Index row, double where) {
    if (!(where > 0) || where > most || signal.is_spike[row]) return;
    RowMean& mean = means[std::min<std::size_t>(means.size() - 1,
                                                where / most * static_cast<double>(means.size()))];
    mean.deflection += Vec3(signal.position_m.row(row)) - contact;
    mean.force += signal.force_N.row(row);
    if (signal.torque_Nm.rows() > 0) mean.torque += signal.torque_Nm.row(row);
    mean.count += 1;
    if (!signal.time_s.empty()) mean.time_s += signal.time_s[row];
    mean.is_saturated |= signal.is_saturated[row] != 0;
  };
  for (Eigen::Index i = 0; i < used.rows(); ++i) add(used.begin + i, at[i]);
  for (std::size_t k = 0; k + 1 < signal.range.used.size(); ++k)
    for (Eigen::Index row = signal.range.used[k].begin; row < signal.range.used[k].end; ++row)
      add(row, signal.position_m.row(row).dot(signal.inward) - contact_travel_m);
  std::erase_if(means, [](const RowMean& mean) { return mean.count == 0; });
  const Eigen::Index rows = means.size();
  out.deflection_m.resize(rows, 3), out.force_N.resize(rows, 3), out.error_N.resize(rows);
  out.time_s.resize(signal.time_s.empty() ? 0 : rows);
  out.torque_Nm.resize(signal.torque_Nm.rows() > 0 ? rows : 0, 3);
  for (Eigen::Index i = 0; i < rows; ++i) {
    const RowMean& mean = means[i];
    out.deflection_m.row(i) = mean.deflection / mean.count;
    out.force_N.row(i) = mean.force / mean.count;
    if (out.torque_Nm.rows() > 0) out.torque_Nm.row(i) = mean.torque / mean.count;
    if (out.time_s.size() > 0)
      out.time_s[i] = mean.time_s / mean.count - signal.time_s[used.begin + touched];
    out.error_N[i] = error_of_mean_N(out.noise_N, mean.count, signal.correlation);
    out.status.push_back(mean.is_saturated ? RowStatus::rejected : RowStatus::good);
  }
}

}  // namespace palpate::recordings
