#pragma once

#include <cstddef>
#include <cstdint>

#include "libfem/materials/element_kernel.hpp"

namespace palpate::fem {

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
