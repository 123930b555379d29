// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// How another indenter than the one that a body was measured with meets its curves
// (docs/method-tools.md, section 30): tables that asset/with_indenter.hpp makes once, in memory of
// the caller's.

#include "../base/spline.hpp"
#include "ring_table.hpp"

namespace palpate {
namespace runtime {

/// Numbers k of a node by which its stiffness changes with ln R: one, and one over the contact's
/// radius (M83).
constexpr int kRadiusEffects = 2;

struct IndenterView {
  bool has_radius_effect = false;
  /// Basis functions times ln(R / R_0) and, the second, a over the widest measured: what a node's
  /// k are times (M83). On the knots of the normal curves' own view.
  SplineView by_radius[kRadiusEffects];
  RingTable<kRings> rings_by_radius[kRadiusEffects];
  /// Depth at which the asset's own ball has a contact as wide, at the knots of the normal curves.
  const double* own_depth_m = nullptr;
  double farther_m = 0;  ///< R - R_0: how much farther out the surface of its centres lies
  /// mu(d) = mu_0 + mu_1 (steep_m + steeper d): a ball that ploughs has R_0 / R alone (M84).
  double steep_m = 0, steeper = 1;
  double spread = 1;                     ///< what gamma of a node is times: R_0 / R of a ball
  double side[2][2] = {{1, 0}, {0, 1}};  ///< g_2 and g_3 out of those of a node (M85)
};

/// That depth at any depth > 0; normal: the view of the normal curves.
inline double own_depth(const IndenterView& view, const SplineView& normal, double d) noexcept {
  const int at = find_piece(normal, d), from = at < normal.pieces ? at : at - 1;
  const double* own = view.own_depth_m + from;
  const double width = normal.knots[from + 1] - normal.knots[from];
  return own[0] + (own[1] - own[0]) * ((d - normal.knots[from]) / width);
}

}  // namespace runtime
}  // namespace palpate
