// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// The separable family: W = Z(dz) + R(dr) (M3). The depth does not change the
// lateral stiffness, nor the lateral deflection the normal one.

#include "../slide.hpp"
#include "part.hpp"

namespace palpate {
namespace runtime {

/// What families have in common that remember the contact point alone. F brings deflection().
template <class F>
struct OneAnchor {
  static constexpr int kCurves = 3;   ///< parts that are rising curves, from the first on
  static constexpr int kNumbers = 0;  ///< of a node after these, none of them a curve
  static constexpr int kMemory = 0;

  template <class T>
  struct Memory {};
  template <class T>
  static Memory<T> load(const double*) noexcept {
    return {};
  }
  static void save(const Memory<double>&, double*) noexcept {}

  template <class Spot>
  static bool is_frictionless(const CurveViews& views, const Spot& spot) noexcept {
    return runtime::is_frictionless(views, spot);
  }
  template <class T, class Spot>
  static Footing<T, Spot> footing(const CurveViews& views, const Spot& spot,
                                  const Vec3<T>& x) noexcept {
    return footing_as<F>(views, spot, x);
  }
  template <class T, class Spot>
  static bool is_slipping(const CurveViews& views, const Footing<T, Spot>& foot) noexcept {
    return runtime::is_slipping(views, foot);
  }
  /// Nothing slips while the contact point holds.
  template <class T, class Spot>
  static double settle(const CurveViews&, const Footing<T, Spot>&, Memory<T>&) noexcept {
    return 0;
  }
  template <class T, class Spot>
  static T energy_J(const CurveViews& views, const Footing<T, Spot>& foot,
                    const Memory<T>&) noexcept {
    return energy_J(views, foot.d, foot.spot);
  }
  /// Z(dz) + R(dr) [J], exact polynomials.
  template <class T, class Spot>
  static T energy_J(const CurveViews& views, const Deflection<T>& d, const Spot& spot) noexcept {
    return energy_at(views, spot, kNormal, d.normal_m) +
           energy_at(views, spot, kLateral, d.lateral_m);
  }
  template <class T, class Surface, class Spot>
  static SlideEnd slide(const CurveViews& views, const Vec3<T>& x, Surface& surface,
                        Footing<T, Spot>& foot, Memory<T>&) noexcept {
    return slide_until_it_holds<F>(views, x, surface, foot);
  }
};

struct Separable : OneAnchor<Separable> {
  static constexpr const char* kName = "separable";
  static constexpr Part kPart[] = {rising_curve("normal"), rising_curve("lateral"),
                                   rising_curve("limit")};

  template <class T, class Spot>
  static Deflection<T> deflection(const CurveViews&, const Spot& spot, const Vec3<T>& x) noexcept {
    const Vec3<T> delta = x - spot.point;
    const T normal_m = dot(delta, spot.normal);
    return deflection_of(normal_m, delta - spot.normal * normal_m);
  }

  /// (M3): f^z u + f^r u^r; zero where dz <= 0.
  template <class T, class Spot>
  static Vec3<T> force(const CurveViews& views, const Footing<T, Spot>& foot,
                       const Memory<T>&) noexcept {
    if (!(value_of(foot.d.normal_m) > 0)) return {T(0), T(0), T(0)};
    return foot.spot.normal * curve_at(views, foot.spot, kNormal, foot.d.normal_m) +
           foot.d.lateral * foot.lateral_N;
  }
};

}  // namespace runtime
}  // namespace palpate
