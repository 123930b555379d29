#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <unsupported/Eigen/SpecialFunctions>

#include "libfem/calibrate/material_search.hpp"

namespace palpate::fem {
namespace {

using Eigen::Index, Eigen::MatrixXd, Eigen::VectorXd;

constexpr double kUndetermined = 0.5;  // relative deviation of an undetermined parameter

// The 95 % quantile of F with these degrees of freedom.
double f_quantile(double numerator, double denominator) {
  double low = 0, high = 1e6;
  for (int i = 0; i < 100; ++i) {
    const double middle = (low + high) / 2, x = numerator * middle;
    const double below =
        Eigen::numext::betainc(numerator / 2, denominator / 2, x / (x + denominator));
    (below < 0.95 ? low : high) = middle;
  }
  return high;
}

// How many residuals one independent residual stands for: 1 + 2 sum of their correlations over lags
// within experiments, up to the first that is within two of its own errors (M44).
double rows_each(const VectorXd& r, const std::vector<int>& group) {
  const double variance = r.squaredNorm() / r.size();
  double sum = 1;
  for (Index lag = 1; lag < r.size(); ++lag) {
    double products = 0, pairs = 0;
    for (Index i = lag; i < r.size(); ++i)
      if (group[i] == group[i - lag]) {
        products += r[i] * r[i - lag];
        ++pairs;
      }
    const double rho = pairs > 0 && variance > 0 ? products / (pairs * variance) : 0;
    if (!(rho * std::sqrt(pairs) > 2)) break;
    sum += 2 * rho;
  }
  return sum;
}

// Adds the combinations that are determined where the constants are not: directions V of relative
// changes (over `size`) with a small deviation.
void add_combinations(const MaterialSearch& search, const MatrixXd& V, const MatrixXd& relative,
                      const VectorXd& size, Identification& out) {
  const bool is_product =
      !std::all_of(out.free.begin(), out.free.end(), [&](auto i) { return search.is_modulus(i); });
  for (Index i = 0; i < V.cols(); ++i) {
    const double spread = std::sqrt(V.col(i).dot(relative * V.col(i)));
    if (spread > kUndetermined) continue;
    DeterminedCombination one{.weight = V.col(i), .is_product = is_product};
    if (!is_product) one.weight = one.weight.cwiseQuotient(size).eval();
    Index main = 0;
    one.weight.cwiseProduct(is_product ? VectorXd::Ones(size.size()) : size)
        .cwiseAbs()
        .maxCoeff(&main);
    one.weight /= one.weight[main];
    one.value = is_product ? 1 : 0;
    for (Index j = 0; j < V.cols(); ++j) {
      const double value = out.material.values[out.free[j]];
      if (is_product)
        one.value *= std::pow(std::abs(value), one.weight[j]);
      else
        one.value += one.weight[j] * value;
    }
    const VectorXd scaled =
        is_product ? VectorXd(one.value * one.weight.cwiseQuotient(size)) : one.weight;
    one.deviation = std::sqrt(scaled.dot(out.covariance * scaled));
    out.determined.push_back(one);
  }
}

}  // namespace

void state_errors(const MaterialSearch& search, const Observations& observed, const VectorXd& y,
                  double common_error, Identification& out) {
  const Index k = search.size();
  const std::optional<MatrixXd> J = search.sensitivities(y, out.response);
  if (!J) {
    out.is_converged = false;
    return;
  }
  VectorXd size(k);
  MatrixXd weighted = search.whitened(*J);
  for (Index j = 0; j < k; ++j) {
    size[j] = search.size_of(out.material, j);
    weighted.col(j) *= size[j] / search.coordinates[j].slope(y[j]);
  }
  const VectorXd r = search.whitened(out.response - observed.value);
  out.shared_error = search.shared_error(observed.value - out.response);
  const double n = r.size();
  const double per_freedom = r.squaredNorm() / std::max(1.0, n - k);
  out.misfit = std::sqrt(per_freedom);
  out.sum_of_squares = (out.response - observed.value).squaredNorm();
  double inflation = 1, rows = n;
  if (!search.is_stated || per_freedom > 1) {
    out.rows_each = rows_each(r, observed.group);
    inflation = per_freedom * out.rows_each;
    rows = n / out.rows_each;
  }
  const double freedom = std::max(1.0, rows - k);
  out.region = k * f_quantile(k, freedom);
  out.half_width = std::sqrt(f_quantile(1, freedom));

  const Eigen::JacobiSVD<MatrixXd> svd(weighted, Eigen::ComputeThinU | Eigen::ComputeThinV);
  const VectorXd singular =
      svd.singularValues().cwiseMax(1e-9 * svd.singularValues()[0]).cwiseMax(1e-300);
  const MatrixXd V = svd.matrixV();
  const MatrixXd inverse =
      inflation * V * singular.cwiseAbs2().cwiseInverse().asDiagonal() * V.transpose();
  const VectorXd weighted_response = search.whitened(out.response);
  const VectorXd shared =
      common_error / inflation * inverse * (weighted.transpose() * weighted_response);
  const MatrixXd relative = inverse + shared * shared.transpose();
  out.covariance = size.asDiagonal() * relative * size.asDiagonal();
  const VectorXd deviation = out.covariance.diagonal().cwiseSqrt();
  out.correlation = deviation.cwiseInverse().asDiagonal() * out.covariance *
                    deviation.cwiseInverse().asDiagonal();

  for (Index i = 0; i < k; ++i)
    if (std::sqrt(V.col(i).dot(relative * V.col(i))) > kUndetermined) out.are_told_apart = false;
  if (!out.are_told_apart) add_combinations(search, V, relative, size, out);
}

}  // namespace palpate::fem
