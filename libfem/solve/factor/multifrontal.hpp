#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "libfem/elements/block_matrix.hpp"

namespace palpate::fem {

/// In which order nodes are eliminated, and which blocks of the factor are not zero; all in nodes,
/// each of which stands for three unknowns.
/// order: node at each place. place: its inverse. inner: places before the dense block of the last
/// nodes. Supernode s owns places first[s] .. first[s+1] (up to `inner`) and has the rows
/// rows[row_start[s] .. row_start[s+1]), increasing, its own among them.
/// parent: supernode that takes up what s leaves, -1 for the dense block. Children precede their
/// parents, and all below a supernode lies between its first child and itself (a post-order).
struct Elimination {
  std::vector<std::int32_t> order, place;
  std::int32_t inner = 0;
  std::vector<std::int32_t> last_nodes;  ///< as they follow each other in the dense block
  std::vector<std::int32_t> first, row_start, rows, parent;

  int supernodes() const { return static_cast<int>(first.size()) - 1; }
  int columns(int s) const { return first[s + 1] - first[s]; }
  int height(int s) const { return row_start[s + 1] - row_start[s]; }
};

/// Order of the nodes by nested dissection (METIS, Karypis and Kumar 1998,
/// doi:10.1137/S1064827595287997). Thread-safe; depends on its argument alone.
std::vector<std::int32_t> dissect(const SymmetricBlockMatrix& pattern);

/// The elimination that follows node_order but for `last_nodes`, which come last. (A separator
/// without some of its nodes still separates what is left, so one dissection serves every set.)
/// last_nodes come back empty where the body falls apart so that they would not be last.
/// Symbolic analysis by CHOLMOD of the graph of nodes, a ninth of that of unknowns (Chen, Davis,
/// Hager, Rajamanickam 2008, doi:10.1145/1391989.1391995). Thread-safe; depends on its arguments
/// alone.
Elimination analyse_elimination(const SymmetricBlockMatrix& pattern,
                                const std::vector<std::int32_t>& node_order,
                                const std::vector<std::int32_t>& last_nodes);

/// Numbers without a value until they are written, in room that stays: factors of one mesh follow
/// each other. To clear it and to ask for memory again takes 7 % of a press with drags.
template <class Real>
class ReusedNumbers {
 public:
  Real* at_least(std::size_t size) {
    if (size > size_) {
      values_.reset(new Real[size]);
      size_ = size;
    }
    return values_.get();
  }

 private:
  std::unique_ptr<Real[]> values_;
  std::size_t size_ = 0;
};

/// The front that is eliminated, and what supernodes leave to those above them.
template <class Real>
struct EliminationRoom {
  ReusedNumbers<Real> front, left;
};

/// Factor of K up to the dense block of its last nodes, in single precision.
/// panels: of each supernode, at panel_start: see panel_kernels.hpp.
/// schur: what is left on the last nodes (S), all entries, in double precision.
struct FrontalFactor {
  std::vector<float> panels;
  std::vector<std::size_t> panel_start;
  Eigen::MatrixXd schur;
};

/// What eliminate() takes at its largest, and what it leaves [bytes], in single precision.
double elimination_bytes(const Elimination& plan);

/// Eliminates K as planned, supernode by supernode, each in a small dense matrix that takes up what
/// its children leave (Duff and Reid 1983, doi:10.1145/356044.356047). Real: precision of the
/// arithmetic. False when a pivot before the dense block is not positive; S may be indefinite.
/// K must have the pattern of the plan.
template <class Real>
bool eliminate(const Elimination& plan, const SymmetricBlockMatrix& K, EliminationRoom<Real>& room,
               FrontalFactor& out);

extern template bool eliminate<float>(const Elimination&, const SymmetricBlockMatrix&,
                                      EliminationRoom<float>&, FrontalFactor&);
extern template bool eliminate<double>(const Elimination&, const SymmetricBlockMatrix&,
                                       EliminationRoom<double>&, FrontalFactor&);

}  // namespace palpate::fem
