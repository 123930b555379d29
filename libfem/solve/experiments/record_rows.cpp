#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "libfem/solve/experiments/simulator_state.hpp"
#include "libfit/core/stated_error.hpp"
#include "libfit/core/statistics.hpp"

namespace palpate::fem {
namespace {

// Error over difference of grids of ratio 1.6 was 0.61 to 0.69 in eight of ten runs against the
// axisymmetric reference; order 2 gives 0.641.
constexpr double kOrder = 2;

/// Rows of one experiment from both meshes: force and torque extrapolated, with their error.
void record_experiment(const std::vector<PathRow>& fine, const std::vector<PathRow>& coarse,
                       double ratio, double min_error, const std::vector<Eigen::Index>& rows,
                       SampleRows& out) {
  std::vector<Vec3> force, coarse_force;
  for (const Eigen::Index i : rows) {
    force.push_back(fine[i].force_N);  // zero where the row failed
    coarse_force.push_back(coarse.empty() ? Vec3(Vec3::Zero()) : coarse[i].force_N);
  }
  const Richardson limit = richardson(force, coarse_force, ratio, min_error);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const Eigen::Index i = rows[k];
    const PathRow& row = fine[i];
    if (!write_row(row, 1 - limit.excess, i, out)) continue;
    if (i + 1 < out.rows() && out.tool_of(i + 1) > 0)
      out.force.row(i + 1) = (1 - limit.excess) * row.second_force_N;
    out.force_error[i] = std::hypot(limit.error[k] * out.force.row(i).norm(),
                                    std::hypot(row.penalty_error_N, row.solver_error_N));  // (M13c)
  }
}

}  // namespace

Richardson richardson(const std::vector<Vec3>& fine, const std::vector<Vec3>& coarse, double ratio,
                      double min_error) {
  assert(fine.size() == coarse.size());
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  double largest = 0;
  for (const Vec3& force : fine) largest = std::max(largest, force.norm());
  std::vector<double> difference(fine.size(), kNaN);  // along the force
  double sum = 0;
  int rows = 0;
  for (std::size_t i = 0; i < fine.size(); ++i) {
    if (!(fine[i].squaredNorm() > 0 && coarse[i].squaredNorm() > 0)) continue;
    difference[i] = (coarse[i] - fine[i]).dot(fine[i]) / fine[i].squaredNorm();
    if (fine[i].norm() < 0.01 * largest) continue;
    sum += difference[i];
    ++rows;
  }
  Richardson out;
  out.error.assign(fine.size(), kNaN);
  if (rows == 0) return out;
  const double mean = sum / rows;
  const bool is_extrapolated = std::abs(mean) <= 0.1;
  const double share = is_extrapolated ? 1 / (std::pow(ratio, kOrder) - 1) : 1;
  if (is_extrapolated) out.excess = share * mean;
  // An order between 1.5 and 3 leaves half of the excess.
  const double of_all = is_extrapolated ? 0.5 * out.excess : mean;
  for (std::size_t i = 0; i < fine.size(); ++i) {
    const double of_row = std::isnan(difference[i])
                              ? 0
                              : share * (coarse[i] - (1 + mean) * fine[i]).norm() / fine[i].norm();
    out.error[i] = std::max(min_error, std::hypot(of_all, of_row));
  }
  return out;
}

bool write_row(const PathRow& solved, double factor, Eigen::Index i, SampleRows& out) {
  out.status[i] = solved.status;
  out.step_check[i] = solved.step_check;
  if (solved.status != RowStatus::good) return false;
  out.force.row(i) = factor * solved.force_N;
  out.torque.row(i) = factor * solved.torque_Nm;
  return true;
}

void record_rows(const std::vector<PathRow>& fine, const std::vector<PathRow>& coarse, double ratio,
                 double min_error, SampleRows& out) {
  for (Eigen::Index i = 0; i < out.rows();) {
    std::vector<Eigen::Index> rows;
    for (const int experiment = out.experiment[i];
         i < out.rows() && out.experiment[i] == experiment; ++i)
      if (out.tool_of(i) == 0) rows.push_back(i);
    record_experiment(fine, coarse, ratio, min_error, rows, out);
  }
}

void record_by_press(const std::vector<PathRow>& coarse, SampleRows& out) {
  const auto is_press = [&](Eigen::Index i) {
    return out.kind[i] == ExperimentKind::press && is_solved(out.status[i]);
  };
  double largest_N = 0;
  for (Eigen::Index i = 0; i < out.rows(); ++i)
    if (is_press(i)) largest_N = std::max(largest_N, out.force.row(i).norm());
  std::vector<double> factors, errors;
  for (Eigen::Index i = 0; i < out.rows(); ++i) {
    const Vec3 force = out.force.row(i), &other = coarse[i].force_N;
    if (!is_press(i) || !is_solved(coarse[i].status)) continue;
    // The factor is that of rows above a twentieth of the largest press.
    if (force.norm() < 0.05 * largest_N) continue;
    factors.push_back(force.dot(other) / other.squaredNorm());
    errors.push_back(out.force_error[i] / force.norm());
  }
  if (factors.empty()) return;
  const double factor =
      std::accumulate(factors.begin(), factors.end(), 0.0) / static_cast<double>(factors.size());
  // Relative error of a drag or path on the coarse grid, times the factor of its press (M13k).
  // Chosen on two livers, against finer grids: 176 of 179 rows of paths are then within what they
  // state (0.9 %: 170; both grids: 216 of 220 rows). The largest is 2 % off.
  const double error = std::hypot(median(std::move(errors)), 0.011);
  for (Eigen::Index i = 0; i < out.rows(); ++i) {
    if (out.kind[i] == ExperimentKind::press) continue;
    const PathRow& row = coarse[i];
    if (!write_row(row, factor, i, out)) continue;
    out.force_error[i] = std::hypot(error * out.force.row(i).norm(),
                                    std::hypot(row.penalty_error_N, row.solver_error_N));
  }
}

void mark_wedged(const Vec3& normal, SampleRows& rows) {
  for (Eigen::Index i = 0; i < rows.rows(); ++i)
    if (rows.kind[i] == ExperimentKind::press && rows.status[i] == RowStatus::good &&
        rows.force.row(i).dot(normal) < std::numbers::sqrt2 / 2 * rows.force.row(i).norm())
      rows.status[i] = RowStatus::wedged;
}

void complete_second_tools(SampleRows& rows) {
  for (Eigen::Index i = 1; i < rows.rows(); ++i) {
    if (rows.tool_of(i) == 0) continue;
    rows.status[i] = rows.status[i - 1];
    rows.step_check[i] = rows.step_check[i - 1];
    rows.force_error[i] = rows.force_error[i - 1];
    if (rows.surface.rows() > 0) rows.surface.row(i) = rows.surface.row(i - 1);
  }
}

double achieved_error(const SampleRows& rows, const std::vector<Eigen::Index>& which) {
  constexpr double kUnknown = std::numeric_limits<double>::infinity();
  double largest_N = 0, error = 0;
  for (const Eigen::Index i : which)
    if (rows.status[i] == RowStatus::good)
      largest_N = std::max(largest_N, rows.force.row(i).norm());
  if (!(largest_N > 0)) return kUnknown;
  for (const Eigen::Index i : which) {
    const double force_N = rows.force.row(i).norm();
    if (rows.status[i] != RowStatus::good || !(force_N > 0)) continue;
    if (!std::isfinite(rows.force_error[i])) return kUnknown;
    error =
        std::max(error, relative_error(rows.force_error[i], force_N, relative_floor(largest_N)));
  }
  return error;
}

double achieved_error(const SampleRows& rows) {
  std::vector<Eigen::Index> all(rows.rows());
  std::iota(all.begin(), all.end(), Eigen::Index{0});
  return achieved_error(rows, all);
}

}  // namespace palpate::fem
