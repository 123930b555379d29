#include "libfit/recordings/relaxation/least_squares.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "libfit/core/linear_algebra.hpp"

namespace palpate::recordings {

Eigen::VectorXd nonnegative_least_squares(const Eigen::MatrixXd& gram,
                                          const Eigen::VectorXd& right) {
  const Eigen::Index n = right.size();
  Eigen::VectorXd scale(n);  // columns of length 1
  for (Eigen::Index i = 0; i < n; ++i) scale[i] = gram(i, i) > 0 ? 1 / std::sqrt(gram(i, i)) : 0;
  const Eigen::MatrixXd g = scale.asDiagonal() * gram * scale.asDiagonal();
  const Eigen::VectorXd b = scale.cwiseProduct(right);
  const double tolerance = 1e-12 * b.cwiseAbs().maxCoeff();
  constexpr double kRidge = 1e-12;  // columns alike but for rounding

  Eigen::VectorXd x = Eigen::VectorXd::Zero(n);
  std::vector<Eigen::Index> passive;
  for (Eigen::Index round = 0; round < 3 * n; ++round) {
    const Eigen::VectorXd slope = b - g * x;
    Eigen::Index enters = -1;
    double most = tolerance;
    for (Eigen::Index i = 0; i < n; ++i)
      if (x[i] == 0 && slope[i] > most && scale[i] > 0 &&
          std::find(passive.begin(), passive.end(), i) == passive.end())
        most = slope[i], enters = i;
    if (enters < 0) break;
    passive.push_back(enters);
    while (!passive.empty()) {
      Eigen::MatrixXd part = g(passive, passive);
      part.diagonal().array() += kRidge;
      const Eigen::VectorXd wanted = ldlt_solve(part, b(passive));
      double way = 1;
      for (std::size_t k = 0; k < passive.size(); ++k) {
        const double to = wanted[static_cast<Eigen::Index>(k)], from = x[passive[k]];
        if (to <= 0) way = std::min(way, from > 0 ? from / (from - to) : 0.);
      }
      for (std::size_t k = 0; k < passive.size(); ++k) {
        double& at = x[passive[k]];
        at += way * (wanted[static_cast<Eigen::Index>(k)] - at);
      }
      if (way >= 1) break;
      std::erase_if(passive, [&](Eigen::Index i) {
        if (x[i] > 1e-14) return false;
        x[i] = 0;
        return true;
      });
    }
  }
  return scale.cwiseProduct(x);
}

}  // namespace palpate::recordings
