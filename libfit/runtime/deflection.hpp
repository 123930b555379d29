// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// Where a tool stands against its contact point: depth and lateral deflection in the frame of the
// spot, from where the body leans to (docs/method.md, sections 1 and 2). One template for the
// engine (scalar double) and the fitter (scalar double or ceres::Jet). A Spot is a place where a
// contact point can stand: .point [m], .normal (inward unit), .control(curve, j) [N], .lean(j) [m].

#include "scalar.hpp"
#include "spline.hpp"

namespace palpate {
namespace runtime {

constexpr int kNormal = 0, kLateral = 1, kLimit = 2;  ///< f^z(dz), f^r(dr), L(dz)
constexpr int kCurves = 3;
constexpr int kLean = 3;  ///< where the lean l(dz) stands after them

constexpr double kLateralZero_m = 1e-12;  ///< below a picometre the lateral direction is noise

/// The bases of the three curves and of the lean, shared by the body.
struct CurveViews {
  SplineView view[kCurves];
  SplineView lean;  ///< of l(dz); no pieces: the body does not lean
};

/// A tool's deflection in the frame of its contact point.
template <class T>
struct Deflection {
  T normal_m;       ///< dz, > 0 in contact
  T lateral_m;      ///< dr >= 0, from where the body leans to; exactly 0 below kLateralZero_m
  Vec3<T> lateral;  ///< u^r; zero vector where dr is 0
  T lean_rate;      ///< u^r . dl/d(dz) [1]: what the lateral force takes from the normal one
};

/// l and dl/d(dz) of a spot.
template <class T>
struct Lean {
  Vec3<T> value_m, slope;
};
template <class T, class Spot>
Lean<T> lean_at(const SplineView& view, const Spot& spot, const T& depth_m) noexcept {
  const SplineWeights<T> w = spline_weights(view, find_piece(view, value_of(depth_m)), depth_m);
  const Vec3<T> nothing{T(0), T(0), T(0)};
  Lean<T> out{nothing, nothing};
  for (int k = 0; k <= view.degree; ++k) {
    const Vec3<T> control = spot.lean(w.first + k);
    out.value_m = out.value_m + control * w.value[k];
    out.slope = out.slope + control * w.slope[k];
  }
  return out;
}

/// The deflection of a tool at x [m] whose contact point is the spot.
template <class T, class Spot>
Deflection<T> deflection(const CurveViews& views, const Spot& spot, const Vec3<T>& x) noexcept {
  using std::sqrt;
  const Vec3<T> delta = x - spot.point;
  const Vec3<T> nothing{T(0), T(0), T(0)};
  Deflection<T> out{dot(delta, spot.normal), T(0), nothing, T(0)};
  Vec3<T> lateral = delta - spot.normal * out.normal_m;
  const bool leans = views.lean.pieces > 0 && value_of(out.normal_m) > 0;
  Vec3<T> slope = nothing;
  if (leans) {
    const Lean<T> lean = lean_at(views.lean, spot, out.normal_m);
    lateral = lateral - (lean.value_m - spot.normal * dot(lean.value_m, spot.normal));
    slope = lean.slope;
  }
  const T squared = dot(lateral, lateral);
  if (!(value_of(squared) > kLateralZero_m * kLateralZero_m)) return out;
  out.lateral_m = sqrt(squared);
  out.lateral = lateral * (1.0 / out.lateral_m);
  if (leans) out.lean_rate = dot(slope, out.lateral);
  return out;
}

}  // namespace runtime
}  // namespace palpate
