#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "libfem/solve/block_matrix.hpp"

namespace palpate::fem {

/// Cholesky factor of an elastic stiffness K whose contact nodes are eliminated last, so that what
/// the body looks like to the probe is one dense matrix S (the Schur complement), and a new contact
/// stiffness C costs a dense factorization of S + C instead of a sparse one.
///
/// CHOLMOD, supernodal, ordered by nested dissection of the graph of the other nodes (Chen, Davis,
/// Hager, Rajamanickam 2008, doi:10.1145/1391989.1391995), one thread of BLAS, so results depend on
/// nothing else that runs. The factor is kept in single precision: it preconditions, and applying
/// it is limited by memory. Not thread-safe.
class SchurFactor {
 public:
  explicit SchurFactor(const SymmetricBlockMatrix& pattern);
  ~SchurFactor();
  SchurFactor(SchurFactor&&) noexcept;
  SchurFactor& operator=(SchurFactor&&) noexcept;

  /// Factors K, which has the pattern, with `contact_nodes` last. False when K is not positive
  /// definite even with springs on the contact nodes; there is no factor then. The springs are put
  /// on K for the factorization and taken off S again: a body under high pressure may be held up by
  /// the probe alone. Contact stiffness is zero until set_contact().
  bool factor(SymmetricBlockMatrix& K, const std::vector<std::int32_t>& contact_nodes);
  bool is_factored() const;

  /// Nodes of the dense block in its order: entry 3 i + c is direction c of contact_nodes()[i].
  const std::vector<std::int32_t>& contact_nodes() const;
  /// S, all entries.
  const Eigen::MatrixXd& schur() const;

  /// Takes S + C as the dense block from now on; C: lower triangle. False when that is not positive
  /// definite; the block then stays as it was.
  bool set_contact(const Eigen::MatrixXd& C);

  /// x = (K + C)^-1 b, to single precision.
  void solve(const Eigen::VectorXd& b, Eigen::VectorXd& x);

  /// The two halves of a solve around the dense block: the load that S sees, and the displacement of
  /// all nodes once that of the contact nodes is known.
  void reduce(const Eigen::VectorXd& b, Eigen::VectorXd& reduced);
  void expand(const Eigen::VectorXd& contact_displacement, Eigen::VectorXd& x);
  /// Solves with S + C.
  void solve_contact(const Eigen::VectorXd& b, Eigen::VectorXd& x) const;

  double factor_flops() const;          ///< of the latest factorization
  std::int64_t factor_entries() const;  ///< numbers in the factor

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace palpate::fem
