#pragma once

#include <Eigen/Core>
#include <vector>

namespace palpate::fem {

/// Newton's matrix of contact on the dense block of a factor, in the unknowns that touch.
/// With the flexibility G of the block, its displacement w and what contact is taken to exert z,
/// w + G z is given, and contact asks for z = f(w) with the derivative C, not symmetric under
/// friction. Not thread-safe.
class CondensedTangent {
 public:
  /// Of w [m] and z [N], over the dense block.
  struct CondensedStep {
    Eigen::VectorXd w, z;
  };

  /// Forgets everything: the flexibility is another one.
  void clear() {
    unknowns_.clear();
    stiffness_.resize(0, 0);
  }
  bool is_empty() const { return unknowns_.empty(); }

  /// Makes these unknowns of the block (increasing) its own. Keeps those it has where they hold
  /// these and not many more.
  void cover(const Eigen::MatrixXf& flexibility, const std::vector<Eigen::Index>& touching);
  const std::vector<Eigen::Index>& unknowns() const { return unknowns_; }

  /// Takes C on unknowns() [N/m] and factors.
  void set_contact(Eigen::MatrixXd C);

  /// Newton's step for the residual z - f(w) of the block [N]: dw solves dw + G C dw = G (z - f),
  /// and dz = C dw - (z - f).
  CondensedStep step(const Eigen::MatrixXf& flexibility, const Eigen::VectorXd& residual) const;

 private:
  std::vector<Eigen::Index> unknowns_;
  Eigen::MatrixXf stiffness_;  // of the body on unknowns(): inverse of their flexibility
  Eigen::MatrixXd C_;
  Eigen::MatrixXf factor_;      // of the sum of both
  std::vector<int> exchanges_;  // of rows, in factor_
};

}  // namespace palpate::fem
