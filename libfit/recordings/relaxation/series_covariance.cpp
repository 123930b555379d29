#include "libfit/recordings/relaxation/series_search.hpp"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>

#include "libfit/core/linear_algebra.hpp"

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

Eigen::MatrixXd series_covariance(const SeriesSearch& with, const SeriesValues& values,
                                  bool is_series_known) {
  const Eigen::Index branches = values.branches();
  Eigen::Index unknowns = 2 * branches;
  for (const PressGroup& group : with.groups()) unknowns += group.shifts();
  std::vector<Eigen::Index> free;
  for (Eigen::Index k = is_series_known ? 2 * branches : 0; k < unknowns; ++k) {
    if (k >= branches && k < 2 * branches)
      if (const double at = values.branch[k]; with.is_slowest(at) || with.is_fastest(at)) continue;
    free.push_back(k);
  }
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(unknowns, unknowns), noise = information;
  Eigen::Index first = 2 * branches;  // of the group's shifts
  for (std::size_t g = 0; g < with.groups().size(); ++g) {
    const PressGroup& group = with.groups()[g];
    const Eigen::Index shifts = group.shifts();
    const SeriesSearch::Slopes slopes = with.slopes(g, values);
    const Eigen::MatrixXd inner = with.solution(g, values).slopes;
    Eigen::MatrixXd outer = Eigen::MatrixXd::Zero(group.residuals(), unknowns);
    outer.leftCols(2 * branches) = slopes.by_branch;
    outer.middleCols(first, shifts) = slopes.by_shift;
    information += outer.transpose() * outer;
    const Eigen::MatrixXd priors = outer.bottomRows(group.priors());
    noise += priors.transpose() * priors;
    for (std::size_t r = 0; r < group.recordings(); ++r) {
      const PressGroup::FittedRows rows = group.counted(r);
      const Eigen::MatrixXd by = outer(rows.row, Eigen::all);
      Eigen::MatrixXd all(by.rows(), 2 * branches + shifts + inner.cols());
      all << by.leftCols(2 * branches), by.middleCols(first, shifts), inner(rows.row, Eigen::all);
      noise +=
          by.transpose() *
          sensor_covariance(rows.time_s, rows.noise, rows.weight, slopes.residual(rows.row), all) *
          by;
    }
    first += shifts;
  }
  const Eigen::MatrixXd inverse = ldlt_inverse(information(free, free));
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(unknowns, unknowns);
  covariance(free, free) = inverse * noise(free, free) * inverse;
  return covariance;
}

}  // namespace palpate::recordings
