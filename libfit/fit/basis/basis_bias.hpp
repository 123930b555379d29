#pragma once

#include "libfit/fit/spline/monotone_least_squares.hpp"

namespace palpate::fit {

/// What the covariance of a curve's increments is to be multiplied with for what its basis cannot
/// follow (docs/method.md, section 14): 1 + the mean over the rows' range of (f - g)^2 / s^2, f the
/// curve on the basis, s its standard error and g the curve on one with every piece halved. Without
/// bias f and g differ by noise, which is not taken off: the basis was chosen by the same noise,
/// for being close to g. rows: of unit weights; 1 where they are too few for the finer basis.
double basis_inflation(const CurveBasis& basis, const std::vector<CurveRow>& rows,
                       const Eigen::MatrixXd& covariance, FitLoss loss);

}  // namespace palpate::fit
