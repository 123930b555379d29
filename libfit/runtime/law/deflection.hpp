// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// Where a tool stands against its contact point: depth and lateral deflection in the frame of the
// spot (docs/method.md, sections 1 and 2). One template for the engine (scalar double) and the
// fitter (scalar double or ceres::Jet).
// A Spot is a place where a contact point can stand: .point [m], .normal (inward unit),
// .control(part, j): number j of a part of the family there.

#include "../base/scalar.hpp"
#include "../base/spline.hpp"
#include "indenter_view.hpp"
#include "part.hpp"
#include "relaxation.hpp"
#include "ring_table.hpp"

namespace palpate {
namespace runtime {

/// The parts that every family begins with: f^z(dz), f^r(dr), L(dz).
constexpr int kNormal = 0, kLateral = 1, kLimit = 2;
constexpr int kCurves = 3;

constexpr double kLateralZero_m = 1e-12;  ///< below a picometre the lateral direction is noise

/// The family of a body and the bases of its parts; no pieces: numbers, or not a part of it.
struct CurveViews {
  int family = 0;
  SplineView view[kMaxParts];
  RingTable<kRings> rings;                 ///< of a body of rings
  RelaxationView relaxation;               ///< likewise
  const IndenterView* indenter = nullptr;  ///< of another than the body was measured with
};

/// A tool's deflection in the frame of its contact point.
template <class T>
struct Deflection {
  T normal_m;       ///< dz, > 0 in contact
  T lateral_m;      ///< dr >= 0; exactly 0 below kLateralZero_m
  Vec3<T> lateral;  ///< u^r; zero vector where dr is 0
};

/// Of a depth and a lateral deflection (M2).
template <class T>
Deflection<T> deflection_of(const T& normal_m, const Vec3<T>& lateral) noexcept {
  using std::sqrt;
  Deflection<T> out{normal_m, T(0), {T(0), T(0), T(0)}};
  const T squared = dot(lateral, lateral);
  if (!(value_of(squared) > kLateralZero_m * kLateralZero_m)) return out;
  out.lateral_m = sqrt(squared);
  out.lateral = lateral * (1.0 / out.lateral_m);
  return out;
}

}  // namespace runtime
}  // namespace palpate
