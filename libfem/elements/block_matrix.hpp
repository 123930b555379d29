#pragma once

#include <cstdint>
#include <vector>

namespace palpate::fem {

/// Where a 3 x 3 block lives in a SymmetricBlockMatrix; base < 0 means nowhere (a held node).
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
  explicit SymmetricBlockMatrix(const std::vector<std::vector<std::int32_t>>& neighbours);

  int nodes() const { return static_cast<int>(block_start_.size()) - 1; }
  int size() const { return 3 * nodes(); }

  /// Place of block (row node, column node). Both must be coupled.
  BlockPlace place(std::int32_t row, std::int32_t column) const;

  void set_zero();

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
