#include "libfem/elements/block_matrix.hpp"

#include <algorithm>
#include <cassert>

#include "libfem/mesh/topology.hpp"

namespace palpate::fem {

SymmetricBlockMatrix::SymmetricBlockMatrix(
    const std::vector<std::vector<std::int32_t>>& neighbours) {
  const auto n = static_cast<std::int32_t>(neighbours.size());
  block_start_.push_back(0);
  for (std::int32_t j = 0; j < n; ++j) {
    std::vector<std::int32_t> rows{j};
    for (const std::int32_t i : neighbours[j])
      if (i > j) rows.push_back(i);
    sort_unique(rows);
    block_row_.insert(block_row_.end(), rows.begin(), rows.end());
    block_start_.push_back(static_cast<std::int32_t>(block_row_.size()));
  }
  column_start_.push_back(0);
  for (std::int32_t j = 0; j < n; ++j)
    for (int c = 0; c < 3; ++c)
      column_start_.push_back(column_start_.back() + 3 * (block_start_[j + 1] - block_start_[j]) -
                              c);
  values_.assign(static_cast<std::size_t>(column_start_.back()), 0.0);
}

BlockPlace SymmetricBlockMatrix::place(std::int32_t row, std::int32_t column) const {
  if (row < 0 || column < 0) return {};
  BlockPlace out;
  out.is_swapped = row < column;
  out.is_diagonal = row == column;
  const std::int32_t j = std::min(row, column), i = std::max(row, column);
  const auto first = block_row_.begin() + block_start_[j],
             last = block_row_.begin() + block_start_[j + 1];
  const auto found = std::lower_bound(first, last, i);
  assert(found != last && *found == i);
  out.base = column_start_[3 * j] + 3 * static_cast<std::int32_t>(found - first);
  out.length = column_start_[3 * j + 1] - column_start_[3 * j];
  return out;
}

void SymmetricBlockMatrix::set_zero() { std::fill(values_.begin(), values_.end(), 0.0); }

}  // namespace palpate::fem
