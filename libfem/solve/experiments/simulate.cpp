#include "libfem/solve/experiments/simulate.hpp"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>
#include <optional>

#include "libfit/core/error.hpp"

namespace palpate::fem {
namespace {

/// A row with the numbers it has in Samples.
struct SampleRow {
  std::int32_t point, experiment;
  PointRow row;
};

SampleRow row_of(const Samples& samples, Eigen::Index i) {
  const auto at = static_cast<std::size_t>(i);
  PointRow row;
  row.kind = samples.kind[i];
  row.step = samples.step[i];
  row.deflection = samples.deflection.row(i);
  row.force = samples.force.row(i);
  row.torque = samples.torque.row(i);
  row.force_error = samples.force_error[i];
  row.status = samples.status[i];
  if (!samples.step_check.empty()) row.step_check = samples.step_check[i];
  if (samples.point_sway.rows() > 0)
    row.sway_m_N = symmetric_of(samples.point_sway.row(samples.point[at]));
  if (samples.point_scale.size() > 0) row.scale = samples.point_scale[samples.point[at]];
  if (samples.time_s.size() > 0) row.time_s = samples.time_s[i];
  if (samples.lean.rows() > 0) row.lean = samples.lean.row(i);
  if (samples.second_force.rows() > 0) {
    row.second_deflection = samples.second_deflection.row(i);
    row.second_force = samples.second_force.row(i);
  }
  if (samples.surface.rows() > 0) row.surface = samples.surface.row(i);
  return {samples.point[i], samples.experiment[i], row};
}

Samples gather(const Simulator& simulator, const TestPoints& points,
               const std::vector<std::vector<SampleRow>>& items) {
  Samples out;
  out.point_position = points.position;
  out.point_normal = points.normal;
  out.point_name = points.name;
  out.point_normal_gradient.resize(points.position.rows(), 9);
  for (Eigen::Index p = 0; p < points.position.rows(); ++p) {
    const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> gradient =
        simulator.normal_gradient(points.position.row(p), points.normal.row(p));
    out.point_normal_gradient.row(p) =
        Eigen::Map<const Eigen::Matrix<double, 1, 9>>(gradient.data());
  }
  out.point_sway.setZero(points.position.rows(), 6);
  out.point_scale.setZero(points.position.rows());
  Eigen::Index rows = 0;
  for (const auto& item : items) rows += static_cast<Eigen::Index>(item.size());
  out.deflection.resize(rows, 3);
  out.force.resize(rows, 3);
  out.torque.resize(rows, 3);
  out.force_error.resize(rows);
  if (simulator.setup().keeps_surface)
    out.surface.setZero(rows, 3 * simulator.setup().surface.vertices.rows());
  const bool is_in_time = std::ranges::any_of(
      items, [](const auto& item) { return !item.empty() && !std::isnan(item[0].row.time_s); });
  if (is_in_time) out.time_s.resize(rows);
  const bool leans = std::ranges::any_of(
      items, [](const auto& item) { return !item.empty() && !item[0].row.lean.isZero(); });
  if (leans) out.lean.resize(rows, 2);
  const auto is_of_two = [](const SampleRow& sample) {
    return !sample.row.second_deflection.isZero();
  };
  const bool has_second = std::ranges::any_of(
      items, [&](const auto& item) { return std::ranges::any_of(item, is_of_two); });
  if (has_second) {
    out.second_deflection.resize(rows, 3);
    out.second_force.resize(rows, 3);
  }
  Eigen::Index i = 0;
  for (const auto& item : items)
    for (const SampleRow& sample : item) {
      if (is_in_time) out.time_s[i] = sample.row.time_s;
      if (leans) out.lean.row(i) = sample.row.lean.transpose();
      if (has_second) {
        out.second_deflection.row(i) = sample.row.second_deflection.transpose();
        out.second_force.row(i) = sample.row.second_force.transpose();
      }
      out.point.push_back(sample.point);
      out.experiment.push_back(sample.experiment);
      out.kind.push_back(sample.row.kind);
      out.step.push_back(sample.row.step);
      out.status.push_back(sample.row.status);
      out.step_check.push_back(sample.row.step_check);
      out.deflection.row(i) = sample.row.deflection.transpose();
      out.force.row(i) = sample.row.force.transpose();
      out.torque.row(i) = sample.row.torque.transpose();
      out.force_error[i] = sample.row.force_error;
      out.point_sway.row(sample.point) = numbers_of(sample.row.sway_m_N);
      out.point_scale[sample.point] = sample.row.scale;
      if (sample.row.surface.size() > 0 && out.surface.rows() > 0)
        out.surface.row(i) = sample.row.surface.transpose();
      ++i;
    }
  return out;
}

/// Rows of a press on one mesh as those on two are expected to be.
PointRows scaled(PointRows pressed, double number, const QuickScale& quick) {
  for (PointRow& row : pressed.rows) {
    row.scale = number;
    if (!is_solved(row.status) || !quick) {
      row.force_error = std::numeric_limits<double>::quiet_NaN();
      continue;
    }
    const double factor = quick.factor(row.step, row.force.norm());
    row.force *= factor;
    row.torque *= factor;
    row.force_error = factor * row.force_error + quick.step(row.step).error * row.force.norm();
  }
  return pressed;
}

/// Runs items that have no rows yet, each by `work`, on `jobs` threads; returns early when stopped.
/// `number` gives a row its experiment number.
template <class Work, class Number>
void run_items(std::vector<std::vector<SampleRow>>& items,
               const std::vector<std::int32_t>& point_of, int jobs, const Work& work,
               const Number& number, const std::function<Samples()>& so_far,
               const OnePointDone& on_done, const Progress& progress) {
  std::mutex reporting;
  std::size_t done = 0;
  for (const auto& item : items) done += !item.empty();
  const auto one = [&](std::size_t i) {
    if (!items[i].empty() || progress.stopped()) return;
    const PointRows result = work(i);
    if (!result.is_complete) return;
    const std::lock_guard<std::mutex> lock(reporting);
    for (const PointRow& row : result.rows) items[i].push_back({point_of[i], number(i, row), row});
    if (on_done) on_done(so_far);
    progress.report(++done, items.size(), "test point " + std::to_string(point_of[i] + 1));
  };
  tbb::task_arena arena(jobs > 0 ? jobs : tbb::task_arena::automatic);
  // Grain 1: points take seconds each.
  arena.execute([&] {
    tbb::parallel_for(
        tbb::blocked_range<std::size_t>(0, items.size(), 1),
        [&](const tbb::blocked_range<std::size_t>& range) {
          for (std::size_t i = range.begin(); i < range.end(); ++i) one(i);
        },
        tbb::simple_partitioner());
  });
}

}  // namespace

Samples simulate(const Simulator& simulator, const TestPoints& points,
                 const Experiments& experiments, const SimulateOptions& options,
                 const OnePointDone& on_done, const Progress& progress) {
  const auto count = static_cast<std::size_t>(points.position.rows());
  std::vector<std::vector<SampleRow>> items(count);
  std::vector<std::int32_t> point_of(count);
  for (std::size_t p = 0; p < count; ++p) point_of[p] = static_cast<std::int32_t>(p);
  for (Eigen::Index i = 0; i < options.already_done.rows(); ++i) {
    const SampleRow row = row_of(options.already_done, i);
    if (row.point >= 0 && static_cast<std::size_t>(row.point) < count)
      items[row.point].push_back(row);
  }
  const int per_point =
      1 + static_cast<int>(experiments.drag_depths_m.size()) * experiments.drag_directions;
  Experiments press = experiments;
  press.drag_depths_m.clear();
  const auto experiments_at = [&](std::size_t p) {
    const Vec3 position = points.position.row(p), normal = points.normal.row(p);
    const Effort effort = options.effort.empty() ? Effort{true, 0} : options.effort[p];
    if (effort.scale > 0)
      return scaled(simulator.press_quickly(position, normal, experiments, progress), effort.scale,
                    options.quick);
    return simulator.press_and_drag(position, normal, effort.is_dragged ? experiments : press,
                                    progress);
  };
  run_items(
      items, point_of, options.jobs, experiments_at,
      [&](std::size_t p, const PointRow& row) {
        return static_cast<std::int32_t>(p) * per_point + row.experiment;
      },
      [&] { return gather(simulator, points, items); }, on_done, progress);
  return gather(simulator, points, items);
}

Samples simulate_paths(const Simulator& simulator, const TestPoints& points,
                       const std::vector<ToolPath>& paths, const SimulateOptions& options,
                       const OnePointDone& on_done, const Progress& progress) {
  std::vector<std::vector<SampleRow>> items(paths.size());
  std::vector<std::int32_t> point_of;
  for (const ToolPath& path : paths) {
    if (path.point < 0 || path.point >= points.position.rows())
      throw Error("paths",
                  "path names test point " + std::to_string(path.point) + ", which does not exist",
                  "Number test points from 0.");
    point_of.push_back(path.point);
  }
  for (Eigen::Index i = 0; i < options.already_done.rows(); ++i) {
    const SampleRow row = row_of(options.already_done, i);
    if (row.experiment >= 0 && static_cast<std::size_t>(row.experiment) < items.size())
      items[row.experiment].push_back(row);
  }
  run_items(
      items, point_of, options.jobs,
      [&](std::size_t i) {
        return simulator.follow(points.position.row(point_of[i]), points.normal.row(point_of[i]),
                                paths[i], progress);
      },
      [](std::size_t i, const PointRow&) { return static_cast<std::int32_t>(i); },
      [&] { return gather(simulator, points, items); }, on_done, progress);
  return gather(simulator, points, items);
}

}  // namespace palpate::fem
