#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace palpate {

/// How well each test point's curves meet its rows, so that a fit that keeps curves can tell
/// without the rows. P points; no rows where unknown.
struct FitScores {
  Eigen::VectorXd relative_residual;  ///< P, rms residual over rms force; NaN where not scored
  /// P, experiment of the largest residual, counted from the id of the point's first row, and the
  /// row in it; 0 where not scored.
  std::vector<std::int32_t> worst_experiment, worst_row;
  /// P x 4: rows fitted, not good, not finite, and after one left out of a drag or path.
  Eigen::Matrix<std::int32_t, Eigen::Dynamic, 4, Eigen::RowMajor> rows;
  /// P x 3 [m]: where the rows of the normal, lateral and limit curve end; NaN without any.
  Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor> curve_end_m;
  std::vector<std::int8_t> states_errors;  ///< P, 1 where some row has a force error of its own
  /// |force difference| / max(|force|, 5 % of the point's typical force) in millionths, of the rows
  /// fitted of all scored points, point after point.
  std::vector<std::int32_t> relative_error;

  bool empty() const { return rows.rows() == 0; }
};

}  // namespace palpate
