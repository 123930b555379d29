#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "libfem/elements/block_matrix.hpp"
#include "libfem/solve/factor/dense_kernels.hpp"

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
/// panels: of each supernode, at panel_start: see dense_kernels.hpp.
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

  /// True if S + C is positive definite; C: lower triangle.
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
