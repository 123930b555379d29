#pragma once

#include "libfit/core/geometry.hpp"

/// Eigen's decompositions of matrices of any size, compiled once: each file that uses one itself
/// takes up to ten seconds longer to compile.
namespace palpate {

struct SymmetricEigen {
  Eigen::VectorXd values;   ///< ascending
  Eigen::MatrixXd vectors;  ///< a column each
};
struct SymmetricEigen3 {
  Vec3 values;
  Mat3 vectors;
};

/// Eigenvalues and orthonormal eigenvectors of a symmetric matrix.
SymmetricEigen symmetric_eigen(const Eigen::MatrixXd& A);
SymmetricEigen3 symmetric_eigen(const Mat3& A);

/// Those of A x = lambda B x, B positive definite; vectors are orthonormal in B.
SymmetricEigen symmetric_eigen(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B);

/// x of A x = b, and A^-1, by LDL^T of a symmetric A, positive or negative semidefinite.
Eigen::VectorXd ldlt_solve(const Eigen::MatrixXd& A, const Eigen::VectorXd& b);
Eigen::MatrixXd ldlt_inverse(const Eigen::MatrixXd& A);

/// X of A X = B by LU with partial pivoting.
Eigen::MatrixXd lu_solve(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B);

struct CholeskyInverse {
  Eigen::MatrixXd inverse;
  double log_determinant = 0;  ///< of A
  bool is_positive = false;    ///< definite; else the inverse is none
};

/// A^-1 of a symmetric positive definite A = L L^T, and L^-1.
CholeskyInverse cholesky_inverse(const Eigen::MatrixXd& A);
Eigen::MatrixXd inverse_cholesky_factor(const Eigen::MatrixXd& A);

struct TriangularSystem {
  Eigen::MatrixXd R;        ///< n x n, upper
  Eigen::VectorXd rotated;  ///< the first n of Q^T b
};

/// The least-squares problem A x = b, of n columns and as many rows or more, by A = Q R.
TriangularSystem triangular_system(const Eigen::MatrixXd& A, const Eigen::VectorXd& b);

/// x >= 0 minimising |R x - b|, R square, by active sets. Source: Lawson and Hanson, Solving Least
/// Squares Problems (1974), 23.3.
Eigen::VectorXd nonnegative_least_squares(const Eigen::MatrixXd& R, const Eigen::VectorXd& b);

/// x of least squares A x = b by QR with column pivoting; unknowns past the rank are 0.
Eigen::VectorXd pivoted_least_squares(const Eigen::MatrixXd& A, const Eigen::VectorXd& b);

}  // namespace palpate
