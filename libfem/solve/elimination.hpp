#pragma once

#include <cstdint>
#include <vector>

#include "libfem/solve/block_matrix.hpp"

namespace palpate::fem {

/// In which order unknowns are eliminated, and what of the factor is not zero.
/// order: unknown at each place. inner: places before the dense block of the last nodes. Supernode s
/// owns columns first[s] .. first[s+1] (up to `inner`) and has the rows
/// rows[row_start[s] .. row_start[s+1]), increasing, its own columns among them.
struct Elimination {
  std::vector<std::int32_t> order;
  std::int32_t inner = 0;
  std::vector<std::int32_t> last_nodes;  ///< as they follow each other in the dense block
  std::vector<std::int32_t> first, row_start, rows;
  double flops = 0;
};

/// Order of the nodes by nested dissection (METIS, Karypis and Kumar 1998,
/// doi:10.1137/S1064827595287997). Thread-safe; depends on its argument alone.
std::vector<std::int32_t> dissect(const SymmetricBlockMatrix& pattern);

/// The elimination that follows node_order but for `last_nodes`, which come last. (A separator without
/// some of its nodes still separates what is left, so one dissection serves every set of them.)
/// last_nodes come back empty where the body falls apart so that they would not be last.
/// Symbolic analysis by CHOLMOD (Chen, Davis, Hager, Rajamanickam 2008,
/// doi:10.1145/1391989.1391995). Thread-safe; depends on its arguments alone.
Elimination analyse_elimination(const SymmetricBlockMatrix& pattern,
                                const std::vector<std::int32_t>& node_order,
                                const std::vector<std::int32_t>& last_nodes);

}  // namespace palpate::fem
