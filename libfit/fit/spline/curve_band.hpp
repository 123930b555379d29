#pragma once

#include "libfit/fit/spline/monotone_least_squares.hpp"

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

/// Factor of the covariance of a curve's increments for the bias of its basis
/// (docs/method-identification.md, section 14): 1 + the mean over the rows' range of (f - g)^2 /
/// s^2, f the curve on the basis, s its standard error and g the curve on one with every piece
/// halved. Without bias f and g differ by noise, which is not taken off: the basis was chosen by
/// the same noise, for being close to g. rows: of unit weights; 1 where they are too few for the
/// finer basis.
double basis_inflation(const CurveBasis& basis, const std::vector<CurveRow>& rows,
                       const Eigen::MatrixXd& covariance);

/// Standard errors on either side that hold 90 % of a normal distribution.
inline constexpr double kBand90 = 1.6448536269514722;

}  // namespace palpate::fit
