#include <fmt/core.h>

#include <algorithm>

#include "libfit/recordings/batch/batch.hpp"

namespace palpate::recordings {
namespace {

using importers::RawRecording;

struct Press {
  RowRange approach;
  Eigen::Index touched = 0;
  double depth_m = 0, free_N = 0, rise_N = 0;
  Vec3 beside_m = Vec3::Zero();  // the mean place in contact, without the travel
};

Points sideways_m(const Signal& signal) {
  return signal.position_m - signal.travel_m() * signal.inward.transpose();
}

std::vector<Press> presses_of(const Signal& signal) {
  const Eigen::VectorXd travel = signal.travel_m(), push = signal.push_N();
  const Points beside = sideways_m(signal);
  const double noise_N = neighbour_scatter(push);
  std::vector<Press> out;
  for (const RowRange& approach : approaches(signal)) {
    Press press{.approach = approach, .touched = approach.end - 1};
    press.free_N =
        push.segment(approach.begin, std::max<Eigen::Index>(1, approach.rows() / 20)).mean();
    press.rise_N = push.segment(approach.begin, approach.rows()).maxCoeff() - press.free_N;
    if (press.rise_N < 10 * noise_N) continue;  // free travel may show less
    // A press begins there within a seventh of its depth.
    while (press.touched > approach.begin &&
           push[press.touched - 1] - press.free_N > 0.05 * press.rise_N)
      --press.touched;
    press.depth_m = travel[approach.end - 1] - travel[press.touched];
    press.beside_m =
        beside.middleRows(press.touched, approach.end - press.touched).colwise().mean();
    out.push_back(press);
  }
  return out;
}

bool is_elsewhere(const Signal& signal, const Press& before, const Press& after) {
  const double least_N =
      signal.push_N()
          .segment(before.approach.end - 1, after.approach.begin - before.approach.end + 2)
          .minCoeff();
  return least_N - before.free_N < 0.1 * before.rise_N &&
         (after.beside_m - before.beside_m).norm() > std::max(before.depth_m, after.depth_m);
}

// The rows beside its presses by no more than a tenth of their depth, and of what a press that
// leans goes sideways until it touches.
RowRange rows_at_place(const Signal& signal, const Press& first, const Press& last,
                       Eigen::Index earliest) {
  const Points beside = sideways_m(signal);
  double noise_m = 0;
  for (int axis = 0; axis < 3; ++axis)
    noise_m = std::max(noise_m, neighbour_scatter(beside.col(axis)));
  const Eigen::VectorXd travel = signal.travel_m();
  const auto is_near = [&](Eigen::Index row, const Press& press) {
    const double free_m = std::max(0.0, travel[press.touched] - travel[row]);
    return (Vec3(beside.row(row)) - press.beside_m).norm() <=
           0.1 * (press.depth_m + free_m) + 5 * noise_m;
  };
  RowRange out{first.touched, last.approach.end};
  while (out.begin > earliest && is_near(out.begin - 1, first)) --out.begin;
  while (out.end < signal.rows() && is_near(out.end, last)) ++out.end;
  return out;
}

// The rows of a file from one line to another.
RawRecording part_of(const RawRecording& raw, std::size_t first_line, std::size_t last_line) {
  const auto begin = std::ranges::lower_bound(raw.line, first_line) - raw.line.begin(),
             end = std::ranges::upper_bound(raw.line, last_line) - raw.line.begin();
  RawRecording out = raw;
  const auto cut = [](auto& values, std::ptrdiff_t from, std::ptrdiff_t to) {
    if (!values.empty()) values = {values.begin() + from, values.begin() + to};
  };
  const auto cut_rows = [](Points& points, std::ptrdiff_t from, std::ptrdiff_t to) {
    if (points.rows() > 0) points = Points(points.middleRows(from, to - from));
  };
  cut(out.line, begin, end), cut(out.time_s, begin, end), cut_rows(out.position_m, begin, end);
  auto force_begin = begin, force_end = end;
  if (!raw.force_time_s.empty() && !out.time_s.empty()) {
    force_begin =
        std::ranges::lower_bound(raw.force_time_s, out.time_s.front()) - raw.force_time_s.begin();
    force_end =
        std::ranges::upper_bound(raw.force_time_s, out.time_s.back()) - raw.force_time_s.begin();
  }
  cut(out.force_time_s, force_begin, force_end), cut(out.push_N, force_begin, force_end);
  cut_rows(out.force_N, force_begin, force_end), cut_rows(out.torque_Nm, force_begin, force_end);
  return out;
}

// Where nobody says it: along the largest force, which pushes the body inward.
std::optional<Vec3> along_force(const RawRecording& raw) {
  if (raw.force_N.rows() == 0) return std::nullopt;
  const Points change = raw.force_N.rowwise() - raw.force_N.row(0);
  Eigen::Index most = 0;
  if (!(change.rowwise().squaredNorm().maxCoeff(&most) > 0)) return std::nullopt;
  return Vec3(change.row(most)).normalized();
}

}  // namespace

std::vector<RawRecording> split_places(const RawRecording& raw, const SignalSettings& settings,
                                       const std::optional<Vec3>& normal) {
  if (settings.kind != ExperimentKind::press || raw.unread || raw.is_axial() || raw.contact_m)
    return {raw};
  const auto inward = normal ? normal : raw.normal ? raw.normal : along_force(raw);
  if (!inward) return {raw};
  Signal signal;
  try {
    signal = align(raw, settings, inward, "");
    signal.phase = find_phases(signal);
  } catch (const Error&) {
    return {raw};
  }
  const std::vector<Press> presses = presses_of(signal);
  std::vector<std::size_t> begins;  // of a place, in presses
  for (std::size_t i = 0; i < presses.size(); ++i)
    if (i == 0 || is_elsewhere(signal, presses[i - 1], presses[i])) begins.push_back(i);
  if (begins.size() < 2) return {raw};
  std::vector<RawRecording> out;
  Eigen::Index earliest = 0;
  for (std::size_t k = 0; k < begins.size(); ++k) {
    const std::size_t last = (k + 1 < begins.size() ? begins[k + 1] : presses.size()) - 1;
    const RowRange rows = rows_at_place(signal, presses[begins[k]], presses[last], earliest);
    earliest = rows.end;
    RawRecording part = part_of(raw, signal.line[rows.begin], signal.line[rows.end - 1]);
    part.name += fmt::format("{}{}", raw.name.empty() ? "" : ".", k + 1);
    part.place =
        fmt::format("place {} of {} that the tool pressed in one recording", k + 1, begins.size());
    part.taken.push_back(part.place);
    out.push_back(std::move(part));
  }
  return out;
}

}  // namespace palpate::recordings
