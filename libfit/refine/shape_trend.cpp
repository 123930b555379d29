#include "libfit/refine/shape_trend.hpp"

#include <algorithm>

namespace palpate {

Eigen::RowVectorXd at_controls(const CurveBasis& basis, const Eigen::RowVectorXd& trend) {
  const std::vector<double>& knots = basis.knots_m;
  Eigen::RowVectorXd out(basis.size());
  for (int j = 0; j < basis.size(); ++j) {
    double sum = 0;  // of the knots between the ends of B_j; the outer ones count `degree` times
    for (int k = 1; k <= basis.degree; ++k)
      sum += knots[static_cast<std::size_t>(std::clamp(j + k - basis.degree, 0, basis.pieces()))];
    const double step = kComparedDepths * sum / (basis.degree * knots.back()) - 1;
    const int i = std::clamp(static_cast<int>(step), 0, kComparedDepths - 2);
    out[j] = trend[i] + std::clamp(step - i, 0.0, 1.0) * (trend[i + 1] - trend[i]);
  }
  return out;
}

}  // namespace palpate
