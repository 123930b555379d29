#include "libfem/solve/equilibrium/condensed_tangent.hpp"

#include <algorithm>
#include <iterator>

#include "libfem/solve/factor/dense_kernels.hpp"

namespace palpate::fem {
namespace {

Eigen::VectorXf symmetric_product(const Eigen::MatrixXf& A, const Eigen::VectorXf& x) {
  Eigen::VectorXf out(A.rows());
  dense_kernels().multiply_symmetric(A.data(), static_cast<int>(A.rows()), x.data(), out.data());
  return out;
}

Eigen::VectorXd product(const Eigen::MatrixXd& A, const Eigen::VectorXd& x) {
  Eigen::VectorXd out(A.rows());
  dense_kernels().multiply(A.data(), static_cast<int>(A.rows()), x.data(), out.data());
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
  dense_kernels().factor_front(stiffness_.data(), size, size);
  dense_kernels().invert_from_factor(stiffness_.data(), size);
}

void CondensedTangent::set_contact(Eigen::MatrixXd C) {
  C_ = std::move(C);
  factor_ = stiffness_ + C_.cast<float>();
  exchanges_.resize(unknowns_.size());
  dense_kernels().factor_general(factor_.data(), static_cast<int>(unknowns_.size()),
                                 exchanges_.data());
}

CondensedTangent::CondensedStep CondensedTangent::step(const Eigen::MatrixXf& flexibility,
                                                       const Eigen::VectorXd& residual) const {
  Eigen::VectorXf own = residual(unknowns_).cast<float>();
  Eigen::VectorXd elsewhere = residual;
  elsewhere(unknowns_).setZero();
  if (!elsewhere.isZero(0)) {
    const Eigen::VectorXf driven = symmetric_product(flexibility, elsewhere.cast<float>());
    own += symmetric_product(stiffness_, driven(unknowns_));
  }
  dense_kernels().solve_general(factor_.data(), static_cast<int>(unknowns_.size()),
                                exchanges_.data(), own.data());
  CondensedStep out{{}, -residual};
  out.z(unknowns_) += product(C_, own.cast<double>());
  out.w = -symmetric_product(flexibility, out.z.cast<float>()).cast<double>();
  return out;
}

}  // namespace palpate::fem
