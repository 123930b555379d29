#pragma once

#include <Eigen/Core>

#include "libfit/runtime/spline.hpp"

namespace palpate::fit {

/// Entries of the lower triangle, row by row, of a symmetric matrix of `size`.
inline Eigen::Index packed_size(Eigen::Index size) { return size * (size + 1) / 2; }

/// The lower triangle of a symmetric matrix, row by row.
Eigen::VectorXd pack_symmetric(const Eigen::MatrixXd& matrix);

/// Standard error [N] of a fitted curve at x [m]: sqrt(w' C w) with w the I-splines at x and C the
/// covariance of the curve's increments, packed: a row of FittedCurves::covariance. 0 for x <= 0,
/// NaN where C is.
double curve_deviation(const runtime::SplineView& spline, const Eigen::VectorXd& covariance,
                       double x);

/// How many standard errors on either side hold 90 % of a normal distribution.
inline constexpr double kBand90 = 1.6448536269514722;

}  // namespace palpate::fit
