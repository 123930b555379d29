#pragma once

#include <vector>

#include "libfit/core/samples.hpp"

namespace palpate::fem {

/// What presses on one mesh lack, told by points that were pressed on two as well (M13e).
/// scale: the one force over the other, median over the points; 0 where none tells.
/// error: of each press step, relative, what `scale` leaves at the worst of the points and what
/// their own rows state (median). p95: of what it leaves in all rows, light rows over kLightForce
/// of their point's largest force.
struct QuickScale {
  double scale = 0;
  std::vector<double> error;
  double p95 = 0;
};

/// two_meshes, one_mesh: rows of the same points in the same order; the latter with scale 1.
QuickScale compare_quick(const Samples& two_meshes, const Samples& one_mesh);

}  // namespace palpate::fem
