// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// The leaning family: as the separable one, with the lateral deflection counted from the lean
// l(dz), the lateral displacement of a tool pressed to dz with nothing to hold it sideways (M3a,
// M3b).

#include "separable.hpp"

namespace palpate {
namespace runtime {

struct Leaning : OneAnchor<Leaning> {
  static constexpr const char* kName = "leaning";
  static constexpr int kLean = 3;  ///< the part
  static constexpr Part kPart[] = {rising_curve("normal"),
                                   rising_curve("lateral"),
                                   rising_curve("limit"),
                                   {"lean", "m", 1, 0, 3, 0, true, false, -1e3, 1e3}};

  /// (M3a)
  template <class T, class Spot>
  static Deflection<T> deflection(const CurveViews& views, const Spot& spot, const Vec3<T>& x,
                                  const Vec3<T>& rest) noexcept {
    const Vec3<T> delta = x - spot.point;
    const T normal_m = dot(delta, spot.normal);
    const Vec3<T> lateral = delta - spot.normal * normal_m - rest;
    if (!(value_of(normal_m) > 0)) return deflection_of(normal_m, lateral);
    const VectorAt<T> lean = vector_curve_at(views.view[kLean], spot, kLean, normal_m);
    Deflection<T> out = deflection_of(
        normal_m, lateral - (lean.value - spot.normal * dot(lean.value, spot.normal)));
    if (value_of(out.lateral_m) > 0) out.lean_rate = dot(lean.slope, out.lateral);
    return out;
  }
};

}  // namespace runtime
}  // namespace palpate
