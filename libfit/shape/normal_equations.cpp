#include "libfit/shape/normal_equations.hpp"

#include <algorithm>

#include "libfit/core/linear_algebra.hpp"

namespace palpate {

constexpr double kSlight = 1e-9;  // ridge where nothing is told, of the mean diagonal

void NormalEquations::add(const double* row, const int* column, int count, double value,
                          double weight) {
  for (int i = 0; i < count; ++i) {
    b[column[i]] += weight * row[i] * value;
    for (int j = 0; j < count; ++j) A(column[i], column[j]) += weight * row[i] * row[j];
  }
}

NormalEquations& NormalEquations::operator+=(const NormalEquations& other) {
  A += other.A;
  b += other.b;
  return *this;
}

Eigen::VectorXd NormalEquations::solve(const Eigen::MatrixXd& prior, double to_mean,
                                       const Eigen::VectorXd& mean) const {
  const double scale = is_empty() ? 1e-300 : A.trace() / static_cast<double>(A.rows());
  Eigen::MatrixXd all = A + scale * prior;
  all.diagonal().array() += scale * (to_mean + kSlight);
  return ldlt_solve(all, b + scale * to_mean * mean);
}

Eigen::VectorXd NormalEquations::solve(const Eigen::MatrixXd& prior) const {
  return solve(prior, 0, Eigen::VectorXd::Zero(b.size()));
}

Eigen::MatrixXd second_differences(int intervals, int blocks) {
  constexpr double kDifference[3] = {1, -2, 1};
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(intervals * blocks, intervals * blocks);
  for (int block = 0; block < blocks; ++block)
    for (int j = 0; j < intervals; ++j) {
      Eigen::VectorXd d = Eigen::VectorXd::Zero(intervals * blocks);
      for (int k = 0; k < 3; ++k)
        if (j + k < intervals) d[block * intervals + j + k] = kDifference[k];
      out += d * d.transpose();
    }
  return out;
}

}  // namespace palpate
