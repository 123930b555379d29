#pragma once

#include "libfit/core/geometry.hpp"

namespace palpate::testing_support {

/// A block [m] of 12 triangles.
inline Surface coarse_block(double x, double y, double z) {
  Surface block;
  block.vertices.resize(8, 3);
  for (int v = 0; v < 8; ++v)
    block.vertices.row(v) << (v & 1 ? x : 0), (v & 2 ? y : 0), (v & 4 ? z : 0);
  block.triangles.resize(12, 3);
  block.triangles << 0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3, 0, 4,
      6, 0, 6, 2, 1, 3, 7, 1, 7, 5;
  return block;
}

}  // namespace palpate::testing_support
