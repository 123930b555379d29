// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// The separable family: W = Z(dz) + R(dr) (M3). The depth does not change the lateral stiffness,
// nor the lateral deflection the normal one.

#include "slide.hpp"

namespace palpate::runtime {

/// Offset of the body's one anchor from the contact point [m]; zero unless the contact
/// point could not follow.
template <class T>
struct Rest {
  Vec3<T> at;
  double slip_slope = 0;  ///< see slip_along() [N/m], or [1] where it slides as if frictionless
};

/// A tool's deflection in the frame of its contact point.
template <class T>
struct Deflection {
  T normal_m;       ///< dz, > 0 in contact
  T lateral_m;      ///< dr >= 0; exactly 0 below kLateralZero_m
  Vec3<T> lateral;  ///< u^r; zero vector where dr is 0
};

/// A contact point with the deflection of a tool at x: made once, read by slip test and force.
template <class T, class Spot>
struct ContactKinematics {
  Spot spot;
  Deflection<T> d;
  T lateral_N;  ///< f^r(dr)
};

/// A spot without lateral stiffness cannot reach any limit: it slides as if frictionless. A spot
/// that has this at hand brings an overload.
template <class Spot>
bool lacks_lateral(const CurveViews& views, const Spot& spot) noexcept {
  return !(value_of(spot.control(kLateral, views.view[kLateral].size() - 1)) > 0);
}

struct Separable {
  static constexpr const char* kName = "separable";
  static constexpr Part kPart[] = {rising_curve("normal"), rising_curve("lateral"),
                                   rising_curve("limit", kMaxNumber)};  // friction without bounds
  static constexpr int kCurves = 3;  ///< parts that are rising curves, from the first on
  static constexpr int kMemory = 4;
  static constexpr int kSwayPart = -1;
  static constexpr bool kCanRelax = false;
  static constexpr bool relaxes(const CurveViews&) noexcept { return false; }

  static int numbers(const RelaxationView&) noexcept { return kMemory; }

  template <class T>
  using Memory = Rest<T>;
  template <class T>
  static Memory<T> load(const double* from, const RelaxationView& = {}) noexcept {
    return {make_vec3<T>(from), from[3]};
  }
  static void save(const Memory<double>& memory, double* to, const RelaxationView& = {}) noexcept {
    to[0] = memory.at.x;
    to[1] = memory.at.y;
    to[2] = memory.at.z;
    to[3] = memory.slip_slope;
  }

  template <class Spot>
  static bool is_frictionless(const CurveViews& views, const Spot& spot) noexcept {
    return lacks_lateral(views, spot);
  }
  /// Deflection of a tool at x (M2).
  template <class T, class Spot>
  static Deflection<T> deflection(const Spot& spot, const Vec3<T>& x,
                                  const Vec3<T>& rest) noexcept {
    using std::sqrt;
    const Vec3<T> delta = x - spot.point;
    Deflection<T> out{dot(delta, spot.normal), T(0), {T(0), T(0), T(0)}};
    const Vec3<T> lateral = delta - spot.normal * out.normal_m - rest;
    const T squared = dot(lateral, lateral);
    if (!(value_of(squared) > kLateralZero_m * kLateralZero_m)) return out;
    out.lateral_m = sqrt(squared);
    out.lateral = lateral * (1.0 / out.lateral_m);
    return out;
  }
  template <class T, class Spot>
  static ContactKinematics<T, Spot> kinematics(const CurveViews& views, const Spot& spot,
                                               const Vec3<T>& x, const Memory<T>& memory) noexcept {
    const Deflection<T> d = deflection(spot, x, memory.at);
    return {spot, d, curve_at(views, spot, kLateral, d.lateral_m)};
  }

  /// The same kinematics at a spot of the same place.
  template <class T, class Spot, class Other>
  static ContactKinematics<T, Other> at_spot(const ContactKinematics<T, Spot>& kinematics,
                                             const Other& spot) noexcept {
    return {spot, kinematics.d, kinematics.lateral_N};
  }

  /// Returns true if the contact point cannot hold: the lateral force is above L(dz).
  template <class T, class Spot>
  static bool is_slipping(const CurveViews& views,
                          const ContactKinematics<T, Spot>& kinematics) noexcept {
    if (!(value_of(kinematics.d.lateral_m) > 0)) return false;
    if (is_frictionless(views, kinematics.spot)) return true;
    const double limit_N =
        value_of(curve_at(views, kinematics.spot, kLimit, kinematics.d.normal_m));
    return value_of(kinematics.lateral_N) * (1 - kSlipTolerance) > limit_N || !(limit_N > 0);
  }
  template <class T>
  static bool has_anchor_offset(const Memory<T>& memory) noexcept {
    const Vec3d rest = values_of(memory.at);
    return dot(rest, rest) > kLateralZero_m * kLateralZero_m;
  }
  template <class T>
  static Vec3<T> anchor_offset(const Memory<T>& memory) noexcept {
    return memory.at;
  }
  template <class T, class Spot>
  static SlideTarget<T> slide_target(const ContactKinematics<T, Spot>& kinematics) noexcept {
    return {kinematics.d.lateral, kinematics.d.lateral_m};
  }

  /// The excess that a slip brings to zero (M8): the lateral force - L(dz) [N]; without lateral
  /// stiffness, dr itself (as N).
  static constexpr bool kIsSmooth = false;  ///< its curves have knots
  enum class Excess { over_the_limit, all };
  template <class T, class Spot>
  static Excess excess_kind(const CurveViews& views,
                            const ContactKinematics<T, Spot>& kinematics) noexcept {
    return is_frictionless(views, kinematics.spot) ? Excess::all : Excess::over_the_limit;
  }
  template <class T, class Spot>
  static double excess_scale(const CurveViews&, const ContactKinematics<T, Spot>& kinematics,
                             Excess kind) noexcept {
    return value_of(kind == Excess::all ? kinematics.d.lateral_m : kinematics.lateral_N);
  }
  /// At the kinematics themselves.
  template <class T, class Spot>
  static double current_excess(const CurveViews& views,
                               const ContactKinematics<T, Spot>& kinematics, Excess kind) noexcept {
    if (kind == Excess::all) return value_of(kinematics.d.lateral_m);
    return value_of(kinematics.lateral_N) -
           value_of(curve_at(views, kinematics.spot, kLimit, kinematics.d.normal_m));
  }
  template <class T, class Spot>
  static T excess(const CurveViews& views, const Spot& spot, const Vec3<T>& x,
                  Excess kind) noexcept {
    const Deflection<T> d = deflection(spot, x, {T(0), T(0), T(0)});
    if (kind == Excess::all) return d.lateral_m;
    return curve_at(views, spot, kLateral, d.lateral_m) - curve_at(views, spot, kLimit, d.normal_m);
  }
  template <class Path>
  static const Path& slip_path(const Path& path, const Vec3d&) noexcept {
    return path;
  }
  template <class Path>
  static Dual excess_along(const CurveViews& views, const Path& path, const Vec3d& x, double s,
                           Excess kind) noexcept {
    return excess(views, path.at(Dual(s, 1)), widened<Dual>(x), kind);
  }
  template <class Spot>
  static double lateral_m(const CurveViews&, const Spot& spot, const Vec3d& x) noexcept {
    return deflection(spot, x, Vec3d{0, 0, 0}).lateral_m;
  }

  template <class T>
  static void transport(const CurveViews&, Memory<T>&, const Vec3<T>&, const Vec3<T>&) noexcept {}
  /// The contact point moved by path_m: the anchor stays, or the contact point is there again.
  template <class T>
  static void transport_anchor(Memory<T>& memory, const Vec3<T>& path_m, const Vec3<T>& normal,
                               bool is_there) noexcept {
    memory.at = is_there ? Vec3<T>{T(0), T(0), T(0)} : tangential(memory.at - path_m, normal);
  }
  /// The anchor slips without the contact point until f^r(dr) = L(dz).
  template <class T, class Spot>
  static void slip_anchor(const CurveViews& views, ContactKinematics<T, Spot>& kinematics,
                          Memory<T>& memory) noexcept {
    if (!is_slipping(views, kinematics)) return;
    const T limit_N = curve_at(views, kinematics.spot, kLimit, kinematics.d.normal_m);
    const T length_m = is_frictionless(views, kinematics.spot) || !(value_of(limit_N) > 0)
                           ? T(0)
                           : length_at(views, kinematics, limit_N);
    memory.at = memory.at + kinematics.d.lateral * (kinematics.d.lateral_m - length_m);
    kinematics.d.lateral_m = length_m;
    if (!(value_of(length_m) > 0)) kinematics.d.lateral = {T(0), T(0), T(0)};
    kinematics.lateral_N = curve_at(views, kinematics.spot, kLateral, kinematics.d.lateral_m);
  }

  /// The law reads nothing of a spot beside its curves.
  struct NoBed {};
  template <class T, class Spot>
  static NoBed bed(const CurveViews&, const ContactKinematics<T, Spot>&) noexcept {
    return {};
  }
  /// Nothing slips while the contact point holds.
  struct NoSlip {
    double dissipated_J;
  };
  template <class T, class Spot>
  static NoSlip stick(const CurveViews&, const NoBed&, const ContactKinematics<T, Spot>&,
                      const Memory<T>&) noexcept {
    return {0};
  }
  template <class T, class Spot>
  static NoSlip slip(const CurveViews&, const NoBed&, const ContactKinematics<T, Spot>&,
                     Memory<T>&) noexcept {
    return {0};
  }
  template <class T, class Spot>
  static T stored_J(const CurveViews& views, const NoBed& bed,
                    const ContactKinematics<T, Spot>& kinematics, const Memory<T>&) noexcept {
    return answer(views, bed, kinematics, NoSlip{0}).stored_J;
  }
  /// Z(dz) + R(dr) [J], exact polynomials, and its gradient f^z u + f^r u^r (M3); zero where
  /// dz <= 0.
  template <class T, class Spot>
  static Answer<T> answer(const CurveViews& views, const NoBed&,
                          const ContactKinematics<T, Spot>& kinematics, const NoSlip&) noexcept {
    const T lateral_J = energy_at(views, kinematics.spot, kLateral, kinematics.d.lateral_m);
    const double depth = value_of(kinematics.d.normal_m);
    if (!(depth > 0)) return {{T(0), T(0), T(0)}, lateral_J};
    const auto& piece = piece_at(views, kinematics.spot, kNormal, depth, true);
    const T normal_N = piece.force(kinematics.d.normal_m);
    return {kinematics.spot.normal * normal_N + kinematics.d.lateral * kinematics.lateral_N,
            piece.energy(kinematics.d.normal_m) + lateral_J};
  }

 private:
  /// dr at which f^r is limit_N > 0; f^r is above it at kinematics.d.lateral_m.
  template <class T, class Spot>
  static T length_at(const CurveViews& views, const ContactKinematics<T, Spot>& kinematics,
                     const T& limit_N) noexcept {
    double lo = 0, hi = value_of(kinematics.d.lateral_m), at = hi;
    for (int i = 0; i < kMaxRootSteps; ++i) {
      const double over =
          value_of(curve_at(views, kinematics.spot, kLateral, T(at))) - value_of(limit_N);
      (over > 0 ? hi : lo) = at;
      const double slope = slope_at(views, kinematics.spot, at), newton = at - over / slope;
      if (std::fabs(over) <= kRootTolerance * value_of(limit_N)) break;
      at = newton > lo && newton < hi ? newton : 0.5 * (lo + hi);
    }
    const T out = T(at);
    const double slope = slope_at(views, kinematics.spot, at);
    if (!(slope > 0)) return out;
    return out - (curve_at(views, kinematics.spot, kLateral, out) - limit_N) / slope;
  }
  template <class Spot>
  static double slope_at(const CurveViews& views, const Spot& spot, double at) noexcept {
    const auto piece = piece_at(views, spot, kLateral, at, false);
    double slope = 0;
    for (int k = piece.order - 1; k > 0; --k)
      slope = slope * (at - piece.knot) + k * value_of(piece.c[k]);
    return slope;
  }
};

}  // namespace palpate::runtime
