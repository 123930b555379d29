// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// The curves of a contact point at a deflection: forces and what they store (docs/method.md,
// section 2), one template for the engine (scalar double) and the fitter (scalar double or
// ceres::Jet). Forces are those of the tool ON the body.

#include "deflection.hpp"

namespace palpate {
namespace runtime {

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

/// Interval of x in a curve. A spot that remembers the last one brings an overload.
template <class Spot>
int piece_at(const SplineView& view, const Spot&, int /*curve*/, double x) noexcept {
  return find_piece(view, x);
}

/// Sum of a spot's control values times the basis at x, on a basis of a known order: the compiler
/// unrolls it, which is half of a tick's time.
template <int kOrder, class T, class Spot>
T curve_of_order(const SplineView& view, const Spot& spot, int curve, const T& x) noexcept {
  const int piece = piece_at(view, spot, curve, value_of(x)), first = first_control(view, piece);
  const auto live = live_controls<kOrder>(spot, curve, first);
  const T t = x - view.knots[piece];
  const double* c = view.weights + piece * kOrder * kOrder;
  T sum = live.b[0] * basis_value(c, kOrder, t);
  for (int k = 1; k < kOrder; ++k) sum = sum + live.b[k] * basis_value(c + k * kOrder, kOrder, t);
  return sum;
}

/// Force of one curve of a spot at x [m] -> [N] (M5); exactly 0 for x <= 0.
template <class T, class Spot>
T curve_at(const CurveViews& views, const Spot& spot, int curve, const T& x) noexcept {
  if (!(value_of(x) > 0)) return T(0);
  const SplineView& view = views.view[curve];
  switch (view.degree) {
    case 1:
      return curve_of_order<2>(view, spot, curve, x);
    case 2:
      return curve_of_order<3>(view, spot, curve, x);
    case 3:
      return curve_of_order<4>(view, spot, curve, x);
    default:
      return curve_of_order<5>(view, spot, curve, x);
  }
}

/// Area under a curve of a spot up to the interval `piece` that the control values below `first`
/// bring. A spot that has it at hand brings an overload.
template <class Spot>
auto area_before(const SplineView& view, const Spot& spot, int curve, int piece, int first) noexcept
    -> decltype(spot.control(curve, first)) {
  using S = decltype(spot.control(curve, first));
  const double* whole = view.integrals + piece * view.size();
  S sum[4] = {S(0), S(0), S(0), S(0)};  // four at a time: one chain of sums would wait for each
  int j = 0;
  for (; j + 4 <= first; j += 4) {
    const auto live = live_controls<4>(spot, curve, j);
    for (int i = 0; i < 4; ++i) sum[i] = sum[i] + live.b[i] * whole[j + i];
  }
  for (int i = 0; j < first; ++j, ++i) sum[i] = sum[i] + spot.control(curve, j) * whole[j];
  return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

template <int kOrder, class T, class Spot>
T energy_of_order(const SplineView& view, const Spot& spot, int curve, const T& x) noexcept {
  const int piece = piece_at(view, spot, curve, value_of(x)), first = first_control(view, piece);
  const auto live = live_controls<kOrder>(spot, curve, first);
  const T t = x - view.knots[piece];
  const double* whole = view.integrals + piece * view.size();
  const double* c = view.weights + piece * kOrder * kOrder;
  T last = T(0);
  for (int k = 0; k < kOrder; ++k)
    last = last + live.b[k] * (basis_integral(c + k * kOrder, kOrder, t) * t + whole[first + k]);
  return area_before(view, spot, curve, piece, first) + last;
}

/// Area under one curve of a spot from 0 to x [J], exact (M7); 0 for x <= 0.
template <class T, class Spot>
T energy_at(const CurveViews& views, const Spot& spot, int curve, const T& x) noexcept {
  if (!(value_of(x) > 0)) return T(0);
  const SplineView& view = views.view[curve];
  switch (view.degree) {
    case 1:
      return energy_of_order<2>(view, spot, curve, x);
    case 2:
      return energy_of_order<3>(view, spot, curve, x);
    case 3:
      return energy_of_order<4>(view, spot, curve, x);
    default:
      return energy_of_order<5>(view, spot, curve, x);
  }
}

/// f^r(dr) [N].
template <class T, class Spot>
T lateral_force(const CurveViews& views, const Spot& spot, const Deflection<T>& d) noexcept {
  return curve_at(views, spot, kLateral, d.lateral_m);
}

}  // namespace runtime
}  // namespace palpate
