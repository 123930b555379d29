#pragma once

#include <cstdint>
#include <vector>

#include "libfem/solve/factor/multifrontal.hpp"
#include "libfem/solve/factor/panel_kernels.hpp"

namespace palpate::fem {

/// Bounds the memory of each factor of this process [bytes], 2e9 by default: SchurFactor::factor()
/// throws Error where it would take more. No result depends on it.
void bound_factor_memory(double bytes);

/// Cholesky factor of an elastic stiffness K whose contact nodes are eliminated last, so that the
/// body acts on the probe as one dense matrix S (the Schur complement), or its inverse, the
/// flexibility. Contact is then solved on the nodes that touch alone.
///
/// One nested dissection per body serves every set of contact nodes; the nodes are eliminated in
/// single precision by one thread, so results depend on nothing else that runs. The factor
/// preconditions: it need not be exact, and applying it is limited by memory. Where single
/// precision meets a pivot that is not positive, double precision is tried, and kept from then on.
/// Not thread-safe.
class SchurFactor {
 public:
  /// Factors K, always of the same pattern, with `contact_nodes` last. False when K is not positive
  /// definite even with the contact nodes held; there is no factor then. A body under high pressure
  /// may be held up by the probe alone: S is then indefinite, and the flexibility that of the body
  /// with springs on the contact nodes. Throws Error where memory is bounded below what it takes.
  bool factor(const SymmetricBlockMatrix& K, const std::vector<std::int32_t>& contact_nodes);
  bool is_factored() const { return is_factored_; }

  /// Nodes of the dense block in its order: entry 3 i + c is direction c of contact_nodes()[i].
  const std::vector<std::int32_t>& contact_nodes() const { return plan_.last_nodes; }
  /// S, all entries, without springs.
  const Eigen::MatrixXd& schur() const { return frontal_.schur; }
  /// Inverse of S, all entries [m/N], to single precision.
  const Eigen::MatrixXf& flexibility() const { return flexibility_; }

  /// Whether S + C is positive definite; C: lower triangle.
  bool is_stable_with(const Eigen::MatrixXd& C) const;

  /// x = K^-1 b, to single precision.
  void solve(const Eigen::VectorXd& b, Eigen::VectorXd& x);

  /// The two halves of a solve around the dense block: the load that S sees, and the displacement
  /// of all nodes once that of the contact nodes is known.
  void reduce(const Eigen::VectorXd& b, Eigen::VectorXd& reduced);
  void expand(const Eigen::VectorXd& contact_displacement, Eigen::VectorXd& x);

 private:
  void analyse(const SymmetricBlockMatrix& K, const std::vector<std::int32_t>& contact_nodes);
  bool eliminate_and_invert(const SymmetricBlockMatrix& K);
  PanelTask task_of(int s);

  std::vector<std::int32_t> node_order_;  // of the pattern, whatever the contact nodes
  Elimination plan_;
  FrontalFactor frontal_;
  EliminationRoom<float> room_;
  EliminationRoom<double> double_room_;
  Eigen::MatrixXf flexibility_;
  bool is_factored_ = false;
  bool needs_double_ = false;  // single precision has failed where double has not
  PanelKernels kernels_ = panel_kernels(best_instruction_set());
  Eigen::VectorXf x_, work_;
};

}  // namespace palpate::fem
