#pragma once

#include "libfem/elements/block_matrix.hpp"

namespace palpate::fem {

/// Calls visit(row, column, value) for every entry of the lower triangle, column by column.
template <class Visit>
void visit_entries(const SymmetricBlockMatrix& K, Visit&& visit) {
  auto value = K.values().begin();
  for (int column = 0; column < K.size(); ++column) {
    const int node = column / 3;
    for (std::int32_t b = K.block_start()[node]; b < K.block_start()[node + 1]; ++b)
      for (int r = b == K.block_start()[node] ? column % 3 : 0; r < 3; ++r)
        visit(3 * K.block_row()[b] + r, column, *value++);
  }
}

inline Eigen::MatrixXd dense(const SymmetricBlockMatrix& K) {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(K.size(), K.size());
  visit_entries(
      K, [&](int row, int column, double value) { out(row, column) = out(column, row) = value; });
  return out;
}

}  // namespace palpate::fem
