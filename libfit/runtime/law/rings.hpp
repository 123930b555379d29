// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// The family of rings: ring_law.hpp behind the interface of families.hpp. Gross slip is the slip of
// ring 1, the last to go: the contact point slides over the surface until |q| is at its limit.

#include <type_traits>

#include "ring_creep.hpp"
#include "slide.hpp"

namespace palpate::runtime {

/// True if the law lets the body change along the path of the contact point (section 17, uneven
/// bodies): at the fitter's spots. On a mesh the blended curves do.
template <class Spot>
struct IsUneven : std::false_type {};

/// Depth and lateral deflection as outputs have them.
template <class T>
struct RingDepth {
  T normal_m;   ///< d of (B1)
  T lateral_m;  ///< |q|
};
template <class T, class Spot>
struct RingKinematics {
  Spot spot;
  RingDepth<T> d;
  RingDeflection<T> at;
  RingLimit<T> limit;
  Vec3<T> q1;  ///< deflection of ring 1
  T creep_depth_m;
  T normal_N;  ///< f^z(d)
  T share;     ///< limit_share() (B3a); of a body that relaxes 1, slip_position() has it
};

/// Anchors, and what a body that relaxes remembers of time.
template <class T>
struct RingMemory : RingAnchors<T> {
  RingCreep<T> creep;      ///< nothing in it where the body does not relax
  T creep_depth_m = T(0);  ///< how much deeper the tool is than ring 1 is pressed
  T ploughing = T(0);      ///< ploughing_share()
  T renewal_m = T(0);      ///< renewal_length_m(); 0: none
};

struct Rings {
  static constexpr const char* kName = "rings";
  static constexpr Part kPart[] = {
      rising_curve("normal"),
      {"lambda", "1", 0, 0, 1, 1, false, false, 0, 100},
      {"friction", "1", 0, 0, 1, 1, false, false, 0, 100},
      {"friction_slope", "1/m", -1, 0, 1, 1, false, false, -1e6, 1e6},
      {"spread", "1/m", -1, 0, 1, 1, false, false, 0, 1e6},
      {"side_square", "N/m^2", -2, 1, 3, 1, false, false, -kMaxNumber, kMaxNumber},
      {"side_cube", "N/m^3", -3, 1, 3, 1, false, false, -kMaxNumber, kMaxNumber},
      {"curvature", "1/m", -1, 0, 6, 1, false, false, -1e6, 1e6, Known::curvature},
      {"sway", "m/N", 1, -1, 6, 1, false, false, -1e6, 1e6, Known::sway},
      {"radius_effect", "1", 0, 0, 1, kRadiusEffects, false, false, -10, 10, Known::tools}};
  static constexpr int kSwayPart = kSway;
  static constexpr int kCurves = 1;
  static constexpr bool kCanRelax = true;
  static constexpr int kAnchorNumbers = 4 * kRings + 1;
  static constexpr int kMemory = kAnchorNumbers + kCreepNumbers;

  /// Count of the numbers of a contact's memory in use.
  static int numbers(const RelaxationView& relaxation) noexcept {
    return kAnchorNumbers + (4 * kRings + 1) * relaxation.branches;
  }

  template <class T>
  using Memory = RingMemory<T>;
  template <class T>
  static Memory<T> load(const double* from, const RelaxationView& relaxation = {}) noexcept {
    Memory<T> out;
    for (int i = 0; i < kRings; ++i) {
      out.x[i] = T(from[i]);
      out.y[i] = T(from[kRings + i]);
      out.z[i] = T(from[2 * kRings + i]);
      out.out[i] = T(from[3 * kRings + i]);
    }
    out.slip_slope = from[4 * kRings];
    if (relaxation.branches == 0) return out;
    const double* at = from + kAnchorNumbers;
    for (int k = 0; k < relaxation.branches; ++k)
      for (auto& component : out.creep.flow[k])
        for (T& flowed : component) flowed = T(*at++);
    for (int k = 0; k < relaxation.branches; ++k) out.creep.renewed[k] = T(*at++);
    find_rests(relaxation, out.creep);
    return out;
  }
  static void save(const Memory<double>& memory, double* to,
                   const RelaxationView& relaxation = {}) noexcept {
    for (int i = 0; i < kRings; ++i) {
      to[i] = memory.x[i];
      to[kRings + i] = memory.y[i];
      to[2 * kRings + i] = memory.z[i];
      to[3 * kRings + i] = memory.out[i];
    }
    to[4 * kRings] = memory.slip_slope;
    if (relaxation.branches == 0) return;
    double* at = to + kAnchorNumbers;
    for (int k = 0; k < relaxation.branches; ++k)
      for (const auto& component : memory.creep.flow[k])
        for (const double flowed : component) *at++ = flowed;
    for (int k = 0; k < relaxation.branches; ++k) *at++ = memory.creep.renewed[k];
  }

  static bool relaxes(const CurveViews& views) noexcept { return views.relaxation.branches > 0; }
  /// Lets the dashpots flow while the tool rests (M47).
  template <class T, class Spot>
  static void relax(const CurveViews& views, const RingKinematics<T, Spot>& kinematics,
                    const Decay& left, Memory<T>& memory) noexcept {
    if (!(value_of(kinematics.at.depth_m) > 0)) return;
    const T at_0 = share_at_0(views.rings, bed(views, kinematics), kinematics.spot);
    relax_rings(views.relaxation, left, views.rings, at_0, kinematics.at, memory, memory.creep);
  }
  /// Position of the tool that the slip of the contact point counts from: less the creep of ring 1.
  template <class T, class Spot>
  static Vec3<T> slip_position(const CurveViews& views, const RingKinematics<T, Spot>& kinematics,
                               const Vec3<T>& x, Memory<T>& memory) noexcept {
    const T d = kinematics.at.depth_m,
            at_0 = share_at_0(views.rings, bed(views, kinematics), kinematics.spot);
    memory.creep_depth_m =
        d - creep_slip_reach(views.relaxation, views.rings, memory.creep, at_0, 0, d,
                             limit_share_at(views, kinematics.spot, d, kinematics.normal_N));
    if (views.relaxation.radius_m > 0 && value_of(d) > 0) {
      memory.renewal_m = renewal_length_m(views.relaxation, d);
      memory.ploughing = ploughing_share(views.relaxation, views.rings, bed(views, kinematics),
                                         memory.creep, at_0, d);
    }
    return x - memory.creep.rest(0) - kinematics.spot.normal * memory.creep_depth_m;
  }

  template <class Spot>
  static bool is_frictionless(const CurveViews&, const Spot& spot) noexcept {
    return !(value_of(spot.control(kLambda, 0)) > 0);
  }
  template <class T, class Spot>
  static RingKinematics<T, Spot> kinematics(const CurveViews& views, const Spot& spot,
                                            const Vec3<T>& x, const Memory<T>& memory) noexcept {
    using std::sqrt;
    const auto& numbers = ring_numbers<T>(spot);
    RingDeflection<T> at = ring_deflection(spot, numbers.curvature, x);
    count_from_anchor(numbers.curvature, memory.at(0), at);
    const T squared = dot(at.q, at.q), normal_N = curve_at(views, spot, kNormal, at.depth_m);
    const bool is_aside = value_of(squared) > kLateralZero_m * kLateralZero_m;
    return {spot,
            {at.depth_m, is_aside ? sqrt(squared) : T(0)},
            at,
            numbers.limit,
            at.q - memory.at(0),
            memory.creep_depth_m,
            normal_N,
            relaxes(views) ? T(1) + memory.ploughing
                           : limit_share_at(views, spot, at.depth_m, normal_N)};
  }

  /// The same kinematics at a spot of the same place.
  template <class T, class Spot, class Other>
  static RingKinematics<T, Other> at_spot(const RingKinematics<T, Spot>& kinematics,
                                          const Other& spot) noexcept {
    return {spot,
            kinematics.d,
            kinematics.at,
            kinematics.limit,
            kinematics.q1,
            kinematics.creep_depth_m,
            kinematics.normal_N,
            kinematics.share};
  }

  /// Returns true if ring 1 is beyond its limit.
  template <class T, class Spot>
  static bool is_slipping(const CurveViews&, const RingKinematics<T, Spot>& kinematics) noexcept {
    const double squared = value_of(dot(kinematics.q1, kinematics.q1));
    if (!(squared > kLateralZero_m * kLateralZero_m)) return false;
    const double lambda = value_of(kinematics.limit.lambda),
                 limit_m = value_of(slip_limit_m(kinematics));
    return lambda * lambda * squared * (1 - 2 * kSlipTolerance) > limit_m * limit_m;
  }
  template <class T>
  static bool has_anchor_offset(const Memory<T>& memory) noexcept {
    const Vec3d rest = values_of(memory.at(0));
    return dot(rest, rest) > kLateralZero_m * kLateralZero_m;
  }
  template <class T>
  static Vec3<T> anchor_offset(const Memory<T>& memory) noexcept {
    return memory.at(0);
  }
  template <class T, class Spot>
  static SlideTarget<T> slide_target(const RingKinematics<T, Spot>& kinematics) noexcept {
    return {kinematics.at.q * (1.0 / kinematics.d.lateral_m), kinematics.d.lateral_m};
  }

  /// The excess that a slip brings to zero (B3): lambda |q| - share mu(d) d. It needs no curve.
  static constexpr bool kIsSmooth = true;
  template <class T>
  struct Excess {
    T creep_depth_m, share;
  };
  template <class T, class Spot>
  static Excess<T> excess_kind(const CurveViews&,
                               const RingKinematics<T, Spot>& kinematics) noexcept {
    return {kinematics.creep_depth_m, kinematics.share};
  }
  template <class T, class Spot>
  static double excess_scale(const CurveViews&, const RingKinematics<T, Spot>& kinematics,
                             const Excess<T>&) noexcept {
    return value_of(kinematics.limit.lambda) * value_of(kinematics.d.lateral_m);
  }
  /// At the kinematics themselves.
  template <class T, class Spot>
  static double current_excess(const CurveViews&, const RingKinematics<T, Spot>& kinematics,
                               const Excess<T>&) noexcept {
    return value_of(kinematics.limit.lambda) * value_of(kinematics.d.lateral_m) -
           value_of(slip_limit_m(kinematics));
  }
  template <class T, class Spot>
  static T excess(const CurveViews&, const Spot& spot, const Vec3<T>& x,
                  const Excess<T>& kind) noexcept {
    return ring_slip_excess(spot, x, kind.creep_depth_m, kind.share);
  }
  template <class Path>
  static decltype(auto) slip_path(const Path& path, const Vec3d& x) noexcept {
    return ring_slip_path(path, x);
  }
  template <class SlipPath, class T>
  static Dual excess_along(const CurveViews&, const SlipPath& path, const Vec3d& x, double s,
                           const Excess<T>& kind) noexcept {
    return ring_excess_along(path, x, s, value_of(kind.creep_depth_m), value_of(kind.share));
  }
  template <class Spot>
  static double lateral_m(const CurveViews&, const Spot& spot, const Vec3d& x) noexcept {
    const Vec3d q = tangential(x - spot.point, spot.normal);
    return std::sqrt(dot(q, q));
  }

  /// The contact point moved by path_m: ring 1's anchor stays, or the contact point is there again.
  template <class T>
  static void transport_anchor(Memory<T>& memory, const Vec3<T>& path_m, const Vec3<T>& normal,
                               bool is_there) noexcept {
    memory.set(0, is_there ? Vec3<T>{T(0), T(0), T(0)} : tangential(memory.at(0) - path_m, normal));
  }
  /// The other anchors, once a tick.
  template <class T>
  static void transport(const CurveViews& views, Memory<T>& memory, const Vec3<T>& path_m,
                        const Vec3<T>& normal) noexcept {
    transport_anchors(memory, path_m, normal);
    if (!relaxes(views)) return;
    project_creep(views.relaxation, normal, memory.creep);
    if (value_of(memory.renewal_m) > 0)
      renew_rings(views.relaxation, memory.renewal_m, path_m, memory.creep);
  }
  /// Ring 1 slips without the contact point.
  template <class T, class Spot>
  static void slip_anchor(const CurveViews& views, RingKinematics<T, Spot>& kinematics,
                          Memory<T>& memory) noexcept {
    using std::sqrt;
    if (!is_slipping(views, kinematics)) return;
    const T limit_m = slip_limit_m(kinematics),
            length = kinematics.limit.lambda * sqrt(dot(kinematics.q1, kinematics.q1));
    kinematics.q1 = kinematics.q1 * (value_of(limit_m) > 0 ? limit_m / length : T(0));
    memory.set(0, kinematics.at.q - kinematics.q1);
  }

  /// The bed under the spot: made once a tick, read by what follows.
  template <class T, class Spot>
  static decltype(auto) bed(const CurveViews& views,
                            const RingKinematics<T, Spot>& kinematics) noexcept {
    return bed_at<T>(views, kinematics.spot);
  }
  template <class T, class Spot>
  static RingResponse<T> stick(const CurveViews& views, const RingBed<T>& bed,
                               const RingKinematics<T, Spot>& kinematics,
                               const Memory<T>& memory) noexcept {
    if (relaxes(views))
      return creep_response<false>(views.relaxation, views.rings, bed, kinematics.at, memory,
                                   memory.creep, share_at_0(views.rings, bed, kinematics.spot),
                                   T(1), T(1));
    return ring_response<false>(views.rings, bed, kinematics.at, memory);
  }
  template <class T, class Spot>
  static RingResponse<T> slip(const CurveViews& views, const RingBed<T>& bed,
                              const RingKinematics<T, Spot>& kinematics,
                              Memory<T>& memory) noexcept {
    RingResponse<T> rings =
        relaxes(views)
            ? creep_response<true>(views.relaxation, views.rings, bed, kinematics.at, memory,
                                   memory.creep, share_at_0(views.rings, bed, kinematics.spot),
                                   limit_share_at(views, kinematics.spot, kinematics.at.depth_m,
                                                  kinematics.normal_N),
                                   T(1) + memory.ploughing)
            : ring_response<true>(views.rings, bed, kinematics.at, memory, kinematics.share);
    if (bed.is_cut)
      rings.dissipated_J *= value_of(ring_share(views.rings, bed, kinematics.at.depth_m).value);
    return rings;
  }
  /// (B1) at anchors that hold; of spots that are not uneven.
  template <class T, class Spot>
  static T stored_J(const CurveViews& views, const RingBed<T>& bed,
                    const RingKinematics<T, Spot>& kinematics, const Memory<T>& memory) noexcept {
    static_assert(!IsUneven<Spot>::value, "answer() has its energy");
    const T d = kinematics.at.depth_m;
    const T normal_J = energy_at(views, kinematics.spot, kNormal, d);
    const SideForce<T> side = side_force_at(views, bed, d, memory.creep.first);
    const T lateral_J =
        ring_share(views.rings, bed, d).value * stick(views, bed, kinematics, memory).stored_J;
    if (!(value_of(d) > 0)) return lateral_J;
    return normal_J + dot(kinematics.q1, side.value_N) + lateral_J;
  }
  /// (B1) and (B2).
  template <class T, class Spot>
  static Answer<T> answer(const CurveViews& views, const RingBed<T>& bed,
                          const RingKinematics<T, Spot>& kinematics,
                          RingResponse<T> rings) noexcept {
    const T d = kinematics.at.depth_m;
    T normal_N = kinematics.normal_N, normal_J = energy_at(views, kinematics.spot, kNormal, d);
    const SideForce<T> side = side_force_at(views, bed, d, rings.flowed_m);
    if constexpr (IsUneven<Spot>::value) {
      const auto added = unevenness(kinematics.spot, bed, d, normal_N);
      rings.force_N = rings.force_N * added.stiffening;
      rings.stored_J = rings.stored_J * added.stiffening;
      rings.along_N = rings.along_N * added.stiffening;
      normal_N = normal_N + added.slope_N_m;
      normal_J = normal_J + added.value_N;
    }
    return ring_answer(views.rings, bed, kinematics.at, rings, side, kinematics.spot.normal,
                       normal_N, normal_J);
  }

 private:
  /// limit_share() of a spot.
  template <class T, class Spot>
  static T limit_share_at(const CurveViews& views, const Spot& spot, const T& depth_m,
                          const T& normal_N) noexcept {
    return limit_share(views.rings, bed_at<T>(views, spot), depth_m, normal_N);
  }
  template <class T>
  static SideForce<T> side_force_at(const CurveViews& views, const RingBed<T>& bed,
                                    const T& depth_m, const T* flowed_m) noexcept {
    return relaxes(views) ? creep_side_force(views.relaxation, bed, depth_m, flowed_m)
                          : side_force(bed, depth_m);
  }
  /// Longest lambda |q_1| before ring 1 slips: share mu(d) d of (B3).
  template <class T, class Spot>
  static T slip_limit_m(const RingKinematics<T, Spot>& kinematics) noexcept {
    if (!(value_of(kinematics.at.depth_m) > 0)) return T(0);
    return kinematics.share *
           kinematics.limit.friction_at(kinematics.at.depth_m + kinematics.creep_depth_m) *
           kinematics.at.depth_m;
  }
};

}  // namespace palpate::runtime
