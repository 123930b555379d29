#pragma once

#include <cstddef>
#include <cstdint>

#include "libfem/materials/element_kernel.hpp"

namespace palpate::fem {

/// Dense linear algebra of the factor, column by column; the lower triangle of a symmetric matrix
/// counts. Eigen computes it, compiled for AVX2 with FMA and once more without, so that every
/// processor that has both makes the same bytes (a wider vector would sum in another order). Its
/// blocks are those of one fixed cache, not of the processor's. Not safe on sizes below zero.
struct DenseKernels {
  /// Factors the first `own` columns of a front of `size` and subtracts their product from the
  /// others (partial Cholesky). False where it is not positive definite.
  bool (*factor_front)(float* front, int size, int own);
  bool (*factor_front_double)(double* front, int size, int own);
  /// Replaces a Cholesky factor by all entries of the inverse of its matrix.
  void (*invert_from_factor)(float* factor, int size);
  /// Factors a general matrix with row exchanges (LU); solves with the factors, in place of x.
  void (*factor_general)(float* matrix, int size, int* exchanges);
  void (*solve_general)(const float* factors, int size, const int* exchanges, float* x);
  /// y = A x of a symmetric and of a general square matrix.
  void (*multiply_symmetric)(const float* A, int size, const float* x, float* y);
  void (*multiply)(const double* A, int size, const double* x, double* y);
};

/// The kernels for an instruction set; those for AVX2 serve AVX-512 as well.
const DenseKernels& dense_kernels(InstructionSet set = best_instruction_set());

// How the panel of a supernode lies in memory, and how both halves of a solve read it: once and in
// the order of its numbers, one way and back, whatever is next fetched ahead.

/// Rows of a tile. A panel is one tile below the other, each column by column; the last one of the
/// triangle and of what is below may have fewer rows. The inverse of a tile's own triangle stands
/// in for it, so that a substitution is a product as well.
inline constexpr int kTileRows = 16;
/// Floats that are read, and then not used, past the end of all panels.
inline constexpr int kPanelPadding = kTileRows;

/// Numbers in a panel of `own` columns with `under` rows below its triangle. A tile of the triangle
/// has the columns up to its last row, zeros among them.
constexpr std::size_t panel_size(int own, int under) {
  std::size_t size = static_cast<std::size_t>(own) * static_cast<std::size_t>(under);
  for (int row = 0; row < own; row += kTileRows) {
    const int end = row + kTileRows < own ? row + kTileRows : own;
    size += static_cast<std::size_t>(end - row) * static_cast<std::size_t>(end);
  }
  return size;
}

/// Writes a panel from the columns of the factor, column major.
template <class Real>
void pack_panel(const Real* columns, int own, int under, float* out);
extern template void pack_panel(const float* columns, int own, int under, float* out);
extern template void pack_panel(const double* columns, int own, int under, float* out);

/// A supernode as its kernels see it. rows: node of each three rows below. x: unknowns, three to a
/// node. work: panel_work_size() numbers.
struct PanelTask {
  const float* panel;
  int own, under;
  const std::int32_t* rows;
  float* x;
  float* mine;  ///< the first of its own in x
  float* work;
};

constexpr std::size_t panel_work_size(int own, int under) {
  return static_cast<std::size_t>(kTileRows + 1) * static_cast<std::size_t>(own + kTileRows) +
         static_cast<std::size_t>(under + kTileRows);
}

/// With the triangle T and what is below it P: forward: mine = T^-1 mine, and what is below loses
/// P mine. backward: mine = T'^-1 (mine - P' x).
/// Results have the same bits on all instruction sets.
struct PanelKernels {
  void (*forward)(const PanelTask& task);
  void (*backward)(const PanelTask& task);
};

PanelKernels panel_kernels(InstructionSet set);

}  // namespace palpate::fem
