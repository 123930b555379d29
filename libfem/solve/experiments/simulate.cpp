#include "libfem/solve/experiments/simulate.hpp"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>
#include <utility>
#include <vector>

#include "libfit/core/linear_algebra.hpp"
#include "libfit/core/statistics.hpp"

namespace palpate::fem {
namespace {

/// Rows of a press on one mesh as those on two are expected to be.
PointRows scaled(PointRows pressed, double number, const QuickScale& quick) {
  pressed.scale = number;
  for (Eigen::Index row = 0; row < pressed.rows(); ++row) {
    if (!is_solved(pressed.status[row]) || !quick) {
      pressed.force_error[row] = std::numeric_limits<double>::quiet_NaN();
      continue;
    }
    const double factor = quick.factor(pressed.step[row], pressed.force.row(row).norm());
    pressed.force.row(row) *= factor;
    pressed.torque.row(row) *= factor;
    pressed.force_error[row] = factor * pressed.force_error[row] +
                               quick.step(pressed.step[row]).error * pressed.force.row(row).norm();
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
  bool is_done(std::size_t i) const { return rows_[i].rows() > 0; }

  PointRows make(std::size_t i) const {
    const Experiment& one = list_.experiments[i];
    const Simulator& by = simulator_(one);
    const Vec3 position = list_.places.position.row(one.place),
               normal = list_.places.normal.row(one.place);
    if (one.kind != ExperimentKind::press) {
      PointRows out = by.follow(position, normal, one.path, progress_);
      std::ranges::fill(out.kind, one.kind);
      return out;
    }
    if (one.effort.scale > 0)
      return scaled(by.press_quickly(position, normal, each_, progress_), one.effort.scale,
                    options_.quick);
    return by.press_and_drag(position, normal, one.effort.is_dragged ? each_ : press_, progress_);
  }
  void take(std::size_t i, PointRows rows) { rows_[i] = std::move(rows); }

  Samples gather() const {
    Samples out = places_;
    std::vector<const SampleRows*> parts;
    for (const PointRows& rows : rows_) parts.push_back(&rows);
    static_cast<SampleRows&>(out) = joined_rows(parts);
    out.probe_number.resize(out.rows());
    out.path.resize(out.rows());
    if (surface_columns_ > 0) out.surface.setZero(out.rows(), surface_columns_);
    std::vector<char> is_known(out.points(), 0);
    Eigen::Index row = 0;
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      const Experiment& one = list_.experiments[i];
      const PointRows& done = rows_[i];
      if (done.surface.rows() > 0 && surface_columns_ > 0)
        out.surface.middleRows(row, done.rows()) = done.surface;
      for (const Eigen::Index end = row + done.rows(); row < end; ++row) {
        out.point[row] = out.tool_of(row) > 0 ? one.path.second->place : one.place;
        out.experiment[row] += number_[i];
        out.probe_number[row] = one.probe_number;
        out.path[row] = one.path.kind;
      }
      if (!is_done(i) || std::exchange(is_known[one.place], 1)) continue;
      out.point_sway.row(one.place) = numbers_of(done.sway_m_N);
      out.point_scale[one.place] = done.scale;
    }
    remove_void_columns(out);
    return out;
  }

 private:
  // The places as the probe of most experiments touches them.
  void place_at_surface() {
    const TestPoints& at = list_.places;
    places_.point_position = at.position;
    places_.point_normal = at.normal;
    places_.point_name = at.name;
    places_.point_normal_gradient.setZero(at.position.rows(), 9);
    places_.point_sway.setZero(at.position.rows(), 6);
    places_.point_scale.setZero(at.position.rows());
    std::vector<char> is_known(at.position.rows(), 0);
    const auto look = [&](const Simulator& by, std::int32_t p) {
      if (std::exchange(is_known[p], 1)) return;
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
    std::vector<std::vector<Eigen::Index>> of(rows_.size());
    for (Eigen::Index row = 0; row < done.rows(); ++row) {
      const auto after = std::upper_bound(number_.begin(), number_.end(), done.experiment[row]);
      if (after != number_.begin()) of[after - number_.begin() - 1].push_back(row);
    }
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      if (of[i].empty()) continue;
      append_rows(rows_[i], done, of[i]);
      for (std::int32_t& experiment : rows_[i].experiment) experiment -= number_[i];
      const std::int32_t place = done.point[of[i].front()];
      if (done.point_sway.rows() > 0) rows_[i].sway_m_N = symmetric_of(done.point_sway.row(place));
      if (done.point_scale.size() > 0) rows_[i].scale = done.point_scale[place];
    }
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
  std::vector<PointRows> rows_;  // of each experiment, which are numbered from 0
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
    PointRows result = work.make(i);
    if (!result.is_complete) return;
    const std::lock_guard<std::mutex> lock(reporting);
    work.take(i, std::move(result));
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

double force_at_first(const Simulator& simulator, const TestPoints& points,
                      const Experiments& experiments, const Progress& progress) {
  std::vector<double> ratios;
  for (Eigen::Index p = 0; p < points.position.rows() && !progress.stopped(); ++p) {
    const Vec3 position = points.position.row(p), normal = points.normal.row(p);
    const PointRows slow = simulator.press_quickly(position, normal, experiments, progress);
    const PointRows first = simulator.press_at_once(position, normal, experiments, progress);
    for (Eigen::Index i = 0; i < slow.rows() && i < first.rows(); ++i)
      if (slow.status[i] == RowStatus::good && first.status[i] == RowStatus::good &&
          slow.force.row(i).dot(normal) > 0)
        ratios.push_back(first.force.row(i).dot(normal) / slow.force.row(i).dot(normal));
  }
  return ratios.empty() ? 0 : median(ratios);
}

// With shear modulus s (1 in slow motion) and bulk modulus K + k s, the plane modulus of a
// half-space is 4 s (3K + (3k + 1) s) / (3K + (3k + 4) s) = 4 [ (p/q) s + c - m c / (m + q s) ]
// with m = 3K, p = 3k + 1, q = 3k + 4, c = 3m/q^2. The first term relaxes as the shear does. Of the
// last, m + q s(P) = b - q sum g_k / (1 + P tau_k) is inverted by Woodbury's identity and the modes
// of diag(tau) and the matrix of rank one that is left.
Relaxation relaxation_of_contact(const Material& material, double at_first) {
  const Relaxation& shear = material.relaxation;
  if (shear.branches() == 0) return {};
  double U, U1, U2;
  material.law->volumetric(material.constants, 0, U, U1, U2);
  const SmallStrain moduli = material.law->small_strain(material.constants);
  const double m = 3 * U2 / moduli.mu_Pa, k = (moduli.bulk_Pa() - U2) / moduli.mu_Pa;
  const double p = 3 * k + 1, q = 3 * k + 4, c = 3 * m / (q * q);
  const double slow = p / q + c - m * c / (m + q), b = m + q * instantaneous_stiffness(shear);

  const Eigen::VectorXd root = (q * shear.share).cwiseSqrt();
  const Eigen::MatrixXd left =
      Eigen::MatrixXd::Identity(root.size(), root.size()) - root * root.transpose() / b;
  const Eigen::MatrixXd times = shear.time_s.asDiagonal();
  const SymmetricEigen modes = symmetric_eigen(left, times);
  Relaxation out = shear;
  for (Eigen::Index branch = 0; branch < shear.branches(); ++branch) {
    const Eigen::Index mode = shear.branches() - 1 - branch;  // rates rise, times fall
    const double rate = modes.values[mode];
    const double direct = p / q * shear.share[branch] / slow;
    const double volume =
        m * c / (b * b) / rate / slow * std::pow(root.dot(modes.vectors.col(mode)), 2);
    out.share[branch] = direct + volume;
    out.time_s[branch] =
        (direct * shear.time_s[branch] + volume / rate) / out.share[branch];  // same area
  }
  if (at_first > 0) out.share *= (at_first - 1) / out.share.sum();
  return out;
}

}  // namespace palpate::fem
