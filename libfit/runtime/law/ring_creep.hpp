// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// Rings that relax (docs/method-body.md, section 24). Beside its spring c_i each ring has Maxwell
// branches, springs share_k c_i in series with dashpots that have flowed by v_k along the normal
// and by w_k across it. A ring stores
//
//     1/2 c_i (y^2 + sum share_k (y - v_k)^2) + 1/2 lambda c_i (|q|^2 + sum share_k |q - w_k|^2)
//
// with y >= h_i the place of the surface: where the tool retracts faster than the ring follows, y
// is where the ring would come to rest, and the ring carries nothing (M46).

#include "relaxation.hpp"
#include "ring_law.hpp"

namespace palpate::runtime {

/// Viscous flow of the rings, and the deflections at which they would come to rest [m].
template <class T>
struct RingCreep {
  T flow[kMaxBranches][4][kRings];  ///< of each branch v_k, then x, y, z of w_k
  // sum share_k v_k / fast and likewise w; what is stored though the ring carries nothing, over
  // half its normal and its lateral stiffness [m^2].
  T rests[4][kRings], locked[2][kRings];
  T first[kMaxBranches];    ///< v_k of ring 1
  T renewed[kMaxBranches];  ///< s_k: of each branch, the share of the material that slides renewed

  Vec3<T> rest(int i) const noexcept { return {rests[1][i], rests[2][i], rests[3][i]}; }
};
inline double still_flowing(double left_m) noexcept {
  return std::fabs(left_m) > kMinFlow_m ? left_m : 0;
}
template <class T>
const T& still_flowing(const T& left_m) noexcept {  // derivatives are not over
  return left_m;
}
constexpr int kCreepNumbers = kMaxBranches * (4 * kRings + 1);  ///< of a contact

/// The share of ring 1 that lies at depth 0: f^z'(0) of f^z'(e_1).
template <class T, class Spot>
T share_at_0(const RingTable& table, const RingBed<T>& bed, const Spot& spot) noexcept {
  T slope = spot.control(kNormal, table.first_at_0 + 1) * table.slope_at_0[1];
  for (int k = 0; k < table.order; ++k)
    if (k != 1 && table.slope_at_0[k] != 0)
      slope = slope + spot.control(kNormal, table.first_at_0 + k) * table.slope_at_0[k];
  slope = bed.limit.lambda * slope;
  const T all = bed.stiffness_N_m[0];
  if (!(value_of(slope) > 0)) return T(0);
  return value_of(slope) < value_of(all) ? slope / all : T(1);
}

/// Brings the rests up to the branches. Ring by ring within a component: compilers then take
/// several rings at once.
template <class T>
void find_rests(const RelaxationView& relaxation, RingCreep<T>& creep) noexcept {
  const double scale = 1 / relaxation.fast;
  for (int c = 0; c < 4; ++c) {
    T sum[kRings], square[kRings];
    for (int i = 0; i < kRings; ++i) sum[i] = square[i] = T(0);
    for (int k = 0; k < relaxation.branches; ++k) {
      const double share = relaxation.share[k];
      for (int i = 0; i < kRings; ++i) {
        const T part = creep.flow[k][c][i] * share;
        sum[i] = sum[i] + part;
        square[i] = square[i] + part * creep.flow[k][c][i];
      }
    }
    T* const locked = creep.locked[c > 0];
    for (int i = 0; i < kRings; ++i) {
      const T more = square[i] - sum[i] * sum[i] * scale;
      locked[i] = c < 2 ? more : locked[i] + more;
      creep.rests[c][i] = sum[i] * scale;
    }
  }
  for (int k = 0; k < relaxation.branches; ++k) creep.first[k] = creep.flow[k][0][0];
}

/// The dashpots flow while the tool rests (M47): v_k nears y, w_k nears q, by the share of each
/// branch's force that `left` does not leave. What rings store falls.
template <class T>
void relax_rings(const RelaxationView& relaxation, const Decay& left, const RingTable& table,
                 const T& at_0, const RingDeflection<T>& at, const RingAnchors<T>& anchors,
                 RingCreep<T>& creep) noexcept {
  T to[4][kRings];
  for (int i = 0; i < kRings; ++i) {
    const T h = ring_press(table, at_0, i, at.depth_m).value_m;
    const bool carries = value_of(h) > value_of(creep.rests[0][i]);
    const Vec3<T> q = carries ? at.q - anchors.at(i) : creep.rest(i);
    to[0][i] = carries ? h : creep.rests[0][i];
    to[1][i] = q.x;
    to[2][i] = q.y;
    to[3][i] = q.z;
  }
  for (int k = 0; k < relaxation.branches; ++k) {
    const double share = left.share[k];
    for (int c = 0; c < 4; ++c)
      for (int i = 0; i < kRings; ++i)
        creep.flow[k][c][i] = to[c][i] - still_flowing((to[c][i] - creep.flow[k][c][i]) * share);
    creep.renewed[k] = still_flowing(creep.renewed[k] * share);
  }
  find_rests(relaxation, creep);
}

/// The contact point went to a place of this normal: what dashpots flowed across the old one.
template <class T>
void project_creep(const RelaxationView& relaxation, const Vec3<T>& normal,
                   RingCreep<T>& creep) noexcept {
  for (int k = 0; k < relaxation.branches; ++k)
    for (int i = 0; i < kRings; ++i) {
      const Vec3<T> w =
          tangential<T>({creep.flow[k][1][i], creep.flow[k][2][i], creep.flow[k][3][i]}, normal);
      creep.flow[k][1][i] = w.x;
      creep.flow[k][2][i] = w.y;
      creep.flow[k][3][i] = w.z;
    }
  find_rests(relaxation, creep);
}

/// Largest deflection of a ring from its rest, times lambda / mu (M48): by
/// its spring where it touches, and by its branches. share: limit_share(), of the spring.
template <class T>
T creep_slip_reach(const RelaxationView& relaxation, const RingTable& table,
                   const RingCreep<T>& creep, const T& at_0, int i, const T& depth_m,
                   const T& share) noexcept {
  const T touching = share * (depth_m - table.threshold_m[i]);
  const T spring = value_of(touching) > 0 ? touching : T(0);
  const T press = ring_press(table, at_0, i, depth_m).value_m;
  return (spring + press * (relaxation.fast - 1)) * (1 / relaxation.fast) - creep.rests[0][i];
}

/// Length [m] over which a slide renews the material under a ball at a depth, 1.3 contact radii:
/// l^2 = kRenewal R d (M48a).
template <class T>
T renewal_length_m(const RelaxationView& relaxation, const T& depth_m) noexcept {
  using std::sqrt;
  return sqrt(kRenewal * relaxation.radius_m * depth_m);
}

/// By which share the drag of new material raises the limit of friction (M48a): sum of
/// share_k c_i s_k v_k [2 (h_i - v_k)/(1 + s_k) + v_k (1 - s_k)]/l over mu times the force. The
/// first part is what the slide raises the energy of branches by, the second is lost.
template <class T>
T ploughing_share(const RelaxationView& relaxation, const RingTable& table, const RingBed<T>& bed,
                  const RingCreep<T>& creep, const T& at_0, const T& depth_m) noexcept {
  T raised(0), carried(0);
  for (int i = 0; i < kRings; ++i) {
    const T h = ring_press(table, at_0, i, depth_m).value_m, free = h - creep.rests[0][i];
    if (!(value_of(free) > 0)) continue;
    carried = carried + bed.stiffness_N_m[i] * free * relaxation.fast;
    for (int k = 0; k < relaxation.branches; ++k) {
      const T v = creep.flow[k][0][i], s = creep.renewed[k];
      raised = raised + bed.stiffness_N_m[i] * relaxation.share[k] * s * v *
                            ((h - v) * (2.0 / (T(1) + s)) + v * (T(1) - s));
    }
  }
  const T limit_N = bed.limit.friction_at(depth_m) * carried;
  if (!(value_of(limit_N) > 0 && value_of(raised) > 0)) return T(0);
  return raised / (limit_N * renewal_length_m(relaxation, depth_m));
}

/// The contact slid over path_m: s_k nears 1, and v_k goes as 1 - s_k^2.
template <class T>
void renew_rings(const RelaxationView& relaxation, const T& length_m, const Vec3<T>& path_m,
                 RingCreep<T>& creep) noexcept {
  using std::sqrt;
  const T squared = dot(path_m, path_m);
  if (!(value_of(squared) > 0)) return;
  const T left = decay(sqrt(squared) / length_m);
  for (int k = 0; k < relaxation.branches; ++k) {
    const T before = creep.renewed[k], after = T(1) - (T(1) - before) * left;
    const T kept = left * (T(1) + after) / (T(1) + before);
    for (int i = 0; i < kRings; ++i) creep.flow[k][0][i] = creep.flow[k][0][i] * kept;
    creep.renewed[k] = after;
  }
  find_rests(relaxation, creep);
}

/// ring_response() of rings that relax: forces and energy of springs and
/// branches, over what the normal curve says of slow motion. A ring slips where its traction is
/// above the friction of what it carries, |q - rest| > mu(d) (h - rest) / lambda (M48); dashpots
/// hold still in a slip, so it shortens |q - rest| and what is stored falls; the caller books by
/// energies, so dissipated_J is 0.
template <bool kSlips, class T, class Anchors>
RingResponse<T> creep_response(const RelaxationView& relaxation, const RingTable& table,
                               const RingBed<T>& bed, const RingDeflection<T>& at, Anchors& anchors,
                               const RingCreep<T>& creep, const T& at_0, const T& share_of_limit,
                               const T& ploughing) noexcept {
  const double fast = relaxation.fast;
  const T lambda = bed.limit.lambda, mu = ploughing * bed.limit.friction_at(at.depth_m);
  const bool is_stiff = value_of(lambda) > 0;
  Vec3<T> force{T(0), T(0), T(0)};
  T twice(0), along(0);
  for (int i = 0; i < kRings; ++i) {
    const T stiffness = bed.stiffness_N_m[i], normal = is_stiff ? stiffness / lambda : T(0);
    const RingPress<T> press = ring_press(table, at_0, i, at.depth_m);
    const T h = press.value_m, rest = creep.rests[0][i];
    const T carried_m = value_of(h) > value_of(rest) ? h - rest : T(0);
    Vec3<T> q = at.q - anchors.at(i) - creep.rest(i);
    T squared = dot(q, q);
    if (kSlips && i > 0) {
      const T reach =
          creep_slip_reach(relaxation, table, creep, at_0, i, at.depth_m, share_of_limit);
      const T limit_m = value_of(reach) > 0 ? mu * reach : T(0);
      T share(0);
      if (ring_slips(limit_m, lambda * lambda, squared, share)) {
        q = q * share;
        squared = squared * (share * share);
        if constexpr (kSlips) anchors.set(i, at.q - creep.rest(i) - q);
      }
    }
    force = force + q * (stiffness * fast);
    along = along + normal * (carried_m * fast - h) * press.slope;
    twice = twice + stiffness * (squared * fast + creep.locked[1][i]) +
            normal * (carried_m * carried_m * fast + creep.locked[0][i] - h * h);
  }
  return {force, at.q - anchors.at(0), 0.5 * twice, 0, along, creep.first};
}

/// g(d), and for each branch its share of g at the depth that is left to its dashpot of ring 1: the
/// side force right after a step and at rest, and smooth between (M49).
template <class T>
SideForce<T> creep_side_force(const RelaxationView& relaxation, const RingBed<T>& bed,
                              const T& depth_m, const T* flowed_m) noexcept {
  SideForce<T> out = side_force(bed, depth_m);
  for (int k = 0; k < relaxation.branches; ++k) {
    const T left = depth_m - flowed_m[k];
    if (!(value_of(left) > 0)) continue;
    const SideForce<T> side = side_force(bed, left);
    out.value_N = out.value_N + side.value_N * relaxation.share[k];
    out.slope_N_m = out.slope_N_m + side.slope_N_m * relaxation.share[k];
  }
  return out;
}

}  // namespace palpate::runtime
