// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// Monotone response curves on a shared spline basis: the same template is the fitter's model
// (scalars are Ceres Jets there) and the engine's (scalars are doubles). Build with
// -ffp-contract=off: a compiler that fuses a*b+c rounds the two differently.

#include <cstdint>

#include "constants.hpp"
#include "rounding.hpp"

namespace palpate::runtime {

/// A shared basis as the asset stores it: intervals of polynomials, see SplineTables in
/// libfit/core/curve_basis.hpp for the layout. Views, never owns. knots: pieces + 1 [m].
/// The same curves for another indenter (asset/with_indenter.hpp) have intervals of their
/// own over the same control values: each then says which is its first live one, and what all of
/// them are at its begin, where the live ones' polynomials begin at 0.
struct SplineView {
  int degree = 0;
  int pieces = 0;
  const double* knots = nullptr;
  const double* weights = nullptr;
  const double* integrals = nullptr;
  int controls = 0;                     ///< of another indenter; 0: pieces + degree
  const std::int32_t* first = nullptr;  ///< pieces + 1; null: the basis is local
  const double* begins = nullptr;       ///< (pieces + 1) x controls

  int size() const noexcept { return controls > 0 ? controls : pieces + degree; }
};

/// Interval of an abscissa and the weights of the degree+1 control values alive there.
/// value, slope and integral of any curve b are sums over k of b[first + k] times these.
template <class T>
struct SplineWeights {
  int first = 0;            ///< index of the first live control value
  int piece = 0;            ///< interval, `pieces` past the last knot
  T value[kMaxDegree + 1];  ///< [1]
  T slope[kMaxDegree + 1];  ///< [1/m]
};

/// Interval of x [m]: 0 below the first knot, `pieces` at and beyond the last. At most 8 steps for
/// 256 pieces.
inline int find_piece(const SplineView& spline, double x) noexcept {
  int lo = 0, hi = spline.pieces;
  if (!(x < spline.knots[hi])) return hi;
  while (hi - lo > 1) {
    const int middle = lo + static_cast<int>(static_cast<unsigned>(hi - lo) / 2);
    if (x < spline.knots[middle])
      hi = middle;
    else
      lo = middle;
  }
  return lo;
}

/// First control value that is alive on an interval.
inline int first_control(const SplineView& spline, int piece) noexcept {
  if (spline.first != nullptr) return spline.first[piece];
  return piece < spline.pieces ? piece : spline.pieces - 1;
}

/// Weights at x >= 0 on a known interval (M6) (`scalar` of a Jet decides the interval, so
/// derivatives are those of the branch taken). Work: (degree+1)^2 multiply-adds twice.
template <class T>
SplineWeights<T> spline_weights(const SplineView& spline, int piece, const T& x) noexcept {
  SplineWeights<T> out;
  const int order = spline.degree + 1;
  out.piece = piece;
  out.first = first_control(spline, piece);
  const T t = x - spline.knots[piece];
  for (int k = 0; k < order; ++k) {
    const double* c = spline.weights + (piece * order + k) * order;
    T value = T(c[order - 1]);
    T slope = T((order - 1) * c[order - 1]);
    for (int m = order - 2; m >= 0; --m) value = value * t + c[m];
    for (int m = order - 2; m >= 1; --m) slope = slope * t + m * c[m];
    out.value[k] = value;
    out.slope[k] = slope;
  }
  return out;
}

/// One basis polynomial, c[0] + c[1] t + ... of `order` terms, by Horner's rule (M6).
template <class T>
T basis_value(const double* c, int order, const T& t) noexcept {
  T value = T(c[order - 1]);
  for (int m = order - 2; m >= 0; --m) value = value * t + c[m];
  return value;
}

/// Its integral from 0 to t, divided by t (M7). The divisions by m + 1 are of constants.
template <class T>
T basis_integral(const double* c, int order, const T& t) noexcept {
  constexpr double kShare[kMaxDegree + 1] = {1.0, 1.0 / 2, 1.0 / 3, 1.0 / 4, 1.0 / 5};
  T part = T(c[order - 1] * kShare[order - 1]);
  for (int m = order - 2; m >= 0; --m) part = part * t + c[m] * kShare[m];
  return part;
}

/// sum_k b[first + k] * weight[k]; control may be float, double or Jet.
template <class T, class C>
T dot(const SplineView& spline, const T* weight, const C* control, int first) noexcept {
  T sum = T(control[first]) * weight[0];
  for (int k = 1; k <= spline.degree; ++k) sum = sum + T(control[first + k]) * weight[k];
  return sum;
}

/// Force of one curve at x [m] -> [N] (M5); exactly 0 for x <= 0.
template <class C>
double curve_value(const SplineView& spline, const C* control, double x) noexcept {
  if (!(x > 0)) return 0;
  const auto weights = spline_weights(spline, find_piece(spline, x), x);
  return dot(spline, weights.value, control, weights.first);
}

/// Slope of one curve at x [m] -> [N/m]; 0 for x < 0, the right-hand slope at 0.
template <class C>
double curve_slope(const SplineView& spline, const C* control, double x) noexcept {
  if (!(x >= 0)) return 0;
  const auto weights = spline_weights(spline, find_piece(spline, x), x);
  return dot(spline, weights.slope, control, weights.first);
}

/// Stored energy of one curve, the integral of its force from 0 to x [m] -> [J] (M7); 0 for
/// x <= 0.
template <class C>
double curve_energy(const SplineView& spline, const C* control, double x) noexcept {
  if (!(x > 0)) return 0;
  const int piece = find_piece(spline, x);
  const int order = spline.degree + 1, size = spline.size();
  const int first = first_control(spline, piece);
  const double t = x - spline.knots[piece];
  double sum = 0;
  for (int j = 0; j < first + order && j < size; ++j)
    sum = sum + double(control[j]) * spline.integrals[piece * size + j];
  for (int k = 0; k < order; ++k) {
    const double* c = spline.weights + (piece * order + k) * order;
    sum = sum + double(control[first + k]) * (basis_integral(c, order, t) * t);
  }
  return sum;
}

}  // namespace palpate::runtime
