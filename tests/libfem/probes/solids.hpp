#pragma once

#include "tests/support/surfaces.hpp"

namespace palpate::fem {

inline Surface ball_mesh(double radius_m, int levels) {
  return testing_support::octasphere(levels, radius_m);
}

/// A box about the origin, two triangles a side.
inline Surface box_mesh(const Vec3& half_m) {
  Surface out = testing_support::cube(2);
  out.vertices = (out.vertices.array() - 1).matrix() * half_m.asDiagonal();
  return out;
}

}  // namespace palpate::fem
