#pragma once

#include <Eigen/Core>

namespace palpate {

/// Normal equations A x = b of a linear least squares problem whose rows have few entries.
struct NormalEquations {
  Eigen::MatrixXd A;
  Eigen::VectorXd b;

  explicit NormalEquations(Eigen::Index size)
      : A(Eigen::MatrixXd::Zero(size, size)), b(Eigen::VectorXd::Zero(size)) {}

  /// Adds weight (row . x - value)^2, row having `count` entries at these columns.
  void add(const double* row, const int* column, int count, double value, double weight);
  NormalEquations& operator+=(const NormalEquations& other);

  bool is_empty() const { return !(A.trace() > 0); }

  /// The least of the sum of squares + s x'prior x + s to_mean |x - mean|^2, s the mean diagonal of
  /// A: so the prior's weight does not depend on units. Where nothing is told a ridge of 1e-9
  /// decides.
  Eigen::VectorXd solve(const Eigen::MatrixXd& prior, double to_mean,
                        const Eigen::VectorXd& mean) const;
  Eigen::VectorXd solve(const Eigen::MatrixXd& prior) const;
};

/// The prior that uniform splines of `intervals` coefficients, `blocks` of them in turn, are
/// smooth and go to 0 at their end: the squares of second differences.
Eigen::MatrixXd second_differences(int intervals, int blocks);

}  // namespace palpate
