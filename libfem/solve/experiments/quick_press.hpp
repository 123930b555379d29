#pragma once

#include <limits>
#include <vector>

#include "libfit/core/samples.hpp"

namespace palpate::fem {

/// Factor of one step of a press on one mesh: a line over the logarithm of its force
/// [N], held beyond the forces that it was found at.
struct QuickStep {
  double scale = 1;  ///< at log_force
  double log_force = 0, lowest = 0, highest = 0;
  double error = 0;  ///< relative: what the line leaves at the worst of the points and what their
                     ///< own rows state (median)
};

/// Correction of presses on one mesh, from points that were pressed on two as well (M13e).
/// steps: of the press; empty where nothing is told. slope: of all their lines, 0 where one factor
/// for all points is as good. p95: of what is left in all rows, light rows over relative_floor() of
/// their point's largest force.
struct QuickScale {
  std::vector<QuickStep> steps;
  double slope = 0;
  double p95 = 0;
  int points = 0;  ///< that told it

  explicit operator bool() const { return !steps.empty(); }
  /// A step that no point reached on both meshes has what the one before it has.
  const QuickStep& step(std::int32_t number) const;
  /// force_N: of the row on one mesh. Not where nothing is told.
  double factor(std::int32_t step, double force_N) const;
  /// Tells samples of one comparison from those of another (Effort): the deepest step's scale.
  double number() const { return steps.empty() ? 0 : steps.back().scale; }
};

/// two_meshes, one_mesh: rows of the same points in the same order; the latter with scale 1.
/// There is a slope where lines predict points left out better than factors do; what is left is
/// then what is left in points left out. max_error: rows on two meshes that state more of
/// themselves [relative] tell nothing.
QuickScale compare_quick(const Samples& two_meshes, const Samples& one_mesh,
                         double max_error = std::numeric_limits<double>::infinity());

}  // namespace palpate::fem
