#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "libfit/core/curves.hpp"

namespace palpate {

using Rgb = std::array<std::uint8_t, 3>;  ///< sRGB

/// The colour of a share from 0 to 1: viridis, readable without hue (van der Walt and Smith 2015).
Rgb viridis(double share);

/// Nothing is known there: no colour of the map, so that nobody takes it for soft.
inline constexpr Rgb kUncoveredGrey{158, 158, 158};

/// A model's normal stiffness at one depth, as a picture of it. V vertices.
struct StiffnessMap {
  double depth_m = 0;
  double low_N_m = 0, high_N_m = 0;  ///< stiffness at the ends of the colours
  std::vector<float> stiffness_N_m;  ///< V, NaN where not covered
  std::vector<Rgb> colour;           ///< V
};

/// depth_m: 0 for half of the curves' range. Throws Error as check_sizes, or where the depth is not
/// within the curves' range.
StiffnessMap stiffness_map(const Model& model, double depth_m);

/// Throws Error where the arrays of a model do not fit each other.
void check_sizes(const Model& model);

}  // namespace palpate
