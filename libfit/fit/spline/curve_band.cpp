#include "libfit/fit/spline/curve_band.hpp"

#include <cmath>

#include "libfit/fit/spline/monotone_least_squares.hpp"

namespace palpate::fit {

Eigen::VectorXd pack_symmetric(const Eigen::MatrixXd& matrix) {
  Eigen::VectorXd packed(packed_size(matrix.rows()));
  Eigen::Index at = 0;
  for (Eigen::Index i = 0; i < matrix.rows(); ++i)
    for (Eigen::Index j = 0; j <= i; ++j) packed[at++] = matrix(i, j);
  return packed;
}

double curve_deviation(const runtime::SplineView& spline, const Eigen::VectorXd& covariance,
                       double x) {
  if (!(x > 0)) return 0;
  const Eigen::VectorXd weight = increment_weights(spline, x);
  double square = 0;
  Eigen::Index at = 0;
  for (Eigen::Index i = 0; i < weight.size(); ++i)
    for (Eigen::Index j = 0; j <= i; ++j)
      square += (i == j ? 1 : 2) * covariance[at++] * weight[i] * weight[j];
  return square < 0 ? 0 : std::sqrt(square);  // rounding; NaN stays
}

}  // namespace palpate::fit
