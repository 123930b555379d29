#pragma once

#include <Eigen/Core>
#include <vector>

namespace palpate::recordings {

/// argmin |A x - b|^2 over x >= 0, from the Gram matrix A'A (n x n) and A'b. Equal columns are
/// taken once. Source: Lawson and Hanson, Solving Least Squares Problems (1974), 23.3.
Eigen::VectorXd nonnegative_least_squares(const Eigen::MatrixXd& gram,
                                          const Eigen::VectorXd& right);

}  // namespace palpate::recordings
