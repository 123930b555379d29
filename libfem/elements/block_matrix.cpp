#include "libfem/elements/block_matrix.hpp"

#include <algorithm>
#include <cassert>

namespace palpate::fem {

SymmetricBlockMatrix::SymmetricBlockMatrix(
    const std::vector<std::vector<std::int32_t>>& neighbours) {
  const auto n = static_cast<std::int32_t>(neighbours.size());
  block_start_.push_back(0);
  for (std::int32_t j = 0; j < n; ++j) {
    std::vector<std::int32_t> rows{j};
    for (const std::int32_t i : neighbours[j])
      if (i > j) rows.push_back(i);
    std::sort(rows.begin(), rows.end());
    rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
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

void SymmetricBlockMatrix::multiply(const Eigen::VectorXd& x, Eigen::VectorXd& y) const {
  y.setZero(size());
  for (int j = 0; j < nodes(); ++j) {
    const double* c0 = values_.data() + column_start_[3 * j];
    const double* c1 = values_.data() + column_start_[3 * j + 1] - 1;
    const double* c2 = values_.data() + column_start_[3 * j + 2] - 2;
    const double x0 = x[3 * j], x1 = x[3 * j + 1], x2 = x[3 * j + 2];
    double y0 = c0[0] * x0 + c0[1] * x1 + c0[2] * x2;
    double y1 = c0[1] * x0 + c1[1] * x1 + c1[2] * x2;
    double y2 = c0[2] * x0 + c1[2] * x1 + c2[2] * x2;
    for (std::int32_t b = block_start_[j] + 1; b < block_start_[j + 1]; ++b) {
      c0 += 3;
      c1 += 3;
      c2 += 3;
      const double* xi = x.data() + 3 * block_row_[b];
      double* yi = y.data() + 3 * block_row_[b];
      y0 += c0[0] * xi[0] + c0[1] * xi[1] + c0[2] * xi[2];
      y1 += c1[0] * xi[0] + c1[1] * xi[1] + c1[2] * xi[2];
      y2 += c2[0] * xi[0] + c2[1] * xi[1] + c2[2] * xi[2];
      yi[0] += c0[0] * x0 + c1[0] * x1 + c2[0] * x2;
      yi[1] += c0[1] * x0 + c1[1] * x1 + c2[1] * x2;
      yi[2] += c0[2] * x0 + c1[2] * x1 + c2[2] * x2;
    }
    y[3 * j] += y0;
    y[3 * j + 1] += y1;
    y[3 * j + 2] += y2;
  }
}

Eigen::VectorXd SymmetricBlockMatrix::diagonal() const {
  Eigen::VectorXd out(size());
  for (int i = 0; i < size(); ++i) out[i] = values_[column_start_[i]];
  return out;
}

}  // namespace palpate::fem
