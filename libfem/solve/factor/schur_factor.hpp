#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "libfem/elements/block_matrix.hpp"

namespace palpate::fem {

/// No factor of this process may take more [bytes], 2e9 if nothing is said: SchurFactor::factor()
/// throws Error before it does. No result depends on it.
void bound_factor_memory(double bytes);

/// Cholesky factor of an elastic stiffness K whose contact nodes are eliminated last, so that what
/// the body looks like to the probe is one dense matrix S (the Schur complement), or its inverse,
/// the flexibility. Contact is then solved on the nodes that touch alone.
///
/// One nested dissection per body serves every set of contact nodes; the nodes are eliminated in
/// single precision by one thread, so results depend on nothing else that runs. The factor
/// preconditions: it need not be exact, and applying it is limited by memory. Where single
/// precision meets a pivot that is not positive, double precision is tried, and kept from then on.
/// Not thread-safe.
class SchurFactor {
 public:
  SchurFactor();
  ~SchurFactor();
  SchurFactor(SchurFactor&&) noexcept;
  SchurFactor& operator=(SchurFactor&&) noexcept;

  /// Factors K, always of the same pattern, with `contact_nodes` last. False when K is not positive
  /// definite even with the contact nodes held; there is no factor then. A body under high pressure
  /// may be held up by the probe alone: S is then indefinite, and the flexibility that of the body
  /// with springs on the contact nodes. Throws Error where memory is bounded below what it takes.
  bool factor(const SymmetricBlockMatrix& K, const std::vector<std::int32_t>& contact_nodes);
  bool is_factored() const;

  /// Nodes of the dense block in its order: entry 3 i + c is direction c of contact_nodes()[i].
  const std::vector<std::int32_t>& contact_nodes() const;
  /// S, all entries, without springs.
  const Eigen::MatrixXd& schur() const;
  /// Inverse of S, all entries [m/N], to single precision.
  const Eigen::MatrixXf& flexibility() const;

  /// Whether S + C is positive definite; C: lower triangle.
  bool is_stable_with(const Eigen::MatrixXd& C) const;

  /// x = K^-1 b, to single precision.
  void solve(const Eigen::VectorXd& b, Eigen::VectorXd& x);

  /// The two halves of a solve around the dense block: the load that S sees, and the displacement
  /// of all nodes once that of the contact nodes is known.
  void reduce(const Eigen::VectorXd& b, Eigen::VectorXd& reduced);
  void expand(const Eigen::VectorXd& contact_displacement, Eigen::VectorXd& x);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace palpate::fem
