#include "libfem/solve/experiments/record_rows.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "libfem/solve/experiments/richardson.hpp"
#include "libfit/core/stated_error.hpp"

namespace palpate::fem {
namespace {

constexpr double kWedgedCosine = std::numbers::sqrt2 / 2;  // of 45 degrees

/// Rows of one experiment from both meshes: force and torque extrapolated, with their error.
void record_experiment(const std::vector<PathRow>& fine, const std::vector<PathRow>& coarse,
                       double ratio, double min_error, const std::vector<std::size_t>& rows,
                       std::vector<PointRow>& out) {
  std::vector<Vec3> force, coarse_force;
  for (const std::size_t i : rows) {
    force.push_back(fine[i].force_N);  // zero where the row failed
    coarse_force.push_back(coarse.empty() ? Vec3(Vec3::Zero()) : coarse[i].force_N);
  }
  const Richardson limit = richardson(force, coarse_force, ratio, min_error);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const PathRow& row = fine[rows[k]];
    PointRow& recorded = out[rows[k]];
    recorded.status = row.status;
    recorded.step_check = row.step_check;
    if (row.status != RowStatus::good) continue;
    recorded.force = (1 - limit.excess) * row.force_N;
    recorded.torque = (1 - limit.excess) * row.torque_Nm;
    if (recorded.second) recorded.second->force = (1 - limit.excess) * row.second_force_N;
    recorded.force_error =
        std::hypot(limit.error[k] * recorded.force.norm(),
                   std::hypot(row.penalty_error_N, row.solver_error_N));  // (M13c)
  }
}

}  // namespace

void record_rows(const std::vector<PathRow>& fine, const std::vector<PathRow>& coarse, double ratio,
                 double min_error, std::vector<PointRow>& out) {
  for (std::size_t begin = 0; begin < out.size();) {
    std::vector<std::size_t> rows;
    for (const int experiment = out[begin].experiment;
         begin < out.size() && out[begin].experiment == experiment; ++begin)
      rows.push_back(begin);
    record_experiment(fine, coarse, ratio, min_error, rows, out);
  }
}

void mark_wedged(const Vec3& normal, std::vector<PointRow>& rows) {
  for (PointRow& row : rows)
    if (row.kind == ExperimentKind::press && row.status == RowStatus::good &&
        row.force.dot(normal) < kWedgedCosine * row.force.norm())
      row.status = RowStatus::wedged;
}

double achieved_error(const std::vector<PointRow>& rows) {
  constexpr double kUnknown = std::numeric_limits<double>::infinity();
  double largest_N = 0, error = 0;
  for (const PointRow& row : rows)
    if (row.status == RowStatus::good) largest_N = std::max(largest_N, row.force.norm());
  if (!(largest_N > 0)) return kUnknown;
  for (const PointRow& row : rows) {
    if (row.status != RowStatus::good || !(row.force.norm() > 0)) continue;
    if (!std::isfinite(row.force_error)) return kUnknown;
    error = std::max(error,
                     relative_error(row.force_error, row.force.norm(), relative_floor(largest_N)));
  }
  return error;
}

}  // namespace palpate::fem
