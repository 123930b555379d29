#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "libfem/solve/block_matrix.hpp"

namespace palpate::fem {

/// Cholesky factor of an elastic stiffness K whose contact nodes are left for the end: what the body
/// looks like to the probe is then one dense matrix S (the Schur complement), and a new contact
/// stiffness C costs a dense factorization of S + C instead of a sparse one.
///
/// Multifrontal (Liu 1992, doi:10.1137/1034004) on the elimination that CHOLMOD analysed, in single
/// precision: the factor preconditions, its arithmetic is twice as fast and half as long to read, and
/// S comes out without being factored, so a body that only the probe holds up is no trouble. One
/// thread of BLAS, so results depend on nothing else that runs. Not thread-safe.
class SchurFactor {
 public:
  SchurFactor();
  ~SchurFactor();
  SchurFactor(SchurFactor&&) noexcept;
  SchurFactor& operator=(SchurFactor&&) noexcept;

  /// Factors K, always of one pattern, with `contact_nodes` (at least) in the dense block; an earlier analysis is used again
  /// while its block holds them and is not much larger. False when K without the contact nodes is not
  /// positive definite; there is no factor then. Contact stiffness is zero until set_contact().
  bool factor(const SymmetricBlockMatrix& K, const std::vector<std::int32_t>& contact_nodes);
  bool is_factored() const;

  /// Nodes of the dense block in its order: entry 3 i + c is direction c of contact_nodes()[i].
  const std::vector<std::int32_t>& contact_nodes() const;
  /// S, all entries, to single precision.
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
  /// x = (S + C)^-1 b.
  void solve_contact(const Eigen::VectorXd& b, Eigen::VectorXd& x) const;

  double factor_flops() const;  ///< of a whole factorization, dense block included

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace palpate::fem
