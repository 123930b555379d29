#include "libfem/solve/equilibrium/condensed_tangent.hpp"

#include <algorithm>
#include <iterator>

extern "C" {
// LAPACK, Fortran interface.
void spotrf_(const char* uplo, const int* n, float* a, const int* lda, int* info);
void spotri_(const char* uplo, const int* n, float* a, const int* lda, int* info);
void sgetrf_(const int* rows, const int* columns, float* a, const int* lda, int* pivots, int* info);
void sgetrs_(const char* trans, const int* n, const int* columns, const float* a, const int* lda,
             const int* pivots, float* b, const int* ldb, int* info);
void ssymv_(const char* uplo, const int* n, const float* alpha, const float* a, const int* lda,
            const float* x, const int* incx, const float* beta, float* y, const int* incy);
void dgemv_(const char* trans, const int* rows, const int* columns, const double* alpha,
            const double* a, const int* lda, const double* x, const int* incx, const double* beta,
            double* y, const int* incy);
}

namespace palpate::fem {
namespace {

// BLAS has them for the machine's own vectors; Eigen's are compiled for SSE2.
Eigen::VectorXf symmetric_product(const Eigen::MatrixXf& A, const Eigen::VectorXf& x) {
  const int size = static_cast<int>(A.rows()), next = 1;
  const float one = 1, zero = 0;
  Eigen::VectorXf out(size);
  if (size > 0)
    ssymv_("L", &size, &one, A.data(), &size, x.data(), &next, &zero, out.data(), &next);
  return out;
}

Eigen::VectorXd product(const Eigen::MatrixXd& A, const Eigen::VectorXd& x) {
  const int size = static_cast<int>(A.rows()), next = 1;
  const double one = 1, zero = 0;
  Eigen::VectorXd out(size);
  if (size > 0)
    dgemv_("N", &size, &size, &one, A.data(), &size, x.data(), &next, &zero, out.data(), &next);
  return out;
}

}  // namespace

void CondensedTangent::cover(const Eigen::MatrixXf& flexibility,
                             const std::vector<Eigen::Index>& touching) {
  constexpr double kTooMany = 1.25;  // a factorization costs twice as much
  const bool holds =
      std::includes(unknowns_.begin(), unknowns_.end(), touching.begin(), touching.end());
  if (holds &&
      static_cast<double>(unknowns_.size()) <= kTooMany * static_cast<double>(touching.size()))
    return;
  unknowns_ = touching;
  stiffness_ = flexibility(unknowns_, unknowns_);
  const int size = static_cast<int>(unknowns_.size());
  int info = 0;
  if (size > 0) spotrf_("L", &size, stiffness_.data(), &size, &info);
  if (size > 0) spotri_("L", &size, stiffness_.data(), &size, &info);
  stiffness_.triangularView<Eigen::StrictlyUpper>() = stiffness_.transpose();
}

void CondensedTangent::set_contact(Eigen::MatrixXd C) {
  C_ = std::move(C);
  const int size = static_cast<int>(unknowns_.size());
  factor_ = stiffness_ + C_.cast<float>();
  pivots_.resize(unknowns_.size());
  int info = 0;
  if (size > 0) sgetrf_(&size, &size, factor_.data(), &size, pivots_.data(), &info);
}

CondensedTangent::CondensedStep CondensedTangent::step(const Eigen::MatrixXf& flexibility,
                                                       const Eigen::VectorXd& residual) const {
  const int size = static_cast<int>(unknowns_.size()), columns = 1;
  Eigen::VectorXf own = residual(unknowns_).cast<float>();
  Eigen::VectorXd elsewhere = residual;
  elsewhere(unknowns_).setZero();
  if (!elsewhere.isZero(0)) {
    const Eigen::VectorXf driven = symmetric_product(flexibility, elsewhere.cast<float>());
    own += symmetric_product(stiffness_, driven(unknowns_));
  }
  int info = 0;
  if (size > 0)
    sgetrs_("N", &size, &columns, factor_.data(), &size, pivots_.data(), own.data(), &size, &info);
  CondensedStep out{{}, -residual};
  out.z(unknowns_) += product(C_, own.cast<double>());
  out.w = -symmetric_product(flexibility, out.z.cast<float>()).cast<double>();
  return out;
}

}  // namespace palpate::fem
