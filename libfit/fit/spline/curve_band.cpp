#include "libfit/fit/spline/curve_band.hpp"

#include <algorithm>
#include <cmath>

namespace palpate::fit {
namespace {

constexpr int kGrid = 40;

CurveBasis halved(const CurveBasis& basis) {
  CurveBasis fine{basis.degree, {basis.knots_m.front()}};
  for (std::size_t i = 1; i < basis.knots_m.size(); ++i) {
    fine.knots_m.push_back(0.5 * (basis.knots_m[i - 1] + basis.knots_m[i]));
    fine.knots_m.push_back(basis.knots_m[i]);
  }
  return fine;
}

}  // namespace

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

double basis_inflation(const CurveBasis& basis, const std::vector<CurveRow>& rows,
                       const Eigen::MatrixXd& covariance) {
  const CurveBasis fine = halved(basis);
  if (rows.size() < 2 * std::size_t(fine.size())) return 1;
  double range = 0;
  for (const CurveRow& row : rows) range = std::max(range, row.x);
  const SplineTables coarse_tables = tabulate(basis), fine_tables = tabulate(fine);
  const Eigen::VectorXd f = fit_smooth(basis, rows), g = fit_smooth(fine, rows);
  double sum = 0;
  for (int i = 1; i <= kGrid; ++i) {
    const double x = range * i / kGrid;
    const Eigen::VectorXd w = increment_weights(view(coarse_tables), x);
    const double apart = w.dot(f) - increment_weights(view(fine_tables), x).dot(g);
    const double square = w.dot(covariance * w);
    if (square > 0) sum += apart * apart / square / kGrid;
  }
  return 1 + sum;
}

}  // namespace palpate::fit
