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
}

namespace palpate::fem {

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
  Eigen::VectorXf driven = flexibility * residual.cast<float>();
  Eigen::VectorXf own = stiffness_ * driven(unknowns_);
  int info = 0;
  if (size > 0)
    sgetrs_("N", &size, &columns, factor_.data(), &size, pivots_.data(), own.data(), &size, &info);
  CondensedStep out{{}, -residual};
  const Eigen::VectorXd pushed = C_ * own.cast<double>();
  for (int i = 0; i < size; ++i) out.z[unknowns_[i]] += pushed[i];
  driven.noalias() -= flexibility(Eigen::all, unknowns_) * pushed.cast<float>();
  out.w = driven.cast<double>();
  return out;
}

}  // namespace palpate::fem
