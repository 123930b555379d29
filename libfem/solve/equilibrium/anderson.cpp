#include "libfem/solve/equilibrium/anderson.hpp"

#include "libfit/core/linear_algebra.hpp"

namespace palpate::fem {

Eigen::VectorXd AndersonMixing::mix(const Eigen::VectorXd& d, const Eigen::VectorXd& b) {
  if (previous_.taken.size() > 0) {
    if (pairs_.size() >= depth_ && !pairs_.empty()) pairs_.erase(pairs_.begin());
    if (depth_ > 0) pairs_.push_back({previous_.taken, d - previous_.step, b - previous_.load});
  }
  previous_ = {{}, d, b};
  const auto count = static_cast<Eigen::Index>(pairs_.size());
  if (count == 0) return d;
  Eigen::MatrixXd gram(count, count);
  Eigen::VectorXd right(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    right[i] = pairs_[i].step.dot(b);
    for (Eigen::Index j = 0; j <= i; ++j)
      gram(i, j) = gram(j, i) = pairs_[i].step.dot(pairs_[j].load);
  }
  constexpr double kRounding = 1e-9;
  gram.diagonal().array() *= 1 + kRounding;
  const Eigen::VectorXd share = ldlt_solve(gram, right);
  Eigen::VectorXd out = d;
  if (!share.allFinite()) return out;
  for (Eigen::Index i = 0; i < count; ++i) out -= share[i] * (pairs_[i].taken + pairs_[i].step);
  return out;
}

}  // namespace palpate::fem
