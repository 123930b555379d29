// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// Numbers of a spot of a body of rings (docs/method.md, section 17), and the bed of
// rings under it.

#include "response.hpp"

namespace palpate::runtime {

/// Parts of a node beside its normal curve.
enum RingPart : int {
  kLambda = 1,     ///< lateral over normal stiffness of a ring [1]
  kFriction,       ///< mu_0 [1]
  kFrictionSlope,  ///< mu_1 [1/m]: a ball ploughs
  kSpread,         ///< gamma [1/m]: how far a press spreads a ring that sticks
  kSide2,          ///< g_2 [N/m^2]
  kSide3,          ///< g_3 [N/m^3]
  kCurvature,      ///< kappa = -du/dc [1/m]
  kSway,           ///< C [m/N] of sway.hpp
  kRadiusEffect    ///< k, w [1] of (M83)
};

/// Friction limit of the rings by depth.
template <class T>
struct RingLimit {
  T lambda, friction, friction_slope;

  /// mu(d) [1], never below 0.
  T friction_at(const T& depth_m) const noexcept {
    const T mu = friction + friction_slope * depth_m;
    return value_of(mu) > 0 ? mu : T(0);
  }
};

/// Numbers of a spot that the slip of a contact point reads.
template <class T>
struct RingNumbers {
  RingLimit<T> limit;
  T curvature[6];
};
/// A spot that has them at hand brings an overload.
template <class T, class Spot>
RingNumbers<T> ring_numbers(const Spot& spot) noexcept {
  RingNumbers<T> out{
      {spot.control(kLambda, 0), spot.control(kFriction, 0), spot.control(kFrictionSlope, 0)}, {}};
  copy_controls(spot, kCurvature, 0, 6, out.curvature);
  return out;
}
template <class T>
Vec3<T> curvature_times(const T* kappa, const Vec3<T>& q) noexcept {
  return {kappa[0] * q.x + kappa[3] * q.y + kappa[4] * q.z,
          kappa[3] * q.x + kappa[1] * q.y + kappa[5] * q.z,
          kappa[4] * q.x + kappa[5] * q.y + kappa[2] * q.z};
}

/// Returns true if nodes have a stiffness of their own for the indenter's radius.
inline bool has_radius_effect(const CurveViews& views) noexcept {
  return views.indenter != nullptr && views.indenter->has_radius_effect;
}

/// The curvature of the surface of a ball's centres (M15b) becomes that of the surface which lies
/// surface_offset_m farther out, k / (1 + offset k) of each principal one. A hollow keeps
/// kMinHollowShare of its radius.
inline void offset_curvature(double* kappa, double surface_offset_m) noexcept {
  const double trace = kappa[0] + kappa[1] + kappa[2];
  const double squares = kappa[0] * kappa[0] + kappa[1] * kappa[1] + kappa[2] * kappa[2] +
                         2 * (kappa[3] * kappa[3] + kappa[4] * kappa[4] + kappa[5] * kappa[5]);
  const double half = 0.5 * trace, deviator = 0.5 * squares - half * half;  // ((k1 - k2) / 2)^2
  const double apart = deviator > 0 ? std::sqrt(deviator) : 0;
  const auto share = [surface_offset_m](double k) noexcept {
    const double radii = 1 + surface_offset_m * k;
    return 1 / (radii > kMinHollowShare ? radii : kMinHollowShare);
  };
  const double first = share(half + apart), second = share(half - apart);
  // f(K) = a K + b K^2 with f(k) = share(k) k of both
  const double b =
      apart > 1e-9 * std::fabs(trace) && apart > 0 ? (first - second) / (2 * apart) : 0;
  const double a = first - b * (half + apart);
  const double square[6] = {kappa[0] * kappa[0] + kappa[3] * kappa[3] + kappa[4] * kappa[4],
                            kappa[3] * kappa[3] + kappa[1] * kappa[1] + kappa[5] * kappa[5],
                            kappa[4] * kappa[4] + kappa[5] * kappa[5] + kappa[2] * kappa[2],
                            kappa[0] * kappa[3] + kappa[3] * kappa[1] + kappa[4] * kappa[5],
                            kappa[0] * kappa[4] + kappa[3] * kappa[5] + kappa[4] * kappa[2],
                            kappa[3] * kappa[4] + kappa[1] * kappa[5] + kappa[5] * kappa[2]};
  for (int i = 0; i < 6; ++i) kappa[i] = a * kappa[i] + b * square[i];
}

/// The rings under a spot and the side force there.
template <class T>
struct RingBed {
  RingLimit<T> limit;
  T stiffness_N_m[kRings];  ///< lambda c_i >= 0
  /// lambda c_i that was cut at 0 where the normal curve is concave, as its size, where is_cut; see
  /// ring_share().
  T excess_N_m[kRings];
  bool is_cut;
  T spread_1_m;          ///< gamma >= 0
  Vec3<T> side2, side3;  ///< g = side2 d^2 + side3 d^3, tangential
};

/// f^z' at the edges [N/m]; with the order known the compiler unrolls it.
template <int kOrder, class T, class Spot>
void edge_slopes(const RingTable& table, const Spot& spot, T* slope) noexcept {
  for (int i = 0; i < kRings; ++i) {
    const auto live = live_controls<kOrder>(spot, kNormal, table.first[i]);
    slope[i] = live.b[0] * table.slope[i][0];
    for (int k = 1; k < kOrder; ++k) slope[i] = slope[i] + live.b[k] * table.slope[i][k];
  }
}

/// c_i [N/m] (B0) of a spot.
template <class T, class Spot>
void ring_stiffness(const RingTable& table, const Spot& spot, T* c) noexcept {
  switch (table.order) {
    case 2:
      edge_slopes<2>(table, spot, c);
      break;
    case 3:
      edge_slopes<3>(table, spot, c);
      break;
    case 4:
      edge_slopes<4>(table, spot, c);
      break;
    default:
      edge_slopes<5>(table, spot, c);
  }
  for (int i = kRings - 1; i > 0; --i) c[i] = c[i] - c[i - 1];
}

/// Makes the bed from the c_i of a spot; side: g_2, g_3.
template <class T>
void make_ring_bed(const T* c, const RingLimit<T>& limit, const T& spread_1_m, const T* side,
                   const Vec3<T>& normal, RingBed<T>& bed) noexcept {
  bed.limit = limit;
  bed.spread_1_m = spread_1_m;
  bed.is_cut = false;
  for (int i = 0; i < kRings; ++i) {
    bed.stiffness_N_m[i] = limit.lambda * c[i];
    bed.is_cut |= !(value_of(bed.stiffness_N_m[i]) >= 0);
  }
  for (int i = 0; bed.is_cut && i < kRings; ++i) {
    const T stiffness = bed.stiffness_N_m[i];
    const bool is_cut = !(value_of(stiffness) >= 0);
    bed.stiffness_N_m[i] = is_cut ? T(0) : stiffness;
    bed.excess_N_m[i] = is_cut ? T(0) - stiffness : T(0);
  }
  bed.side2 = tangential<T>({side[0], side[1], side[2]}, normal);
  bed.side3 = tangential<T>({side[3], side[4], side[5]}, normal);
}
template <class T, class Spot>
RingBed<T> ring_bed(const RingTable& table, const Spot& spot) noexcept {
  RingBed<T> bed;
  T c[kRings], side[6];
  ring_stiffness(table, spot, c);
  copy_controls(spot, kSide2, 0, 3, side);
  copy_controls(spot, kSide3, 0, 3, side + 3);
  make_ring_bed(c, ring_numbers<T>(spot).limit, T(spot.control(kSpread, 0)), side, spot.normal,
                bed);
  return bed;
}

/// Mean indentation of the springs of a ring that lie evenly between its edges, and
/// the slope of that by depth; of ring 1 the share at_0 lies at depth 0. So the force of rings in
/// slow motion is never more than the curve says, and a body never pulls.
template <class T>
struct RingPress {
  T value_m, slope;
};
template <class T>
RingPress<T> ring_press(const RingTable& table, const T& at_0, int i, const T& depth_m) noexcept {
  const double from = i > 0 ? table.edge_m[i - 1] : 0, width = table.edge_m[i] - from;
  const T in = depth_m - from;
  if (!(value_of(in) > 0)) return {T(0), T(0)};
  const bool is_part = value_of(in) < width;
  const RingPress<T> even{is_part ? in * in * (0.5 / width) : in - 0.5 * width,
                          is_part ? in * (1 / width) : T(1)};
  if (i > 0) return even;
  return {at_0 * in + (T(1) - at_0) * even.value_m, at_0 + (T(1) - at_0) * even.slope};
}
/// 1 where every ring has the stiffness that the curve says. Where the curve is concave, rings that
/// would be negative are none, and the others carry sum c_i h_i / sum max(c_i, 0) h_i of theirs, so
/// that the whole bed still carries f^z. Its slope belongs to the energy, so h_i is the mean press
/// of springs that lie evenly between the edges: a force of d - d_i would step where a ring
/// touches.
template <class T>
struct RingShare {
  T value, slope;
};
template <class T>
RingShare<T> ring_share(const RingTable& table, const RingBed<T>& bed, const T& depth_m) noexcept {
  if (!bed.is_cut) return {T(1), T(0)};
  T kept = T(0), cut = T(0), kept_slope = T(0), cut_slope = T(0);
  for (int i = 0; i < kRings; ++i) {
    const RingPress<T> press = ring_press(table, T(1), i, depth_m);
    if (!(value_of(press.value_m) > 0)) break;
    kept = kept + bed.stiffness_N_m[i] * press.value_m;
    cut = cut + bed.excess_N_m[i] * press.value_m;
    kept_slope = kept_slope + bed.stiffness_N_m[i] * press.slope;
    cut_slope = cut_slope + bed.excess_N_m[i] * press.slope;
  }
  if (!(value_of(kept) > value_of(cut))) return {T(value_of(kept) > 0 ? 0 : 1), T(0)};
  const T ratio = cut / kept;
  return {T(1) - ratio, (ratio * kept_slope - cut_slope) / kept};
}

/// f^z(d) over sum c_i h_i, which the limits of the rings are times (B3a): all at their limits then
/// carry mu(d) f^z(d) at every depth, also where few of them touch. normal_N: f^z(d).
template <class T>
T limit_share(const RingTable& table, const RingBed<T>& bed, const T& depth_m,
              const T& normal_N) noexcept {
  if (!(value_of(depth_m) > 0)) return T(1);
  T sum = bed.stiffness_N_m[0] * depth_m;
  for (int i = 1; i < kRings; ++i) {
    const T reach = depth_m - table.threshold_m[i];
    if (!(value_of(reach) > 0)) break;
    sum = sum + bed.stiffness_N_m[i] * reach;
  }
  for (int i = 0; bed.is_cut && i < kRings; ++i) {
    const T reach = depth_m - table.threshold_m[i];
    sum = sum - bed.excess_N_m[i] * (value_of(reach) > 0 ? reach : T(0));
  }
  const T carried_m = bed.limit.lambda * normal_N;
  if (!(value_of(sum) > 0)) return T(1);
  return value_of(carried_m) < kMaxLimitShare * value_of(sum) ? carried_m / sum : T(kMaxLimitShare);
}

/// g(d) and its slope.
template <class T>
struct SideForce {
  Vec3<T> value_N, slope_N_m;
};
template <class T>
SideForce<T> side_force(const RingBed<T>& bed, const T& depth_m) noexcept {
  const T d = depth_m, dd = d * d;
  return {bed.side2 * dd + bed.side3 * (dd * d), bed.side2 * (2.0 * d) + bed.side3 * (3.0 * dd)};
}

/// The rings under a spot. A spot that has them at hand brings an overload.
template <class T, class Spot>
RingBed<T> bed_at(const CurveViews& views, const Spot& spot) noexcept {
  return ring_bed<T>(views.rings, spot);
}

}  // namespace palpate::runtime
