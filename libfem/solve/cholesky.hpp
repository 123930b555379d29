#pragma once

#include <cstdint>
#include <memory>

#include "libfem/solve/block_matrix.hpp"

namespace palpate::fem {

/// Sparse Cholesky factor of one pattern: analysed once, factored and applied many times.
/// CHOLMOD, supernodal, ordered by nested dissection of the node graph; one thread of BLAS, so the
/// result depends on nothing else that runs. Source: Chen, Davis, Hager, Rajamanickam 2008,
/// doi:10.1145/1391989.1391995.
class Cholesky {
 public:
  explicit Cholesky(const SymmetricBlockMatrix& pattern);
  ~Cholesky();
  Cholesky(Cholesky&&) noexcept;
  Cholesky& operator=(Cholesky&&) noexcept;

  /// Factors K, which has the pattern. False when K is not positive definite; no factor then.
  bool factor(const SymmetricBlockMatrix& K);
  bool is_factored() const;

  /// x = K^-1 b.
  void solve(const Eigen::VectorXd& b, Eigen::VectorXd& x) const;

  double factor_flops() const;       ///< of one factorization
  std::int64_t factor_entries() const;  ///< doubles in the factor

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace palpate::fem
