// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// The parts of a node of a curve family, and the curves of a body as its law reads them: bases,
// rings (law/rings.hpp), and the tables of another indenter than the one that the body was measured
// with (docs/method-tools.md, section 30).

#include <cmath>

#include "../base/scalar.hpp"
#include "../base/spline.hpp"
#include "relaxation.hpp"

namespace palpate::runtime {

constexpr int kMaxParts = 10;  ///< of a family: an asset's header has room for as many

/// Source of a part that is known before any fit.
enum class Known {
  no,
  curvature,  ///< minus the gradient of the inward normal
  sway,       ///< compliance of the body: of no tool, so no force scales it
  tools,      ///< how curves change with the indenter's radius: 0 unless several were pressed
};
struct Part {
  const char* name;     ///< of its columns, such as "normal"
  const char* unit;     ///< of its numbers, SI
  int length, force;    ///< powers of length and force in that unit
  int width;            ///< numbers of a control value: 1; 3: x, y, z; 6: xx, yy, zz, xy, xz, yz
  int count;            ///< control values of a node; 0: a curve, as many as its basis has
  bool starts_at_zero;  ///< the first control value is 0
  bool rises;           ///< no control value is below the one before
  double min, max;      ///< bounds of every number
  Known known = Known::no;  ///< before any fit

  constexpr bool is_curve() const noexcept { return count == 0; }
};

/// A curve of force over depth or deflection that is zero at zero and never falls.
constexpr Part rising_curve(const char* name, double max_N = kMaxForce_N) noexcept {
  return {name, "N", 0, 1, 1, 0, true, true, 0, max_N};
}

/// Returns true if `controls` control values of a part are admissible numbers; where a node does
/// not answer (is_zero) all of them are 0.
template <class C>
bool is_good_part(const Part& part, const C* control, int controls, bool is_zero) noexcept {
  for (int j = 0; j < controls * part.width; ++j) {
    const double value = double(control[j]);
    const bool must_be_zero = is_zero || (part.starts_at_zero && j < part.width);
    if (must_be_zero ? value != 0 : !(value >= part.min && value <= part.max)) return false;
    if (part.rises && j >= part.width && !(value >= double(control[j - part.width]))) return false;
  }
  return true;
}

/// Depths at which the rings of a body touch, and how their stiffness follows from the control
/// values of a normal curve (B0). Edges e_i = D (i/N)^1.5; thresholds are their middles, the first
/// 0.
struct RingTable {
  int order = 0;
  double edge_m[kRings] = {}, threshold_m[kRings] = {};
  int first[kRings] = {};                     ///< first control value alive at edge i
  double slope[kRings][kMaxDegree + 1] = {};  ///< [1/m], of the basis at edge i
  int first_at_0 = 0;                         ///< likewise where contact begins
  double slope_at_0[kMaxDegree + 1] = {};
};

/// depth_m: D > 0, where the last ring ends.
inline RingTable ring_table(const SplineView& normal, double depth_m) noexcept {
  RingTable table;
  table.order = normal.degree + 1;
  const SplineWeights<double> begin = spline_weights(normal, 0, 0.0);
  table.first_at_0 = begin.first;
  for (int k = 0; k < table.order; ++k) table.slope_at_0[k] = begin.slope[k];
  for (int i = 0; i < kRings; ++i) {
    const double share = double(i + 1) / kRings, edge_m = depth_m * (share * std::sqrt(share));
    table.edge_m[i] = edge_m;
    table.threshold_m[i] = i == 0 ? 0 : 0.5 * (table.edge_m[i - 1] + edge_m);
    const SplineWeights<double> at = spline_weights(normal, find_piece(normal, edge_m), edge_m);
    table.first[i] = at.first;
    for (int k = 0; k < table.order; ++k) table.slope[i][k] = at.slope[k];
  }
  return table;
}

/// Numbers of a node that say how its stiffness changes with the indenter (M83): k, and the share
/// w of what goes with the contact's radius rather than with depth.
constexpr int kRadiusEffects = 2;

struct IndenterView {
  bool has_radius_effect = false;
  /// ln(R / R_0) K_d and K_a of (M83), on the knots of the normal curves' own view, which is K_d.
  SplineView by_radius[kRadiusEffects];
  RingTable rings_by_radius[kRadiusEffects];
  /// Depth at which the asset's own ball has a contact as wide, at the knots of the normal curves.
  const double* own_depth_m = nullptr;
  double surface_offset_m = 0;  ///< R - R_0: how much farther out the surface of its centres lies
  /// mu(d) = mu_0 + mu_1 (plough_offset_m + plough_slope d): a ball that ploughs has R_0 / R alone
  /// (M84).
  double plough_offset_m = 0, plough_slope = 1;
  double side[2][2] = {{1, 0}, {0, 1}};  ///< g_2 and g_3 out of those of a node (M85)
};

/// That depth at any depth > 0; normal: the view of the normal curves.
inline double own_depth(const IndenterView& view, const SplineView& normal, double d) noexcept {
  const int at = find_piece(normal, d), from = at < normal.pieces ? at : at - 1;
  const double* own = view.own_depth_m + from;
  const double width = normal.knots[from + 1] - normal.knots[from];
  return own[0] + (own[1] - own[0]) * ((d - normal.knots[from]) / width);
}

/// The parts that every family begins with: f^z(dz), f^r(dr), L(dz).
enum CurvePart : int { kNormal, kLateral, kLimit, kCurves };

/// The family of a body and the bases of its parts; no pieces: numbers, or not a part of it.
struct CurveViews {
  int family = 0;
  SplineView view[kMaxParts];
  RingTable rings;                         ///< of a body of rings
  RelaxationView relaxation;               ///< likewise
  const IndenterView* indenter = nullptr;  ///< of another than the body was measured with
};

}  // namespace palpate::runtime
