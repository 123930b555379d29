#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "libfem/solve/factor/elimination.hpp"

namespace palpate::fem {

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
