#include "libfem/solve/experiments/simulate.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "libfit/core/stated_error.hpp"
#include "libfit/core/statistics.hpp"

namespace palpate::fem {
namespace {

// Good rows of presses by point and step.
std::map<std::pair<std::int32_t, std::int32_t>, Eigen::Index> pressed(const Samples& samples) {
  std::map<std::pair<std::int32_t, std::int32_t>, Eigen::Index> out;
  for (Eigen::Index i = 0; i < samples.rows(); ++i) {
    if (samples.kind[i] == ExperimentKind::press && samples.status[i] == RowStatus::good)
      out[{samples.point[i], samples.step[i]}] = i;
  }
  return out;
}

struct PairedRow {
  std::int32_t point;
  double ratio;               // two meshes over one, along the force
  double quick_N;             // force on one mesh
  double own_error;           // of the row on two meshes, relative
  double force_N, largest_N;  // of the row, of its point

  double log_force() const { return std::log(quick_N); }
};

using RowsByStep = std::map<std::int32_t, std::vector<PairedRow>>;

RowsByStep paired(const Samples& two_meshes, const Samples& one_mesh, double max_error) {
  const auto quick = pressed(one_mesh), full = pressed(two_meshes);
  std::map<std::int32_t, double> largest_N;  // by point
  for (const auto& [key, row] : full)
    largest_N[key.first] = std::max(largest_N[key.first], two_meshes.force.row(row).norm());
  RowsByStep out;
  for (const auto& [key, row] : full) {
    const auto found = quick.find(key);
    if (found == quick.end()) continue;
    const Vec3 force = two_meshes.force.row(row), other = one_mesh.force.row(found->second);
    if (!(force.squaredNorm() > 0 && other.dot(force) > 0)) continue;
    if (two_meshes.force_error[row] > max_error * force.norm()) continue;
    out[key.second].push_back({key.first, force.squaredNorm() / other.dot(force), other.norm(),
                               two_meshes.force_error[row] / force.norm(), force.norm(),
                               largest_N[key.first]});
  }
  return out;
}

RowsByStep without(const RowsByStep& steps, std::int32_t point) {
  RowsByStep out;
  for (const auto& [step, rows] : steps)
    for (const PairedRow& row : rows)
      if (row.point != point) out[step].push_back(row);
  return out;
}

// Median over pairs of rows of one step (Theil 1950, Sen 1968), drawn to 0 by a ridge.
double slope_of(const RowsByStep& steps) {
  std::vector<double> slopes;
  double squares = 0;
  for (const auto& [step, rows] : steps) {
    std::vector<double> log_force;
    for (const PairedRow& row : rows) log_force.push_back(row.log_force());
    const double middle = median(log_force);
    for (std::size_t i = 0; i < rows.size(); ++i) {
      squares += std::pow(log_force[i] - middle, 2) / static_cast<double>(steps.size());
      // Pairs whose ln forces are closer have no slope.
      for (std::size_t j = 0; j < i; ++j)
        if (const double apart = log_force[i] - log_force[j]; std::abs(apart) > 0.05)
          slopes.push_back((rows[i].ratio - rows[j].ratio) / apart);
    }
  }
  // A slope counts half where the squares of ln force sum to 0.05.
  return median(std::move(slopes)) * squares / (squares + 0.05);
}

// The factors of all steps (M13e), without their errors.
QuickScale factors_of(const RowsByStep& steps, bool is_line) {
  QuickScale out;
  if (is_line) out.slope = slope_of(steps);
  for (const auto& [step, rows] : steps) {
    QuickStep here;
    std::vector<double> log_force, level;
    for (const PairedRow& row : rows) log_force.push_back(row.log_force());
    here.log_force = median(log_force);
    here.lowest = *std::ranges::min_element(log_force);
    here.highest = *std::ranges::max_element(log_force);
    for (const PairedRow& row : rows)
      level.push_back(row.ratio - out.slope * (row.log_force() - here.log_force));
    here.scale = median(std::move(level));
    out.steps.resize(step + 1, out.steps.empty() ? here : out.steps.back());
    out.steps.back() = here;
  }
  return out;
}

double left_by(const QuickScale& quick, std::int32_t step, const PairedRow& row) {
  return std::abs(quick.factor(step, row.quick_N) / row.ratio - 1);
}

std::set<std::int32_t> points_of(const RowsByStep& steps) {
  std::set<std::int32_t> out;
  for (const auto& [step, rows] : steps)
    for (const PairedRow& row : rows) out.insert(row.point);
  return out;
}

// Residual of each row by factors from the other points; none of a point that is alone.
std::map<std::int32_t, std::vector<double>> left_out(const RowsByStep& steps, bool is_line) {
  std::map<std::int32_t, std::vector<double>> out;
  for (const std::int32_t point : points_of(steps)) {
    const QuickScale others = factors_of(without(steps, point), is_line);
    if (!others) continue;
    for (const auto& [step, rows] : steps)
      for (const PairedRow& row : rows)
        if (row.point == point) out[step].push_back(left_by(others, step, row));
  }
  return out;
}

double sum(const std::map<std::int32_t, std::vector<double>>& left) {
  double out = 0;
  for (const auto& [step, rows] : left)
    for (const double each : rows) out += each;
  return out;
}

}  // namespace

const QuickStep& QuickScale::step(std::int32_t number) const {
  return steps[std::min(static_cast<std::size_t>(number), steps.size() - 1)];
}

double QuickScale::factor(std::int32_t number, double force_N) const {
  const QuickStep& here = step(number);
  if (slope == 0) return here.scale;
  return here.scale +
         slope * (std::clamp(std::log(force_N), here.lowest, here.highest) - here.log_force);
}

QuickScale compare_quick(const Samples& two_meshes, const Samples& one_mesh, double max_error) {
  const RowsByStep steps = paired(two_meshes, one_mesh, max_error);
  auto left = left_out(steps, true);
  const bool is_line = sum(left) < sum(left_out(steps, false));
  QuickScale out = factors_of(steps, is_line);
  out.points = static_cast<int>(points_of(steps).size());
  std::vector<double> all_left;
  for (const auto& [step, rows] : steps) {
    std::vector<double>& here = left[step];  // of points in rising order, as rows
    if (!is_line) here.clear();
    std::vector<double> own;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (!is_line) here.push_back(left_by(out, step, rows[i]));
      if (std::isfinite(rows[i].own_error)) own.push_back(rows[i].own_error);
      all_left.push_back(relative_error(here[i] * rows[i].force_N, rows[i].force_N,
                                        relative_floor(rows[i].largest_N)));
    }
    out.steps[step].error = *std::ranges::max_element(here) + median(std::move(own));
  }
  for (std::size_t s = 0; s < out.steps.size(); ++s)
    if (steps.count(static_cast<std::int32_t>(s)) == 0)
      out.steps[s].error =
          out.steps[s > 0 ? s - 1 : static_cast<std::size_t>(steps.begin()->first)].error;
  if (!all_left.empty()) out.p95 = lower_quantile(std::move(all_left), 0.95);
  return out;
}

}  // namespace palpate::fem
