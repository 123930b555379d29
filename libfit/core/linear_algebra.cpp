#include "libfit/core/linear_algebra.hpp"

#include <Eigen/Dense>

namespace palpate {

using Eigen::MatrixXd;
using Eigen::VectorXd;

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

}  // namespace palpate
