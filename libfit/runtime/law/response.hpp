// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// The curves of a contact point at a deflection: forces and what they store (docs/method.md,
// section 2), one template for the engine (scalar double) and the fitter (scalar double or
// ceres::Jet). Forces are those of the tool ON the body.
// A Spot is a place where a contact point can stand: .point [m], .normal (inward unit),
// .control(part, j): number j of a part of the family there.

#include "curve_views.hpp"

namespace palpate::runtime {

/// The control values alive on one interval.
template <int kOrder, class T>
struct LiveControls {
  T b[kOrder];
};
/// Those of a spot from `first` on. A spot that has them at hand brings an overload.
template <int kOrder, class Spot>
auto live_controls(const Spot& spot, int curve, int first) noexcept
    -> LiveControls<kOrder, decltype(spot.control(curve, first))> {
  LiveControls<kOrder, decltype(spot.control(curve, first))> out;
  for (int k = 0; k < kOrder; ++k) out.b[k] = spot.control(curve, first + k);
  return out;
}

/// `count` numbers of a spot from number j of a part on, which may reach into the parts behind.
template <class T, class Spot>
void copy_controls(const Spot& spot, int part, int j, int count, T* out) noexcept {
  for (int k = 0; k < count; ++k) out[k] = spot.control(part, j + k);
}

/// A curve of a spot on one interval, as a polynomial in t = x - knot (M6), with the area below.
template <class T>
struct CurvePiece {
  int piece = -1;  ///< of the basis; -1: none
  int order = 0;
  double knot = 0;           ///< [m]
  T c[kMaxDegree + 1] = {};  ///< force, [N/m^k]; 0 from `order` on
  T area_J = T(0);           ///< under the curve up to the knot
  /// Force [N] (M5); x is on the interval.
  template <class S>
  S force(const S& x) const noexcept {
    const S t = x - knot;
    S sum = S(c[order - 1]);
    for (int k = order - 2; k >= 0; --k) sum = sum * t + c[k];
    return sum;
  }
  /// Area from 0 to x [J] (M7).
  template <class S>
  S energy(const S& x) const noexcept {
    constexpr double kShare[kMaxDegree + 1] = {1.0, 1.0 / 2, 1.0 / 3, 1.0 / 4, 1.0 / 5};
    const S t = x - knot;
    S sum = S(c[order - 1] * kShare[order - 1]);
    for (int k = order - 2; k >= 0; --k) sum = sum * t + c[k] * kShare[k];
    return sum * t + area_J;
  }
};

/// Sum of `weights` [control values] times the control values of a spot below `first`.
template <class Spot>
auto sum_before(const double* weights, const Spot& spot, int curve, int first) noexcept
    -> decltype(spot.control(curve, first)) {
  using S = decltype(spot.control(curve, first));
  S sum[4] = {S(0), S(0), S(0), S(0)};  // four at a time: one chain of sums would wait for each
  int j = 0;
  for (; j + 4 <= first; j += 4) {
    const auto live = live_controls<4>(spot, curve, j);
    for (int i = 0; i < 4; ++i) sum[i] = sum[i] + live.b[i] * weights[j + i];
  }
  for (int i = 0; j < first; ++j, ++i) sum[i] = sum[i] + spot.control(curve, j) * weights[j];
  return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

/// With the order known the compiler unrolls it.
template <int kOrder, class Spot>
auto piece_of_order(const SplineView& view, const Spot& spot, int curve, int piece,
                    bool with_area) noexcept -> CurvePiece<decltype(spot.control(curve, 0))> {
  using T = decltype(spot.control(curve, 0));
  CurvePiece<T> out;
  const int first = first_control(view, piece);
  out.piece = piece;
  out.order = kOrder;
  out.knot = view.knots[piece];
  const auto live = live_controls<kOrder>(spot, curve, first);
  const double* w = view.weights + piece * kOrder * kOrder;
  for (int m = 0; m < kOrder; ++m) {
    out.c[m] = live.b[0] * w[m];
    for (int k = 1; k < kOrder; ++k) out.c[m] = out.c[m] + live.b[k] * w[k * kOrder + m];
  }
  const auto sum_to = [&](const double* weights) noexcept {
    T last = live.b[0] * weights[first];
    for (int k = 1; k < kOrder; ++k) last = last + live.b[k] * weights[first + k];
    return sum_before(weights, spot, curve, first) + last;
  };
  if (view.begins != nullptr) out.c[0] = out.c[0] + sum_to(view.begins + piece * view.size());
  if (with_area) out.area_J = sum_to(view.integrals + piece * view.size());
  return out;
}

/// The interval of a basis that x > 0 is on.
template <class Spot>
auto piece_of(const SplineView& view, const Spot& spot, int curve, double x,
              bool with_area) noexcept -> CurvePiece<decltype(spot.control(curve, 0))> {
  const int piece = find_piece(view, x);
  switch (view.degree) {
    case 1:
      return piece_of_order<2>(view, spot, curve, piece, with_area);
    case 2:
      return piece_of_order<3>(view, spot, curve, piece, with_area);
    case 3:
      return piece_of_order<4>(view, spot, curve, piece, with_area);
    default:
      return piece_of_order<5>(view, spot, curve, piece, with_area);
  }
}
/// The same of a curve of a body. A spot that has it at hand or of another indenter
/// brings an overload.
template <class Spot>
auto piece_at(const CurveViews& views, const Spot& spot, int curve, double x,
              bool with_area) noexcept -> CurvePiece<decltype(spot.control(curve, 0))> {
  return piece_of(views.view[curve], spot, curve, x, with_area);
}

/// Force of one curve of a spot at x [m] -> [N] (M5); exactly 0 for x <= 0.
template <class T, class Spot>
T curve_at(const CurveViews& views, const Spot& spot, int curve, const T& x) noexcept {
  if (!(value_of(x) > 0)) return T(0);
  return T(piece_at(views, spot, curve, value_of(x), false).force(x));
}

/// Area under one curve of a spot from 0 to x [J], exact (M7); 0 for x <= 0.
template <class T, class Spot>
T energy_at(const CurveViews& views, const Spot& spot, int curve, const T& x) noexcept {
  if (!(value_of(x) > 0)) return T(0);
  return T(piece_at(views, spot, curve, value_of(x), true).energy(x));
}

/// Force of the tool on the body [N] and stored energy [J].
template <class T>
struct Answer {
  Vec3<T> force_N;
  T stored_J;
};

}  // namespace palpate::runtime
