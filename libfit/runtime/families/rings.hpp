// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// The family of rings: ring_law.hpp behind the interface of families.hpp. Gross slip is the slip of
// ring 1, the last to go: the contact point slides over the surface until |q| is at its limit.

#include <type_traits>

#include "../slide.hpp"
#include "part.hpp"
#include "ring_law.hpp"

namespace palpate {
namespace runtime {

/// Where the fitter's spot lies from the test point about which the body is uneven; nowhere
/// else.
template <class Spot>
struct IsUneven : std::false_type {};

/// Depth and lateral deflection as outputs have them.
template <class T>
struct RingDepth {
  T normal_m;   ///< d of (B1)
  T lateral_m;  ///< |q|
};
template <class T, class Spot>
struct RingFooting {
  Spot spot;
  RingDepth<T> d;
  RingStance<T> at;
  RingLimit<T> limit;
  Vec3<T> q1;  ///< deflection of ring 1
};

struct Rings {
  static constexpr const char* kName = "rings";
  static constexpr Part kPart[] = {
      rising_curve("normal"),
      {"lambda", "1", 0, 0, 1, 1, false, false, 0, 100},
      {"friction", "1", 0, 0, 1, 1, false, false, 0, 100},
      {"friction_slope", "1/m", -1, 0, 1, 1, false, false, -1e6, 1e6},
      {"side_square", "N/m^2", -2, 1, 3, 1, false, false, -kMaxNumber, kMaxNumber},
      {"side_cube", "N/m^3", -3, 1, 3, 1, false, false, -kMaxNumber, kMaxNumber},
      {"curvature", "1/m", -1, 0, 6, 1, false, false, -1e6, 1e6, true}};
  static constexpr int kCurves = 1;
  static constexpr int kNumbers = kRingNumbers;
  static constexpr int kMemory = 3 * kRings;

  template <class T>
  using Memory = RingAnchors<T, kRings>;
  template <class T>
  static Memory<T> load(const double* from) noexcept {
    Memory<T> out;
    for (int i = 0; i < kRings; ++i) out.at[i] = make_vec3<T>(from + 3 * i);
    return out;
  }
  static void save(const Memory<double>& memory, double* to) noexcept {
    for (int i = 0; i < kRings; ++i) {
      to[3 * i] = memory.at[i].x;
      to[3 * i + 1] = memory.at[i].y;
      to[3 * i + 2] = memory.at[i].z;
    }
  }

  template <class Spot>
  static bool is_frictionless(const CurveViews&, const Spot& spot) noexcept {
    return !(value_of(spot.control(kLambda, 0)) > 0);
  }
  template <class T, class Spot>
  static RingFooting<T, Spot> footing(const CurveViews&, const Spot& spot, const Vec3<T>& x,
                                      const Memory<T>& memory) noexcept {
    using std::sqrt;
    const RingStance<T> at = ring_stance(spot, x);
    const T squared = dot(at.q, at.q);
    const bool is_aside = value_of(squared) > kLateralZero_m * kLateralZero_m;
    return {spot,
            {at.depth_m, is_aside ? sqrt(squared) : T(0)},
            at,
            ring_limit<T>(spot),
            at.q - memory.at[0]};
  }

  /// The same footing at a spot of the same place.
  template <class T, class Spot, class Other>
  static RingFooting<T, Other> at_spot(const RingFooting<T, Spot>& foot,
                                       const Other& spot) noexcept {
    return {spot, foot.d, foot.at, foot.limit, foot.q1};
  }

  /// Whether ring 1 is beyond its limit.
  template <class T, class Spot>
  static bool is_slipping(const CurveViews&, const RingFooting<T, Spot>& foot) noexcept {
    const double squared = value_of(dot(foot.q1, foot.q1));
    if (!(squared > kLateralZero_m * kLateralZero_m)) return false;
    const double lambda = value_of(foot.limit.lambda), most = value_of(most_of(foot));
    return lambda * lambda * squared * (1 - 2 * kSlipTolerance) > most * most;
  }
  template <class T>
  static bool is_out(const Memory<T>& memory) noexcept {
    const Vec3d rest = values_of(memory.at[0]);
    return rest.x != 0 || rest.y != 0 || rest.z != 0;
  }
  template <class T>
  static Vec3<T> rest(const Memory<T>& memory) noexcept {
    return memory.at[0];
  }
  template <class T, class Spot>
  static Pull<T> pull(const RingFooting<T, Spot>& foot) noexcept {
    return {foot.at.q * (1.0 / foot.d.lateral_m), foot.d.lateral_m};
  }

  /// What a slip brings to zero (B3): lambda |q| - mu(d) d.
  struct Excess {};
  template <class T, class Spot>
  static Excess excess_kind(const CurveViews&, const RingFooting<T, Spot>&) noexcept {
    return {};
  }
  template <class T, class Spot>
  static double excess_scale(const CurveViews&, const RingFooting<T, Spot>& foot, Excess) noexcept {
    return value_of(foot.limit.lambda) * value_of(foot.d.lateral_m);
  }
  template <class T, class Spot>
  static T excess(const CurveViews&, const Spot& spot, const Vec3<T>& x, Excess) noexcept {
    return ring_slip_excess(spot, x);
  }
  template <class Path>
  static decltype(auto) way(const Path& path) noexcept {
    return way_of_excess(path);
  }
  template <class Way>
  static Dual excess_along(const CurveViews&, const Way& way, const Vec3d& x, double s,
                           Excess) noexcept {
    return ring_excess_along(way, x, s);
  }
  template <class Spot>
  static double lateral_m(const CurveViews&, const Spot& spot, const Vec3d& x) noexcept {
    const Vec3d q = tangential(x - spot.point, spot.normal);
    return std::sqrt(dot(q, q));
  }

  /// The contact point moved by `way`: ring 1's anchor stays, or the contact point is there again.
  template <class T>
  static void carry_rest(Memory<T>& memory, const Vec3<T>& way, const Vec3<T>& normal,
                         bool is_there) noexcept {
    memory.at[0] = is_there ? Vec3<T>{T(0), T(0), T(0)} : tangential(memory.at[0] - way, normal);
  }
  /// The other anchors, once a tick.
  template <class T>
  static void carry(Memory<T>& memory, const Vec3<T>& way, const Vec3<T>& normal) noexcept {
    carry_anchors(memory, way, normal);
  }
  /// Ring 1 slips without the contact point.
  template <class T, class Spot>
  static void let_go(const CurveViews& views, RingFooting<T, Spot>& foot,
                     Memory<T>& memory) noexcept {
    using std::sqrt;
    if (!is_slipping(views, foot)) return;
    const T most = most_of(foot), length = foot.limit.lambda * sqrt(dot(foot.q1, foot.q1));
    foot.q1 = foot.q1 * (value_of(most) > 0 ? most / length : T(0));
    memory.at[0] = foot.at.q - foot.q1;
  }

  /// The bed under the spot: made once a tick, read by what follows.
  template <class T, class Spot>
  static decltype(auto) under(const CurveViews& views, const RingFooting<T, Spot>& foot) noexcept {
    return bed_under<T>(views, foot.spot);
  }
  template <class T, class Spot>
  static RingPull<T> hold(const CurveViews&, const RingBed<T, kRings>& bed,
                          const RingFooting<T, Spot>& foot, const Memory<T>& memory) noexcept {
    return ring_pull(bed, foot.at, memory);
  }
  template <class T, class Spot>
  static RingPull<T> settle(const CurveViews& views, const RingBed<T, kRings>& bed,
                            const RingFooting<T, Spot>& foot, Memory<T>& memory) noexcept {
    RingPull<T> pull = settle_rings(views.rings, bed, foot.at, memory);
    if (bed.is_cut) pull.lost_J *= value_of(ring_share(views.rings, bed, foot.at.depth_m).value);
    return pull;
  }
  /// (B1) and (B2).
  template <class T, class Spot>
  static Answer<T> answer(const CurveViews& views, const RingBed<T, kRings>& bed,
                          const RingFooting<T, Spot>& foot, const RingPull<T>& pull) noexcept {
    const T d = foot.at.depth_m;
    T normal_N = T(0), normal_J = T(0);
    if (value_of(d) > 0) {
      const auto& piece = piece_under(views, foot.spot, kNormal, value_of(d), true);
      normal_N = piece.force(d);
      normal_J = piece.energy(d);
    }
    if constexpr (IsUneven<Spot>::value) {
      RingPull<T> uneven = pull;
      const auto added = unevenness(foot.spot, bed, d, normal_N);
      uneven.force_N = pull.force_N * added.stiffening;
      uneven.stored_J = pull.stored_J * added.stiffening;
      normal_N = normal_N + added.slope_N_m;
      normal_J = normal_J + added.value_N;
      return ring_answer(views.rings, bed, foot.at, uneven, foot.spot.normal, normal_N, normal_J);
    } else {
      return ring_answer(views.rings, bed, foot.at, pull, foot.spot.normal, normal_N, normal_J);
    }
  }

 private:
  /// lambda times the limit of ring 1.
  template <class T, class Spot>
  static T most_of(const RingFooting<T, Spot>& foot) noexcept {
    if (!(value_of(foot.at.depth_m) > 0)) return T(0);
    return foot.limit.friction_at(foot.at.depth_m) * foot.at.depth_m;
  }
};

}  // namespace runtime
}  // namespace palpate
