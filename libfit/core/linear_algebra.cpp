#include "libfit/core/linear_algebra.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <limits>
#include <vector>

namespace palpate {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

// Least squares over the columns of R that are free; the others stay zero.
VectorXd solve_free(const MatrixXd& R, const VectorXd& b, const std::vector<char>& is_free) {
  std::vector<Eigen::Index> columns;
  for (Eigen::Index j = 0; j < R.cols(); ++j)
    if (is_free[j]) columns.push_back(j);
  const VectorXd part = pivoted_least_squares(R(Eigen::all, columns), b);
  VectorXd x = VectorXd::Zero(R.cols());
  x(columns) = part;
  return x;
}

}  // namespace

SymmetricEigen symmetric_eigen(const MatrixXd& A) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(A);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

SymmetricEigen3 symmetric_eigen(const Mat3& A) {
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(A);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

SymmetricEigen symmetric_eigen(const MatrixXd& A, const MatrixXd& B) {
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> solver(A, B);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

VectorXd ldlt_solve(const MatrixXd& A, const VectorXd& b) { return A.ldlt().solve(b); }

MatrixXd ldlt_inverse(const MatrixXd& A) {
  return A.ldlt().solve(MatrixXd::Identity(A.rows(), A.rows()));
}

MatrixXd lu_solve(const MatrixXd& A, const MatrixXd& B) { return A.partialPivLu().solve(B); }

CholeskyInverse cholesky_inverse(const MatrixXd& A) {
  const Eigen::LLT<MatrixXd> factor(A);
  return {factor.solve(MatrixXd::Identity(A.rows(), A.rows())),
          2 * factor.matrixLLT().diagonal().array().log().sum(), factor.info() == Eigen::Success};
}

MatrixXd inverse_cholesky_factor(const MatrixXd& A) {
  const MatrixXd L = A.llt().matrixL();
  return L.triangularView<Eigen::Lower>().solve(MatrixXd::Identity(A.rows(), A.rows()));
}

TriangularSystem triangular_system(const MatrixXd& A, const VectorXd& b) {
  const Eigen::HouseholderQR<MatrixXd> qr(A);
  return {qr.matrixQR().topRows(A.cols()).triangularView<Eigen::Upper>(),
          (qr.householderQ().transpose() * b).head(A.cols())};
}

VectorXd pivoted_least_squares(const MatrixXd& A, const VectorXd& b) {
  return A.colPivHouseholderQr().solve(b);
}

VectorXd nonnegative_least_squares(const MatrixXd& R, const VectorXd& b) {
  const Eigen::Index n = R.cols();
  std::vector<char> is_free(n, 0);
  VectorXd x = VectorXd::Zero(n);
  const double tiny =
      64 * std::numeric_limits<double>::epsilon() * R.norm() * std::max(b.norm(), 1e-300);
  for (int round = 0; round < 4 * n; ++round) {
    const VectorXd descent = R.transpose() * (b - R * x);
    Eigen::Index enter = -1;
    for (Eigen::Index j = 0; j < n; ++j)
      if (!is_free[j] && descent[j] > tiny && (enter < 0 || descent[j] > descent[enter])) enter = j;
    if (enter < 0) break;
    is_free[enter] = 1;
    VectorXd next = solve_free(R, b, is_free);
    if (!(next[enter] > 0)) {  // rounding let a column in that only wants out again
      is_free[enter] = 0;
      break;
    }
    while (true) {
      double step = 1;
      Eigen::Index leave = -1;  // the free column that reaches zero first
      for (Eigen::Index j = 0; j < n; ++j) {
        if (!is_free[j] || next[j] > 0) continue;
        const double reach = x[j] > 0 ? x[j] / (x[j] - next[j]) : 0;
        if (leave < 0 || reach < step) step = reach, leave = j;
      }
      if (leave < 0) break;
      x += step * (next - x);
      x[leave] = 0;
      is_free[leave] = 0;
      next = solve_free(R, b, is_free);
    }
    x = next;
  }
  return x;
}

}  // namespace palpate
