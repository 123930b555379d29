#pragma once

#include <vector>

#include "libfit/core/samples.hpp"

namespace palpate::fem {

/// What presses on one mesh lack, told by points that were pressed on two as well (M13e).
/// scale: of each press step, the one force over the other, median over the points; empty where
/// none tells. error: relative, likewise, what `scale` leaves at the worst of the points and what
/// their own rows state (median). p95: of what it leaves in all rows, light rows over kLightForce
/// of their point's largest force.
struct QuickScale {
  std::vector<double> scale, error;
  double p95 = 0;

  explicit operator bool() const { return !scale.empty(); }
  /// Tells samples of one comparison from those of another (Effort): that of the deepest step.
  double number() const { return scale.empty() ? 0 : scale.back(); }
};

/// two_meshes, one_mesh: rows of the same points in the same order; the latter with scale 1.
QuickScale compare_quick(const Samples& two_meshes, const Samples& one_mesh);

}  // namespace palpate::fem
