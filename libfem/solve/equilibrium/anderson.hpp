#pragma once

#include <Eigen/Core>
#include <cstddef>
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
  Eigen::VectorXd mix(const Eigen::VectorXd& d, const Eigen::VectorXd& b);

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
