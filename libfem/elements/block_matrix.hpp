#pragma once

#include <algorithm>
#include <cassert>
#include <cstdint>
#include <vector>

#include "libfem/mesh/topology.hpp"

namespace palpate::fem {

/// Position of a 3 x 3 block in a SymmetricBlockMatrix; base < 0 means nowhere (a held node).
/// is_swapped: the pair's second node comes later, so the block is stored transposed.
struct BlockPlace {
  std::int32_t base = -1;
  std::int32_t length = 0;
  bool is_swapped = false;
  bool is_diagonal = false;
};

/// Symmetric matrix of 3 x 3 blocks over n nodes, stored as the lower triangle of a scalar matrix
/// in compressed columns (row indices increasing).
class SymmetricBlockMatrix {
 public:
  /// neighbours: per node, the nodes coupled to it; order and repeats do not matter, the node
  /// itself is implied.
  explicit SymmetricBlockMatrix(const std::vector<std::vector<std::int32_t>>& neighbours) {
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

  int nodes() const { return static_cast<int>(block_start_.size()) - 1; }
  int size() const { return 3 * nodes(); }

  /// Place of block (row node, column node). Both must be coupled.
  BlockPlace place(std::int32_t row, std::int32_t column) const {
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

  void set_zero() { std::fill(values_.begin(), values_.end(), 0.0); }

  /// Adds a 3 x 3 block given row major with element (i, j) at block[stride * (3 i + j)].
  void add(const BlockPlace& place, const double* block, int stride = 1) {
    if (place.base < 0) return;
    // Columns of the lower triangle shorten by one and by two inside the diagonal block.
    double* column[3] = {values_.data() + place.base,
                         values_.data() + place.base + place.length - 1,
                         values_.data() + place.base + 2 * place.length - 3};
    for (int j = 0; j < 3; ++j)
      for (int i = place.is_diagonal ? j : 0; i < 3; ++i)
        column[j][i] += block[stride * (place.is_swapped ? 3 * j + i : 3 * i + j)];
  }

  const std::vector<std::int32_t>& column_start() const { return column_start_; }
  const std::vector<double>& values() const { return values_; }
  /// Node graph, lower triangle with diagonal: rows of column node j are rows()[starts()[j]...].
  const std::vector<std::int32_t>& block_start() const { return block_start_; }
  const std::vector<std::int32_t>& block_row() const { return block_row_; }

 private:
  std::vector<std::int32_t> block_start_, block_row_, column_start_;
  std::vector<double> values_;
};

}  // namespace palpate::fem
