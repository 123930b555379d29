#include "libfem/solve/experiments/simulate.hpp"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>
#include <utility>

#include "libfit/core/error.hpp"

namespace palpate::fem {
namespace {

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

// Experiments of a list and their rows so far.
class SimulationWork {
 public:
  SimulationWork(const SimulatorOf& simulator, const ExperimentList& list, const Experiments& each,
                 const SimulateOptions& options, const Progress& progress)
      : simulator_(simulator),
        list_(list),
        each_(each),
        options_(options),
        progress_(progress),
        number_(first_numbers(list, experiments_per_point(each))),
        rows_(list.size()) {
    press_ = each;
    press_.drag_depths_m.clear();
    surface_columns_ = options.surface_columns;
    place_at_surface();
    keep(options.already_done);
  }

  std::size_t size() const { return list_.size(); }
  bool is_done(std::size_t i) const { return !rows_[i].empty(); }
  std::string name(std::size_t i) const {
    const Experiment& one = list_.experiments[i];
    return std::string(kExperimentKindNames[static_cast<std::size_t>(one.kind)]) + " at " +
           list_.places.name[static_cast<std::size_t>(one.place)];
  }

  PointRows make(std::size_t i) const {
    const Experiment& one = list_.experiments[i];
    const Simulator& by = simulator_(one);
    const Vec3 position = list_.places.position.row(one.place),
               normal = list_.places.normal.row(one.place);
    if (one.kind != ExperimentKind::press) {
      PointRows out = by.follow(position, normal, one.path, progress_);
      for (PointRow& row : out.rows) row.kind = one.kind;
      return out;
    }
    if (one.effort.scale > 0)
      return scaled(by.press_quickly(position, normal, each_, progress_), one.effort.scale,
                    options_.quick);
    return by.press_and_drag(position, normal, one.effort.is_dragged ? each_ : press_, progress_);
  }
  void take(std::size_t i, std::vector<PointRow> rows) { rows_[i] = std::move(rows); }

  Samples gather() const {
    Samples out = places_;
    Eigen::Index rows = 0;
    for (const auto& item : rows_)
      for (const PointRow& row : item) rows += row.second ? 2 : 1;
    out.deflection.resize(rows, 3);
    out.force.resize(rows, 3);
    out.torque.resize(rows, 3);
    out.force_error.resize(rows);
    out.time_s.resize(rows);
    out.lean.resize(rows, 2);
    if (surface_columns_ > 0) out.surface.setZero(rows, surface_columns_);
    std::vector<char> is_known(static_cast<std::size_t>(out.points()), 0);
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      const Experiment& one = list_.experiments[i];
      for (const PointRow& row : rows_[i]) {
        put(out, row, number_[i], one.place, 0, row.deflection, row.force);
        if (row.second)
          put(out, row, number_[i], one.path.second->place, 1, row.second->deflection,
              row.second->force);
        out.probe_number.resize(out.point.size(), one.probe_number);
      }
      if (rows_[i].empty() || is_known[static_cast<std::size_t>(one.place)]) continue;
      is_known[static_cast<std::size_t>(one.place)] = 1;
      out.point_sway.row(one.place) = numbers_of(rows_[i].back().sway_m_N);
      out.point_scale[one.place] = rows_[i].back().scale;
    }
    leave_out_what_says_nothing(out);
    return out;
  }

 private:
  // Of the probe, which most experiments are made with.
  void place_at_surface() {
    const TestPoints& at = list_.places;
    places_.point_position = at.position;
    places_.point_normal = at.normal;
    places_.point_name = at.name;
    places_.point_normal_gradient.setZero(at.position.rows(), 9);
    places_.point_sway.setZero(at.position.rows(), 6);
    places_.point_scale.setZero(at.position.rows());
    std::vector<char> is_known(static_cast<std::size_t>(at.position.rows()), 0);
    const auto look = [&](const Simulator& by, std::int32_t p) {
      if (std::exchange(is_known[static_cast<std::size_t>(p)], 1)) return;
      const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> gradient =
          by.normal_gradient(at.position.row(p), at.normal.row(p));
      places_.point_normal_gradient.row(p) =
          Eigen::Map<const Eigen::Matrix<double, 1, 9>>(gradient.data());
    };
    for (const Experiment& one : list_.experiments) {
      const Simulator& by = simulator_(one);
      look(by, one.place);
      if (one.path.second) look(by, one.path.second->place);
      if (by.setup().keeps_surface) surface_columns_ = 3 * by.setup().surface.vertices.rows();
    }
  }
  // Rows of an earlier run, which are numbered as ours.
  void keep(const Samples& done) {
    for (Eigen::Index i = 0; i < done.rows(); ++i) {
      const auto r = static_cast<std::size_t>(i);
      const auto after = std::upper_bound(number_.begin(), number_.end(), done.experiment[r]);
      if (after == number_.begin()) continue;
      std::vector<PointRow>& rows = rows_[static_cast<std::size_t>(after - number_.begin()) - 1];
      if (!done.tool.empty() && done.tool[r] > 0) {
        rows.back().second = {done.deflection.row(i), done.force.row(i)};
        continue;
      }
      rows.push_back(row_of(done, i));
      rows.back().experiment = done.experiment[r] - *(after - 1);
    }
  }
  static PointRow row_of(const Samples& samples, Eigen::Index i) {
    const auto at = static_cast<std::size_t>(i);
    PointRow row;
    row.kind = samples.kind[at];
    row.step = samples.step[at];
    row.deflection = samples.deflection.row(i);
    row.force = samples.force.row(i);
    row.torque = samples.torque.row(i);
    row.force_error = samples.force_error[i];
    row.status = samples.status[at];
    if (!samples.step_check.empty()) row.step_check = samples.step_check[at];
    if (samples.point_sway.rows() > 0)
      row.sway_m_N = symmetric_of(samples.point_sway.row(samples.point[at]));
    if (samples.point_scale.size() > 0) row.scale = samples.point_scale[samples.point[at]];
    if (samples.time_s.size() > 0) row.time_s = samples.time_s[i];
    if (samples.lean.rows() > 0) row.lean = samples.lean.row(i);
    if (samples.surface.rows() > 0) row.surface = samples.surface.row(i);
    return row;
  }
  static void put(Samples& out, const PointRow& row, std::int32_t number, std::int32_t place,
                  std::int32_t tool, const Vec3& deflection, const Vec3& force) {
    const auto i = static_cast<Eigen::Index>(out.point.size());
    out.point.push_back(place);
    out.experiment.push_back(number + row.experiment);
    out.kind.push_back(row.kind);
    out.step.push_back(row.step);
    out.tool.push_back(tool);
    out.status.push_back(row.status);
    out.step_check.push_back(row.step_check);
    out.deflection.row(i) = deflection.transpose();
    out.force.row(i) = force.transpose();
    out.torque.row(i) = (tool == 0 ? row.torque : Vec3(Vec3::Zero())).transpose();
    out.force_error[i] = row.force_error;
    out.time_s[i] = row.time_s;
    out.lean.row(i) = row.lean.transpose();
    if (row.surface.size() > 0 && out.surface.rows() > 0)
      out.surface.row(i) = row.surface.transpose();
  }

  const SimulatorOf& simulator_;
  const ExperimentList& list_;
  const Experiments& each_;
  const SimulateOptions& options_;
  const Progress& progress_;
  Experiments press_;
  Samples places_;  // without rows
  Eigen::Index surface_columns_ = 0;
  std::vector<std::int32_t> number_;
  std::vector<std::vector<PointRow>> rows_;
};

}  // namespace

int experiments_per_point(const Experiments& each) {
  return 1 + static_cast<int>(each.drag_depths_m.size()) * each.drag_directions;
}

Samples simulate(const SimulatorOf& simulator, const ExperimentList& list, const Experiments& each,
                 const SimulateOptions& options, const OneDone& on_done, const Progress& progress) {
  SimulationWork work(simulator, list, each, options, progress);
  std::mutex reporting;
  std::size_t done = 0;
  for (std::size_t i = 0; i < work.size(); ++i) done += work.is_done(i);
  const auto one = [&](std::size_t i) {
    if (work.is_done(i) || progress.stopped()) return;
    progress.begin(work.name(i));
    PointRows result = work.make(i);
    progress.end();
    if (!result.is_complete) return;
    const std::lock_guard<std::mutex> lock(reporting);
    work.take(i, std::move(result.rows));
    if (on_done) on_done([&] { return work.gather(); });
    progress.report(++done, work.size(), "experiment " + std::to_string(i + 1));
  };
  tbb::task_arena arena(options.jobs > 0 ? options.jobs : tbb::task_arena::automatic);
  // Grain 1: experiments take seconds each.
  arena.execute([&] {
    tbb::parallel_for(
        tbb::blocked_range<std::size_t>(0, work.size(), 1),
        [&](const tbb::blocked_range<std::size_t>& range) {
          for (std::size_t i = range.begin(); i < range.end(); ++i) one(i);
        },
        tbb::simple_partitioner());
  });
  return work.gather();
}

Samples simulate(const Simulator& simulator, const ExperimentList& list, const Experiments& each,
                 const SimulateOptions& options, const OneDone& on_done, const Progress& progress) {
  return simulate([&](const Experiment&) -> const Simulator& { return simulator; }, list, each,
                  options, on_done, progress);
}

}  // namespace palpate::fem
