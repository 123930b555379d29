// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// A toy: the separable family whose body pushes sideways by a vector s of each node,
// W = Z(dz) + R(dr) + dz^2 s . q with the lateral deflection q.

#include "separable.hpp"

namespace palpate {
namespace runtime {

struct Pushing {
  static constexpr const char* kName = "pushing";
  static constexpr int kPush = 3;  ///< the part
  static constexpr Part kPart[] = {rising_curve("normal"),
                                   rising_curve("lateral"),
                                   rising_curve("limit"),
                                   {"push", "N/m^2", -2, 1, 3, 1, false, false, -1e9, 1e9}};
  static constexpr int kMemory = 0;

  template <class T, class Spot>
  static Vec3<T> push(const Spot& spot) noexcept {
    const Vec3<T> s{spot.control(kPush, 0), spot.control(kPush, 1), spot.control(kPush, 2)};
    return s - spot.normal * dot(s, spot.normal);
  }

  template <class T, class Spot>
  static Deflection<T> deflection(const CurveViews& views, const Spot& spot,
                                  const Vec3<T>& x) noexcept {
    return Separable::deflection(views, spot, x);
  }

  template <class T, class Spot>
  static Vec3<T> force(const CurveViews& views, const Spot& spot, const Deflection<T>& d,
                       const T& lateral_N) noexcept {
    if (!(value_of(d.normal_m) > 0)) return {T(0), T(0), T(0)};
    const Vec3<T> s = push<T>(spot);
    const T along_N = 2.0 * d.normal_m * d.lateral_m * dot(s, d.lateral);
    return Separable::force(views, spot, d, lateral_N) + s * (d.normal_m * d.normal_m) +
           spot.normal * along_N;
  }

  template <class T, class Spot>
  static T energy_J(const CurveViews& views, const Spot& spot, const Deflection<T>& d) noexcept {
    const T side_J = d.normal_m * d.normal_m * d.lateral_m * dot(push<T>(spot), d.lateral);
    return Separable::energy_J(views, spot, d) + (value_of(d.normal_m) > 0 ? side_J : T(0));
  }

  template <class T, class Surface, class Spot>
  static SlideEnd slide(const CurveViews& views, const Vec3<T>& x, Surface& surface,
                        Footing<T, Spot>& foot) noexcept {
    return slide_until_it_holds<Pushing>(views, x, surface, foot);
  }
};

}  // namespace runtime
}  // namespace palpate
