#pragma once

#include <Eigen/Core>
#include <vector>

#include "libfem/solve/factor/elimination.hpp"

namespace palpate::fem {

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
bool eliminate(const Elimination& plan, const SymmetricBlockMatrix& K, FrontalFactor& out);

extern template bool eliminate<float>(const Elimination&, const SymmetricBlockMatrix&,
                                      FrontalFactor&);
extern template bool eliminate<double>(const Elimination&, const SymmetricBlockMatrix&,
                                       FrontalFactor&);

}  // namespace palpate::fem
