#pragma once

#include <cstdint>
#include <cstring>

#include "libfem/materials/pack.hpp"

namespace palpate::fem {

// Between points in memory (three numbers and a fourth that is zero) and Packs of a coordinate of
// eight lanes. A lane is one load or store of a whole point: number by number, gathering and
// scattering took as long as the kernel between them.

inline constexpr int kPointStride = 4;  ///< doubles from one point to the next

typedef double Quad __attribute__((vector_size(kPointStride * sizeof(double))));

PALPATE_INLINE void load_quad(const double* from, Quad& to) {
  std::memcpy(&to, from, sizeof(Quad));
}

/// to: x, y and z of point[lane], each lane one of `points` rows.
PALPATE_INLINE void gather_points(const double* points, const std::int32_t* point, Pack* to) {
  Pack pair[4];  // lanes k and k + 4
  for (int k = 0; k < 4; ++k) {
    Quad low, high;
    load_quad(points + std::ptrdiff_t{kPointStride} * point[k], low);
    load_quad(points + std::ptrdiff_t{kPointStride} * point[k + 4], high);
    pair[k] = __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7);
  }
  const Pack xz01 = __builtin_shufflevector(pair[0], pair[1], 0, 8, 2, 10, 4, 12, 6, 14);
  const Pack xz23 = __builtin_shufflevector(pair[2], pair[3], 0, 8, 2, 10, 4, 12, 6, 14);
  const Pack y01 = __builtin_shufflevector(pair[0], pair[1], 1, 9, 3, 11, 5, 13, 7, 15);
  const Pack y23 = __builtin_shufflevector(pair[2], pair[3], 1, 9, 3, 11, 5, 13, 7, 15);
  to[0] = __builtin_shufflevector(xz01, xz23, 0, 1, 8, 9, 4, 5, 12, 13);
  to[1] = __builtin_shufflevector(y01, y23, 0, 1, 8, 9, 4, 5, 12, 13);
  to[2] = __builtin_shufflevector(xz01, xz23, 2, 3, 10, 11, 6, 7, 14, 15);
}

/// points[point[lane]] += x, y and z of the lane, in the order of lanes.
PALPATE_INLINE void scatter_points(const Pack* from, const std::int32_t* point, double* points) {
  const Pack zero = Pack{};
  const Pack xy_even = __builtin_shufflevector(from[0], from[1], 0, 8, 2, 10, 4, 12, 6, 14);
  const Pack xy_odd = __builtin_shufflevector(from[0], from[1], 1, 9, 3, 11, 5, 13, 7, 15);
  const Pack z_even = __builtin_shufflevector(from[2], zero, 0, 8, 2, 10, 4, 12, 6, 14);
  const Pack z_odd = __builtin_shufflevector(from[2], zero, 1, 9, 3, 11, 5, 13, 7, 15);
  const Pack pair[4] = {// lanes k and k + 4
                        __builtin_shufflevector(xy_even, z_even, 0, 1, 8, 9, 4, 5, 12, 13),
                        __builtin_shufflevector(xy_odd, z_odd, 0, 1, 8, 9, 4, 5, 12, 13),
                        __builtin_shufflevector(xy_even, z_even, 2, 3, 10, 11, 6, 7, 14, 15),
                        __builtin_shufflevector(xy_odd, z_odd, 2, 3, 10, 11, 6, 7, 14, 15)};
  const auto add = [&](int lane, const Quad& force) {
    double* to = points + std::ptrdiff_t{kPointStride} * point[lane];
    Quad sum;
    load_quad(to, sum);
    sum += force;
    std::memcpy(to, &sum, sizeof(Quad));
  };
  for (int k = 0; k < 4; ++k) add(k, __builtin_shufflevector(pair[k], pair[k], 0, 1, 2, 3));
  for (int k = 0; k < 4; ++k) add(k + 4, __builtin_shufflevector(pair[k], pair[k], 4, 5, 6, 7));
}

}  // namespace palpate::fem
