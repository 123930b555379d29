// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// What a spot of a body of rings gives (docs/method.md, section 17): its numbers, and the bed of
// rings under it.

#include "../response.hpp"

namespace palpate {
namespace runtime {

/// Parts of a node beside its normal curve.
constexpr int kLambda = 1;         ///< lateral over normal stiffness of a ring [1]
constexpr int kFriction = 2;       ///< mu_0 [1]
constexpr int kFrictionSlope = 3;  ///< mu_1 [1/m]: a ball ploughs
constexpr int kSide2 = 4;          ///< g_2 [N/m^2]
constexpr int kSide3 = 5;          ///< g_3 [N/m^3]
constexpr int kCurvature = 6;      ///< kappa = -du/dc [1/m]
constexpr int kRingNumbers = 15;   ///< of all these parts, in turn

/// How far a ring may be deflected at a depth.
template <class T>
struct RingLimit {
  T lambda, friction, friction_slope;

  /// mu(d) [1], never below 0.
  T friction_at(const T& depth_m) const noexcept {
    const T mu = friction + friction_slope * depth_m;
    return value_of(mu) > 0 ? mu : T(0);
  }
};
template <class T, class Spot>
RingLimit<T> ring_limit(const Spot& spot) noexcept {
  return {spot.control(kLambda, 0), spot.control(kFriction, 0), spot.control(kFrictionSlope, 0)};
}

/// The rings under a spot and the side force there.
template <class T, int N>
struct RingBed {
  RingLimit<T> limit;
  T stiffness_N_m[N];  ///< lambda c_i >= 0
  /// lambda c_i that was cut at 0 where the normal curve is concave, as its size; see ring_share().
  T excess_N_m[N];
  bool is_cut;
  Vec3<T> side2, side3;  ///< g = side2 d^2 + side3 d^3, tangential
};

/// f^z' at the edges [N/m]; with the order known the compiler unrolls it.
template <int kOrder, class T, int N, class Spot>
void edge_slopes(const RingTable<N>& table, const Spot& spot, T* slope) noexcept {
  constexpr int kRow = 16;  // control values that are read in one go
  T row[kRow];
  int begin = 0, end = 0;
  for (int i = 0; i < N; ++i) {
    const int first = table.first[i], size = table.first[N - 1] + kOrder;
    if (first + kOrder > end) {
      begin = first;
      end = size - begin < kRow ? size : begin + kRow;
      copy_controls(spot, kNormal, begin, end - begin, row);
    }
    const T* b = row + (first - begin);
    slope[i] = b[0] * table.slope[i][0];
    for (int k = 1; k < kOrder; ++k) slope[i] = slope[i] + b[k] * table.slope[i][k];
  }
}

template <class T, int N, class Spot>
void make_ring_bed(const RingTable<N>& table, const Spot& spot, RingBed<T, N>& bed) noexcept {
  T slope[N];
  switch (table.order) {
    case 2:
      edge_slopes<2>(table, spot, slope);
      break;
    case 3:
      edge_slopes<3>(table, spot, slope);
      break;
    case 4:
      edge_slopes<4>(table, spot, slope);
      break;
    default:
      edge_slopes<5>(table, spot, slope);
  }
  bed.limit = ring_limit<T>(spot);
  bed.is_cut = false;
  for (int i = 0; i < N; ++i) {
    const T stiffness = bed.limit.lambda * (i == 0 ? slope[i] : slope[i] - slope[i - 1]);
    const bool is_cut = !(value_of(stiffness) >= 0);
    bed.stiffness_N_m[i] = is_cut ? T(0) : stiffness;
    bed.excess_N_m[i] = is_cut ? T(0) - stiffness : T(0);
    bed.is_cut = bed.is_cut || is_cut;
  }
  const auto vector = [&](int part) noexcept {
    return tangential<T>({spot.control(part, 0), spot.control(part, 1), spot.control(part, 2)},
                         spot.normal);
  };
  bed.side2 = vector(kSide2);
  bed.side3 = vector(kSide3);
}
template <class T, int N, class Spot>
RingBed<T, N> ring_bed(const RingTable<N>& table, const Spot& spot) noexcept {
  RingBed<T, N> bed;
  make_ring_bed(table, spot, bed);
  return bed;
}

/// 1 where every ring has the stiffness that the curve says. Where the curve is concave, rings that
/// would be negative are none, and the others bear sum c_i h_i / sum max(c_i, 0) h_i of theirs, so
/// that the whole bed still bears f^z. Its slope belongs to the energy.
template <class T>
struct RingShare {
  T value, slope;
};
template <class T, int N>
RingShare<T> ring_share(const RingTable<N>& table, const RingBed<T, N>& bed,
                        const T& depth_m) noexcept {
  if (!bed.is_cut) return {T(1), T(0)};
  T kept = T(0), cut = T(0), kept_slope = T(0), cut_slope = T(0);
  for (int i = 0; i < N; ++i) {
    const T reach = depth_m - table.threshold_m[i];
    if (!(value_of(reach) > 0)) break;
    kept = kept + bed.stiffness_N_m[i] * reach;
    cut = cut + bed.excess_N_m[i] * reach;
    kept_slope = kept_slope + bed.stiffness_N_m[i];
    cut_slope = cut_slope + bed.excess_N_m[i];
  }
  if (!(value_of(kept) > value_of(cut))) return {T(value_of(kept) > 0 ? 0 : 1), T(0)};
  const T ratio = cut / kept;
  return {T(1) - ratio, (ratio * kept_slope - cut_slope) / kept};
}

/// g(d) and its slope.
template <class T>
struct SideForce {
  Vec3<T> value_N, slope_N_m;
};
template <class T, int N>
SideForce<T> side_force(const RingBed<T, N>& bed, const T& depth_m) noexcept {
  const T d = depth_m, dd = d * d;
  return {bed.side2 * dd + bed.side3 * (dd * d), bed.side2 * (2.0 * d) + bed.side3 * (3.0 * dd)};
}

/// The rings under a spot. A spot that has them at hand brings an overload.
template <class T, class Spot>
RingBed<T, kRings> bed_under(const CurveViews& views, const Spot& spot) noexcept {
  return ring_bed<T>(views.rings, spot);
}

}  // namespace runtime
}  // namespace palpate
