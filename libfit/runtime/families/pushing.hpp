// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// A toy: the separable family whose body pushes sideways by a vector s of each node,
// W = Z(dz) + R(dr) + dz^2 s . q with the lateral deflection q.

#include "separable.hpp"

namespace palpate {
namespace runtime {

struct Pushing : OneAnchor<Pushing> {
  static constexpr const char* kName = "pushing";
  static constexpr int kPush = 3;  ///< the part
  static constexpr int kNumbers = 3;
  static constexpr Part kPart[] = {rising_curve("normal"),
                                   rising_curve("lateral"),
                                   rising_curve("limit"),
                                   {"push", "N/m^2", -2, 1, 3, 1, false, false, -1e9, 1e9}};

  template <class T, class Spot>
  static Deflection<T> deflection(const CurveViews& views, const Spot& spot, const Vec3<T>& x,
                                  const Vec3<T>& rest) noexcept {
    return Separable::deflection(views, spot, x, rest);
  }

  template <class T, class Spot>
  static Answer<T> answer(const CurveViews& views, const Under& under,
                          const ContactKinematics<T, Spot>& kinematics,
                          const NoSlip& none) noexcept {
    Answer<T> out = OneAnchor<Pushing>::answer<T>(views, under, kinematics, none);
    const T d = kinematics.d.normal_m;
    if (!(value_of(d) > 0)) return out;
    const Spot& spot = kinematics.spot;
    const Vec3<T> s =
        tangential(Vec3<T>{spot.control(kPush, 0), spot.control(kPush, 1), spot.control(kPush, 2)},
                   spot.normal);
    const T along = dot(s, kinematics.d.lateral * kinematics.d.lateral_m);
    out.force_N = out.force_N + s * (d * d) + spot.normal * (2.0 * d * along);
    out.stored_J = out.stored_J + d * d * along;
    return out;
  }
};

}  // namespace runtime
}  // namespace palpate
