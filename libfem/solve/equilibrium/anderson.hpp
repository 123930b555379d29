#pragma once

#include <Eigen/Cholesky>
#include <algorithm>
#include <vector>

namespace palpate::fem {

/// Anderson mixing of the fixed-point iteration u <- u + d(u), where K d = b with a symmetric
/// positive definite K that stays the same: the next iterate is the combination of the last ones
/// whose d is smallest in the norm of K. Linear problems then converge as fast as under GMRES.
/// Source: Walker and Ni 2011, doi:10.1137/10078356X.
class AndersonMixing {
 public:
  explicit AndersonMixing(int depth) : depth_(static_cast<std::size_t>(depth)) {}

  /// Forgets what was before.
  void reset() {
    previous_ = {};
    pairs_.clear();
  }

  /// The step to take in place of d, which is d at first.
  Eigen::VectorXd mix(const Eigen::VectorXd& d, const Eigen::VectorXd& b) {
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
    const Eigen::VectorXd share = gram.ldlt().solve(right);
    Eigen::VectorXd out = d;
    if (!share.allFinite()) return out;
    for (Eigen::Index i = 0; i < count; ++i) out -= share[i] * (pairs_[i].taken + pairs_[i].step);
    return out;
  }

  /// What u has moved by since mix().
  void took(const Eigen::VectorXd& step) { previous_.taken = step; }

 private:
  struct SecantPair {
    Eigen::VectorXd taken, step, load;  // of one iterate, and changes of d and b to the next
  };
  std::size_t depth_;
  SecantPair previous_;
  std::vector<SecantPair> pairs_;
};

}  // namespace palpate::fem
