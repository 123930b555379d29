#include "libfem/solve/factor/dense_kernels.hpp"

#include <algorithm>
#include <cstring>

namespace palpate::fem {
namespace {

typedef float Wide __attribute__((vector_size(kTileRows * sizeof(float))));
typedef float Half __attribute__((vector_size(kTileRows / 2 * sizeof(float))));
typedef float Four __attribute__((vector_size(4 * sizeof(float))));

// Floats between what is read and what is fetched.
constexpr std::ptrdiff_t kAhead = 4096;

PALPATE_INLINE void load(const float* from, Wide& to) { std::memcpy(&to, from, sizeof(Wide)); }

/// sum = A x over the columns of a tile; lanes past its rows are of no meaning.
PALPATE_INLINE void multiply_tile(const float* A, int rows, int columns, const float* x,
                                  Wide& sum) {
  Wide part[4] = {};  // no long chain of additions
  int c = 0;
  for (; c + 4 <= columns; c += 4, A += std::ptrdiff_t{4} * rows)
    for (int k = 0; k < 4; ++k) {
      Wide column;
      load(A + std::ptrdiff_t{rows} * k, column);
      __builtin_prefetch(A + std::ptrdiff_t{rows} * k + kAhead, 0, 1);
      part[k] += column * x[c + k];
    }
  for (; c < columns; ++c, A += rows) {
    Wide column;
    load(A, column);
    part[0] += column * x[c];
  }
  sum = (part[0] + part[1]) + (part[2] + part[3]);
}

/// sums[c] += A_c * x, lane by lane, last column first; x is zero past the rows of the tile.
PALPATE_INLINE void add_columns(const float* A, int rows, int columns, const float* x,
                                float* sums) {
  Wide factor;
  load(x, factor);
  for (int c = columns - 1; c >= 0; --c) {
    const float* at = A + std::ptrdiff_t{rows} * c;
    Wide column, sum;
    load(at, column);
    __builtin_prefetch(at - kAhead, 0, 1);
    load(sums + std::ptrdiff_t{kTileRows} * c, sum);
    sum += column * factor;
    std::memcpy(sums + std::ptrdiff_t{kTileRows} * c, &sum, sizeof(Wide));
  }
}

/// Sum over the lanes of each of four.
PALPATE_INLINE void sum_lanes(const float* sums, Four& out) {
  Four part[4];
  for (int c = 0; c < 4; ++c) {
    Wide wide;
    load(sums + std::ptrdiff_t{kTileRows} * c, wide);
    const Half half = __builtin_shufflevector(wide, wide, 0, 1, 2, 3, 4, 5, 6, 7) +
                      __builtin_shufflevector(wide, wide, 8, 9, 10, 11, 12, 13, 14, 15);
    part[c] = __builtin_shufflevector(half, half, 0, 1, 2, 3) +
              __builtin_shufflevector(half, half, 4, 5, 6, 7);
  }
  const Four a = __builtin_shufflevector(part[0], part[1], 0, 4, 1, 5),
             b = __builtin_shufflevector(part[0], part[1], 2, 6, 3, 7),
             c = __builtin_shufflevector(part[2], part[3], 0, 4, 1, 5),
             d = __builtin_shufflevector(part[2], part[3], 2, 6, 3, 7);
  const Four ab = a + b, cd = c + d;
  out = __builtin_shufflevector(ab, cd, 0, 1, 4, 5) + __builtin_shufflevector(ab, cd, 2, 3, 6, 7);
}

constexpr int round_up(int count, int to) { return (count + to - 1) / to * to; }

PALPATE_INLINE void forward(const PanelTask& task) {
  const int own = task.own, under = task.under;
  float* solved = task.work;
  const float* A = task.panel;
  Wide sum;
  for (int row = 0; row < own; row += kTileRows) {
    const int rows = std::min(kTileRows, own - row);
    multiply_tile(A, rows, row, solved, sum);
    A += std::ptrdiff_t{rows} * row;
    float rest[kTileRows];
    for (int r = 0; r < rows; ++r) rest[r] = task.mine[row + r] - sum[r];
    multiply_tile(A, rows, rows, rest, sum);
    std::memcpy(solved + row, &sum, sizeof(Wide));
    A += std::ptrdiff_t{rows} * rows;
  }
  std::copy_n(solved, own, task.mine);
  float* below = solved + own + kTileRows;
  for (int row = 0; row < under; row += kTileRows) {
    const int rows = std::min(kTileRows, under - row);
    multiply_tile(A, rows, own, solved, sum);
    std::memcpy(below + row, &sum, sizeof(Wide));
    A += std::ptrdiff_t{rows} * own;
  }
  for (int r = 0; r < under; r += 3) {
    float* x = task.x + std::ptrdiff_t{3} * task.rows[r / 3];
    x[0] -= below[r];
    x[1] -= below[r + 1];
    x[2] -= below[r + 2];
  }
}

/// out[c] = the sum of the kTileRows numbers of column c.
PALPATE_INLINE void sum_columns(const float* sums, int columns, float* out) {
  for (int c = 0; c < columns; c += 4) {
    Four four;
    sum_lanes(sums + std::ptrdiff_t{kTileRows} * c, four);
    for (int k = 0; k < 4 && c + k < columns; ++k) out[c + k] = four[k];
  }
}

PALPATE_INLINE void backward(const PanelTask& task) {
  const int own = task.own, under = task.under;
  float* below = task.work;
  float* sums = below + under + kTileRows;  // kTileRows to a column
  for (int r = 0; r < under; r += 3) {
    const float* x = task.x + std::ptrdiff_t{3} * task.rows[r / 3];
    below[r] = x[0];
    below[r + 1] = x[1];
    below[r + 2] = x[2];
  }
  std::fill_n(below + under, kTileRows, 0.0F);
  std::fill_n(sums, std::ptrdiff_t{kTileRows} * (own + kTileRows), 0.0F);
  const float* A = task.panel + panel_size(own, under);
  for (int row = round_up(under, kTileRows) - kTileRows; row >= 0; row -= kTileRows) {
    const int rows = std::min(kTileRows, under - row);
    A -= std::ptrdiff_t{rows} * own;
    add_columns(A, rows, own, below + row, sums);
  }
  for (int row = round_up(own, kTileRows) - kTileRows; row >= 0; row -= kTileRows) {
    const int rows = std::min(kTileRows, own - row);
    float rest[kTileRows] = {}, solved[kTileRows] = {}, products[kTileRows * kTileRows] = {};
    sum_columns(sums + std::ptrdiff_t{kTileRows} * row, rows, rest);
    for (int r = 0; r < rows; ++r) rest[r] = task.mine[row + r] - rest[r];
    A -= std::ptrdiff_t{rows} * rows;
    add_columns(A, rows, rows, rest, products);
    sum_columns(products, rows, solved);
    std::copy_n(solved, rows, task.mine + row);
    A -= std::ptrdiff_t{rows} * row;
    add_columns(A, rows, row, solved, sums);
  }
}

#define PALPATE_PANEL_KERNELS(set, target)                            \
  target void forward_##set(const PanelTask& task) { forward(task); } \
  target void backward_##set(const PanelTask& task) { backward(task); }

PALPATE_PANEL_KERNELS(portable, )
PALPATE_PANEL_KERNELS(avx2, __attribute__((target("avx2"))))
PALPATE_PANEL_KERNELS(avx512, __attribute__((target("avx512f"))))
#undef PALPATE_PANEL_KERNELS

/// Inverse of a lower triangle of up to kTileRows rows, zero above it; both column major.
template <class Real>
void invert_triangle(const Real* L, std::ptrdiff_t stride, int size, Real* out) {
  for (int j = 0; j < size; ++j) {
    Real* x = out + std::ptrdiff_t{size} * j;
    std::fill_n(x, size, Real{0});
    x[j] = 1;
    for (int k = j; k < size; ++k) {
      x[k] /= L[stride * k + k];
      for (int i = k + 1; i < size; ++i) x[i] -= L[stride * k + i] * x[k];
    }
  }
}

}  // namespace

// A strip of columns at a time, so that neither what is read nor what is written jumps at each.
template <class Real>
void pack_panel(const Real* columns, int own, int under, float* out) {
  const std::ptrdiff_t height = own + under;
  for (int strip = 0; strip < own; strip += kTileRows) {
    float* tile = out;
    for (int row = 0; row < own + under;) {
      const bool has_triangle = row < own;
      const int end = std::min(row + kTileRows, has_triangle ? own : own + under);
      const std::ptrdiff_t rows = end - row;
      const int full = std::min(strip + kTileRows, has_triangle ? row : own);
      for (int c = strip; c < full; ++c)
        for (std::ptrdiff_t r = 0; r < rows; ++r)
          tile[rows * c + r] = static_cast<float>(columns[height * c + row + r]);
      if (has_triangle && row == strip) {
        Real inverse[kTileRows * kTileRows];
        invert_triangle(columns + height * row + row, height, static_cast<int>(rows), inverse);
        std::copy_n(inverse, rows * rows, tile + rows * row);
      }
      tile += rows * (has_triangle ? end : own);
      row = end;
    }
  }
}
template void pack_panel(const float* columns, int own, int under, float* out);
template void pack_panel(const double* columns, int own, int under, float* out);

PanelKernels panel_kernels(InstructionSet set) {
  switch (set) {
    case InstructionSet::avx512:
      return {forward_avx512, backward_avx512};
    case InstructionSet::avx2:
      return {forward_avx2, backward_avx2};
    default:
      return {forward_portable, backward_portable};
  }
}

}  // namespace palpate::fem
