// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// The separable family: W = Z(dz) + R(dr) (docs/method.md, M3). The depth does not change the
// lateral stiffness, nor the lateral deflection the normal one.

#include "../slide.hpp"
#include "part.hpp"

namespace palpate {
namespace runtime {

struct Separable {
  static constexpr const char* kName = "separable";
  static constexpr Part kPart[] = {rising_curve("normal"), rising_curve("lateral"),
                                   rising_curve("limit")};
  static constexpr int kMemory = 0;  ///< numbers that a contact remembers beside its place

  template <class T, class Spot>
  static Deflection<T> deflection(const CurveViews&, const Spot& spot, const Vec3<T>& x) noexcept {
    const Vec3<T> delta = x - spot.point;
    const T normal_m = dot(delta, spot.normal);
    return deflection_of(normal_m, delta - spot.normal * normal_m);
  }

  /// Force of the tool on the body [N], the gradient of the energy: f^z u + f^r u^r; zero where
  /// dz <= 0. lateral_N: f^r.
  template <class T, class Spot>
  static Vec3<T> force(const CurveViews& views, const Spot& spot, const Deflection<T>& d,
                       const T& lateral_N) noexcept {
    if (!(value_of(d.normal_m) > 0)) return {T(0), T(0), T(0)};
    return spot.normal * curve_at(views, spot, kNormal, d.normal_m) + d.lateral * lateral_N;
  }

  /// Z(dz) + R(dr) [J], exact polynomials.
  template <class T, class Spot>
  static T energy_J(const CurveViews& views, const Spot& spot, const Deflection<T>& d) noexcept {
    return energy_at(views, spot, kNormal, d.normal_m) +
           energy_at(views, spot, kLateral, d.lateral_m);
  }

  template <class T, class Surface, class Spot>
  static SlideEnd slide(const CurveViews& views, const Vec3<T>& x, Surface& surface,
                        Footing<T, Spot>& foot) noexcept {
    return slide_until_it_holds<Separable>(views, x, surface, foot);
  }
};

}  // namespace runtime
}  // namespace palpate
