// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// The law of a bed of stick-slip rings (docs/method.md, section 17): what a contact stores (B1) is
//
//     E = Z_c(d) + q.g_c(d) + 1/2 sum lambda c_i (|q_i|^2 + r_i^2)
//
// over the tool's place alone, with the anchors of the rings as its memory. A ring is the part of
// the contact that touches from the depth d_i on; its stiffness is the slope of the press curve. A
// press deflects it outward, too, by r_i. Each holds until |(q_i, r_i)| = share mu(d) (d - d_i) /
// lambda (B3a), then its anchors follow.
//
// One template for the engine (scalar double, or Jet3 for the tangent) and the fitter (double or
// ceres::Jet). Forces are those of the tool ON the body.

#include "relaxation.hpp"
#include "ring_bed.hpp"

namespace palpate::runtime {

/// Deflection of a tool from its contact point: q = P (x - c), d = (x - c).u - 1/2 q.kappa q, for
/// it presses on the surface under it and not on the tangent plane of c.
template <class T>
struct RingDeflection {
  Vec3<T> q;
  T depth_m;       ///< d, > 0 in contact
  Vec3<T> curved;  ///< kappa q [1]: d falls by P kappa q . dx where x moves sideways
};
template <class T, class Spot>
RingDeflection<T> ring_deflection(const Spot& spot, const T* curvature, const Vec3<T>& x) noexcept {
  const Vec3<T> delta = x - spot.point;
  const T height = dot(delta, spot.normal);
  const Vec3<T> q = delta - spot.normal * height;
  const Vec3<T> curved = curvature_times(curvature, q);
  return {q, height - 0.5 * dot(q, curved), curved};
}
/// The same of a contact whose ring 1 is anchored beside the contact point: hollow curvature, the
/// part of kappa with principal values below 0, counts from the anchor, as the side force does. It
/// is known near the contact point alone, and the depth would grow with the square of the distance.
template <class T>
void count_from_anchor(const T* kappa, const Vec3<T>& anchor, RingDeflection<T>& at) noexcept {
  using std::sqrt;
  if (!(value_of(dot(anchor, anchor)) > kLateralZero_m * kLateralZero_m)) return;
  const T half = 0.5 * (kappa[0] + kappa[1] + kappa[2]);
  const T squares = kappa[0] * kappa[0] + kappa[1] * kappa[1] + kappa[2] * kappa[2] +
                    2.0 * (kappa[3] * kappa[3] + kappa[4] * kappa[4] + kappa[5] * kappa[5]);
  const T off = 0.5 * squares - half * half;  // ((k1 - k2) / 2)^2
  const T apart = value_of(off) > 0 ? sqrt(off) : T(0), most = half + apart;
  if (!(value_of(half) < value_of(apart))) return;
  Vec3<T> hollow = curvature_times(kappa, anchor);
  if (value_of(most) > 0) hollow = (hollow * most - curvature_times(kappa, hollow)) * (0.5 / apart);
  at.depth_m = at.depth_m + 0.5 * dot(hollow, at.q * 2.0 - anchor);
  at.curved = at.curved - hollow;
}

/// lambda |q| - share mu(d + beyond) d [m] (B3): a slide of the contact point brings it to zero.
/// Needs no curve. creep_depth_m: how much deeper the tool is than ring 1 is pressed, where the
/// body relaxes. share: limit_share() where the slide begins.
template <class T, class Spot>
T ring_slip_excess(const Spot& spot, const Vec3<T>& x, const T& creep_depth_m,
                   const T& share) noexcept {
  using std::sqrt;
  const RingNumbers<T> numbers = ring_numbers<T>(spot);
  const RingLimit<T>& limit = numbers.limit;
  const RingDeflection<T> at = ring_deflection(spot, numbers.curvature, x);
  const T squared = dot(at.q, at.q);
  const T size = value_of(squared) > kLateralZero_m * kLateralZero_m ? sqrt(squared) : T(0);
  const T depth = value_of(at.depth_m) > 0 ? at.depth_m : T(0);
  return limit.lambda * size - share * limit.friction_at(depth + creep_depth_m) * depth;
}

/// Anchors of the rings, relative to the contact point and tangential there [m]. Ring 1 is
/// anchored at the contact point itself, at[0] = 0, but where the contact point could not follow.
/// Component by component: compilers then take several rings at once.
template <class T>
struct RingAnchors {
  T x[kRings], y[kRings], z[kRings];
  T out[kRings];          ///< how far outward [m]; that of ring 1 is always 0
  double slip_slope = 0;  ///< see slip_along() [1]

  Vec3<T> at(int i) const noexcept { return {x[i], y[i], z[i]}; }
  void set(int i, const Vec3<T>& a) noexcept {
    x[i] = a.x;
    y[i] = a.y;
    z[i] = a.z;
  }
};

/// After the contact point moved by path_m to a place of another normal: the anchors of rings 2 to
/// N stay where they are in space, but for what sticks out of the tangent plane.
template <class T>
void transport_anchors(RingAnchors<T>& anchors, const Vec3<T>& path_m,
                       const Vec3<T>& normal) noexcept {
  const Vec3<T> first = anchors.at(0);
  for (int i = 0; i < kRings; ++i) anchors.set(i, tangential(anchors.at(i) - path_m, normal));
  anchors.set(0, first);
}

/// Outward deflection of ring i by a press if it has stuck ever since it touched (B1a), and the
/// slope of that by depth. Ring 1 is the middle of the contact, which goes nowhere.
template <class T>
struct RingSpread {
  T value_m, slope;
};
template <class T>
RingSpread<T> ring_spread(const RingTable& table, const RingBed<T>& bed, int i,
                          const T& depth_m) noexcept {
  const T reach = depth_m - table.threshold_m[i];
  if (!(value_of(reach) > 0)) return {T(0), T(0)};
  return {bed.spread_1_m * (reach * (reach + T(2 * table.threshold_m[i]))),
          bed.spread_1_m * (2.0 * depth_m)};
}

/// Response of the rings of a contact at a depth: sum of lambda c_i q_i [N], the energy they store
/// [J], the energy that slipping ones have dissipated [J]. q1: deflection of ring 1. along_N: along
/// the normal, beside the normal curve. flowed_m: of rings that relax, what the dashpots of ring 1
/// have flowed, in the contact's memory.
template <class T>
struct RingResponse {
  Vec3<T> force_N, q1;
  T stored_J;
  double dissipated_J;
  T along_N = T(0);
  const T* flowed_m = nullptr;
};
/// Returns true if a ring slips (B3): lambda times its deflection is beyond limit_m, or it does not
/// touch (limit_m 0). share: what then is left of its deflection.
template <class T>
bool ring_slips(const T& limit_m, const T& lambda_squared, const T& squared_m2, T& share) noexcept {
  using std::sqrt;
  const T length = lambda_squared * squared_m2;
  const bool touches = value_of(limit_m) > 0;
  if (touches && !(value_of(length) > value_of(limit_m) * value_of(limit_m))) return false;
  share = touches ? limit_m / sqrt(length) : T(0);
  return true;
}

/// At anchors that hold, or with kSlips after (B3) of rings 2 to N; share_of_limit: limit_share().
/// Rings that do not touch are then anchored under the tool. A slip shortens every deflection, so
/// the stored energy falls whatever the tick.
template <bool kSlips, class T, class Anchors>
RingResponse<T> ring_response(const RingTable& table, const RingBed<T>& bed,
                              const RingDeflection<T>& at, Anchors& anchors,
                              const T& share_of_limit = T(1)) noexcept {
  const T squared_lambda = bed.limit.lambda * bed.limit.lambda,
          mu = share_of_limit * bed.limit.friction_at(at.depth_m);
  const Vec3<T> q1 = at.q - anchors.at(0);
  Vec3<T> force = q1 * bed.stiffness_N_m[0];
  T twice = bed.stiffness_N_m[0] * dot(q1, q1), along(0);
  double lost = 0;
  for (int i = 1; i < kRings; ++i) {
    const T stiffness = bed.stiffness_N_m[i];
    const RingSpread<T> spread = ring_spread(table, bed, i, at.depth_m);
    Vec3<T> q = at.q - anchors.at(i);
    T r = spread.value_m - anchors.out[i];
    T squared = dot(q, q) + r * r;
    if constexpr (kSlips) {
      const T reach = at.depth_m - table.threshold_m[i];
      const T limit_m = value_of(reach) > 0 ? mu * reach : T(0);
      T share(0);
      if (ring_slips(limit_m, squared_lambda, squared, share)) {
        const double before = value_of(squared);
        q = q * share;
        r = r * share;
        squared = squared * (share * share);
        lost += value_of(stiffness) * (before - value_of(squared));
        anchors.set(i, at.q - q);
        anchors.out[i] = spread.value_m - r;
      }
    }
    force = force + q * stiffness;
    along = along + stiffness * r * spread.slope;
    twice = twice + stiffness * squared;
  }
  return {force, q1, 0.5 * twice, 0.5 * lost, along};
}

/// (B1) and its gradient by x (B2), (f^z + q.g') (u - P kappa q) + g + sum lambda c_i q_i, at
/// anchors that hold. Where d <= 0 there is no force, and what is stored is of rings that end
/// contact at this tick. side: g(d) and its slope; normal_N, normal_J: f^z_c(d) and Z_c(d).
template <class T>
Answer<T> ring_answer(const RingTable& table, const RingBed<T>& bed, const RingDeflection<T>& at,
                      const RingResponse<T>& rings, const SideForce<T>& side, const Vec3<T>& normal,
                      const T& normal_N, const T& normal_J) noexcept {
  const RingShare<T> share = ring_share(table, bed, at.depth_m);
  const T lateral_J = share.value * rings.stored_J;
  if (!(value_of(at.depth_m) > 0)) return {{T(0), T(0), T(0)}, lateral_J};
  // The side force works on ring 1: beyond its anchor the body counts as even.
  const T along_N = normal_N + dot(rings.q1, side.slope_N_m) + share.slope * rings.stored_J +
                    share.value * rings.along_N;
  return {(normal - tangential(at.curved, normal)) * along_N + side.value_N +
              rings.force_N * share.value,
          normal_J + dot(rings.q1, side.value_N) + lateral_J};
}

/// A path as the excess reads it, and the excess at s with its slope. A path that can be read
/// faster brings overloads.
template <class Path>
const Path& ring_slip_path(const Path& path, const Vec3d&) noexcept {
  return path;
}
template <class Path>
Dual ring_excess_along(const Path& path, const Vec3d& x, double s, double creep_depth_m,
                       double share) noexcept {
  return ring_slip_excess(path.at(Dual(s, 1)), widened<Dual>(x), Dual(creep_depth_m), Dual(share));
}

}  // namespace palpate::runtime
