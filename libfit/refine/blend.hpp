#pragma once

#include <vector>

#include "libfit/core/curves.hpp"
#include "libfit/refine/edge_paths.hpp"

namespace palpate {

/// Which test points answer for each fine vertex, and with what weights. V rows; a row of zero
/// weights is a vertex that nothing answers for.
struct Blend {
  Triangles point;
  Points weight;
  double largest_projection_m = 0;
};

/// Area coordinates of each wanted vertex on its test-point triangle: the nearest one that faces
/// alike and is not too far, among those around the point that is nearest along the surface (two
/// rings). is_usable: per point; the weight of an unusable corner goes to the others. seeds: per
/// point, where it sits on the surface (none for points left out).
Blend blend_by_area(const FittedCurves& curves, const Surface& fine, const Points& outward_normal,
                    const std::vector<char>& is_wanted, const Triangles& triangles,
                    const std::vector<char>& is_usable, const std::vector<EdgePathSeeds>& seeds);

/// All weight on the point that is nearest along the surface. cell: #V, -1 for none.
Blend blend_by_cell(const std::vector<std::int32_t>& cell, const std::vector<char>& is_wanted);

}  // namespace palpate
