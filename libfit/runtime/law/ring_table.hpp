// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// The rings of a body (law/rings.hpp): at which depth each touches and how its stiffness
// follows from a normal curve (B0).

#include <cmath>

#include "../base/spline.hpp"

namespace palpate {
namespace runtime {

constexpr int kRings = 8;  ///< 4 are too few; 6 to 24 agree to 0.3 % of force

/// Where the rings of a body touch, and how their stiffness follows from the control values of a
/// normal curve (B0). Edges e_i = D (i/N)^1.5; thresholds are their middles, the first 0.
template <int N>
struct RingTable {
  int order = 0;
  double edge_m[N] = {}, threshold_m[N] = {};
  int first[N] = {};                     ///< first control value alive at edge i
  double slope[N][kMaxDegree + 1] = {};  ///< [1/m], of the basis at edge i
  int first_at_0 = 0;                    ///< likewise where contact begins
  double slope_at_0[kMaxDegree + 1] = {};
};

/// depth_m: D > 0, where the last ring ends.
template <int N>
RingTable<N> ring_table(const SplineView& normal, double depth_m) noexcept {
  RingTable<N> table;
  table.order = normal.degree + 1;
  const SplineWeights<double> begin = spline_weights(normal, 0, 0.0);
  table.first_at_0 = begin.first;
  for (int k = 0; k < table.order; ++k) table.slope_at_0[k] = begin.slope[k];
  for (int i = 0; i < N; ++i) {
    const double share = double(i + 1) / N, edge_m = depth_m * (share * std::sqrt(share));
    table.edge_m[i] = edge_m;
    table.threshold_m[i] = i == 0 ? 0 : 0.5 * (table.edge_m[i - 1] + edge_m);
    const SplineWeights<double> at = spline_weights(normal, find_piece(normal, edge_m), edge_m);
    table.first[i] = at.first;
    for (int k = 0; k < table.order; ++k) table.slope[i][k] = at.slope[k];
  }
  return table;
}

}  // namespace runtime
}  // namespace palpate
