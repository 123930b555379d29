#include "libfit/refine/shape_trend.hpp"

#include <algorithm>

namespace palpate {

Eigen::RowVectorXd at_controls(const CurveBasis& basis, const Eigen::RowVectorXd& trend) {
  const std::vector<double> abscissae = greville_abscissae(basis);
  Eigen::RowVectorXd out(basis.size());
  for (int j = 0; j < basis.size(); ++j) {
    const double step = kComparedDepths * abscissae[j] / basis.knots_m.back() - 1;
    const int i = std::clamp(static_cast<int>(step), 0, kComparedDepths - 2);
    out[j] = trend[i] + std::clamp(step - i, 0.0, 1.0) * (trend[i + 1] - trend[i]);
  }
  return out;
}

}  // namespace palpate
