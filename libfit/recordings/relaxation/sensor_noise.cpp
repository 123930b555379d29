#include "libfit/recordings/relaxation/sensor_noise.hpp"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace palpate::recordings {
namespace {

// Variances of drift over that of the noise of rows.
constexpr std::array<double, 10> kProportions{0, 0.03, 0.1, 0.3, 1, 3, 10, 30, 100, 300};
constexpr double kLadder = 3;      // from one time of the drift to the next
constexpr double kMinNoise = 0.1;  // of a residual: no row is better

// Correlation of noise whose power goes as 1/f between the spacing of rows and their length.
Eigen::MatrixXd slow_correlation(const Eigen::VectorXd& time_s) {
  const Eigen::Index n = time_s.size();
  const double length_s = time_s[n - 1] - time_s[0];
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(n, n);
  double terms = 0;
  for (double s = length_s / static_cast<double>(n); s <= length_s; s *= kLadder, ++terms)
    sum.array() +=
        (-(time_s.replicate(1, n).rowwise() - time_s.transpose()).array().abs() / s).exp();
  return sum / terms;
}

}  // namespace

Eigen::MatrixXd sensor_covariance(const Eigen::VectorXd& time_s, const Eigen::VectorXd& noise,
                                  const Eigen::VectorXd& weight, const Eigen::VectorXd& residual,
                                  const Eigen::MatrixXd& slopes) {
  const Eigen::Index n = residual.size();
  const Eigen::ArrayXd own = noise.array().max(kMinNoise).square();
  if (n < 3) return own.matrix().asDiagonal();
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> basis(slopes);
  basis.setThreshold(1e-8);
  const Eigen::Index known = basis.rank();
  const auto left = static_cast<double>(n - known);
  if (left < 2) return own.matrix().asDiagonal();
  const Eigen::MatrixXd q = basis.householderQ() * Eigen::MatrixXd::Identity(n, known);
  const Eigen::MatrixXd drift =
      own.mean() / weight.squaredNorm() * static_cast<double>(n) *
      (weight.asDiagonal() * slow_correlation(time_s) * weight.asDiagonal());

  std::array<double, kProportions.size()> likelihood, scale;
  for (std::size_t k = 0; k < kProportions.size(); ++k) {
    Eigen::MatrixXd all = kProportions[k] * drift;
    all.diagonal().array() += own;
    const Eigen::LLT<Eigen::MatrixXd> factor(all);
    const Eigen::MatrixXd white = factor.matrixL().solve(q);
    const Eigen::VectorXd rest = factor.matrixL().solve(residual);
    const Eigen::LLT<Eigen::MatrixXd> inner(Eigen::MatrixXd(white.transpose() * white));
    const Eigen::VectorXd by = inner.matrixL().solve(white.transpose() * rest);
    scale[k] = std::max(rest.squaredNorm() - by.squaredNorm(), 1e-300) / left;
    likelihood[k] = -factor.matrixLLT().diagonal().array().log().sum() -
                    inner.matrixLLT().diagonal().array().log().sum() -
                    left / 2 * std::log(scale[k]);
  }
  const double most = *std::ranges::max_element(likelihood);
  double sum = 0, diagonal = 0, slow = 0;
  for (std::size_t k = 0; k < kProportions.size(); ++k) {
    const double share = std::exp(likelihood[k] - most);
    sum += share;
    diagonal += share * scale[k], slow += share * scale[k] * kProportions[k];
  }
  Eigen::MatrixXd out = slow / sum * drift;
  out.diagonal().array() += diagonal / sum * own;
  return out;
}

}  // namespace palpate::recordings
