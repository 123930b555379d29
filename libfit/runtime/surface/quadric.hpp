// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// The fitter's view of the body around a test point: a quadric surface on which the contact point
// of slide.hpp moves, with derivatives when the scalar carries them. All positions are relative to
// the test point.

#include <type_traits>

#include "../law/families.hpp"

namespace palpate::runtime {

/// The surface c(p) = p - (p . G p)/2 u0 over the tangent plane (p . u0 = 0), to second order
/// (M11). u0: inward unit normal at the test point. gradient: row-major 3x3 G = du/dc [1/m],
/// symmetric with G u0 = 0 (fit::offset_gradient); -1/R on a sphere's tangents, zeros
/// where flat. The inward normal is normalize(u0 + G p), exactly that of the quadric.
struct Quadric {
  Vec3d u0;
  double gradient[9];
};

template <class T>
Vec3<T> gradient_times(const Quadric& quadric, const Vec3<T>& p) noexcept {
  const double* g = quadric.gradient;
  return {p.x * g[0] + p.y * g[1] + p.z * g[2], p.x * g[3] + p.y * g[4] + p.z * g[5],
          p.x * g[6] + p.y * g[7] + p.z * g[8]};
}

/// The numbers of each part at the test point, control value by control value; null where the
/// family has none.
template <class C>
struct ControlPointers {
  const C* part[kMaxParts];
};

/// Signed depth [m] of a point under the quadric, along u0: > 0 inside the body.
inline double depth_below(const Quadric& quadric, const Vec3d& x) noexcept {
  const double height = dot(x, quadric.u0);
  const Vec3d p = x - quadric.u0 * height;
  return height + 0.5 * dot(p, gradient_times(quadric, p));
}

/// A spot of the quadric; curves do not vary over it. C: the controls' scalar. A plain spot takes
/// only their values: derivatives with respect to controls and along the path must not mix.
template <class S, class C, bool kIsPlain>
struct QuadricSpot {
  Vec3<S> point, normal, shadow;  ///< shadow: on the tangent plane, from the test point
  ControlPointers<C> controls;
  S control(int part, int j) const noexcept {
    return convert(controls.part[part][j], std::integral_constant<bool, kIsPlain>());
  }

 private:
  static S convert(const C& c, std::true_type) noexcept { return S(value_of(c)); }
  static S convert(const C& c, std::false_type) noexcept { return S(c); }
};

template <class S, class C, bool kIsPlain>
struct IsUneven<QuadricSpot<S, C, kIsPlain>> : std::true_type {};

template <class T>
struct Unevenness {
  T value_N, slope_N_m;  ///< p.g [J] and p.g' [kRings]
  T stiffening;          ///< of the rings
};
template <class S, class C, bool kIsPlain>
Unevenness<S> unevenness(const QuadricSpot<S, C, kIsPlain>& spot, const RingBed<S>& bed,
                         const S& depth_m, const S& normal_N) noexcept {
  const SideForce<S> side = side_force(bed, depth_m);
  Unevenness<S> out{dot(spot.shadow, side.value_N), dot(spot.shadow, side.slope_N_m), S(1)};
  if (!(value_of(normal_N) > 0)) return out;
  out.stiffening = S(1) + out.slope_N_m / normal_N;
  if (!(value_of(out.stiffening) > kMinStiffening)) out.stiffening = S(kMinStiffening);
  return out;
}

/// A path over the quadric whose shadow on the tangent plane is straight. P: scalar of the place,
/// either C or, in a plain path, double.
template <class P, class C>
struct QuadricPath {
  template <class S>
  using Spot = QuadricSpot<S, C, !std::is_same<P, C>::value>;

  const Quadric* quadric;
  Vec3<P> start, direction;  ///< p and dp/ds in the tangent plane
  ControlPointers<C> controls;

  double end() const noexcept { return 1e300; }
  bool is_blocked() const noexcept { return false; }
  bool is_straight() const noexcept { return true; }

  template <class S>
  Spot<S> at(const S& s) const noexcept {
    const Vec3<S> p{start.x + direction.x * s, start.y + direction.y * s,
                    start.z + direction.z * s};
    const Vec3<S> u0 = widened<S>(quadric->u0), turned = gradient_times(*quadric, p);
    return {p - u0 * (0.5 * dot(p, turned)), normalized(u0 + turned), p, controls};
  }
  QuadricPath<double, C> plain() const noexcept {
    return {quadric, values_of(start), values_of(direction), controls};
  }
};

/// The contact point on a quadric, for slide().
template <class T>
struct QuadricSurface {
  const Quadric* quadric;
  ControlPointers<T> controls;
  Vec3<T> p;  ///< shadow of the contact point on the tangent plane [m]

  QuadricSpot<T, T, false> standing() const noexcept {
    return path_along({T(0), T(0), T(0)}).at(T(0));
  }
  /// The direction is tangent to the quadric (its normal is the field's), so only its shadow
  /// counts.
  QuadricPath<T, T> aim(const QuadricSpot<T, T, false>&, const Vec3<T>& direction) const noexcept {
    return path_along(direction);
  }
  QuadricPath<T, T> path_along(const Vec3<T>& direction) const noexcept {
    const Vec3<T> u0 = widened<T>(quadric->u0);
    return {quadric, p, direction - u0 * dot(direction, u0), controls};
  }
  bool is_spent() const noexcept { return false; }
  void move(const QuadricPath<T, T>& path, const T& s) noexcept {
    p = path.start + path.direction * s;
  }
};

/// Entry of the straight path from `outside` to `inside` into the body, as a shadow on the tangent
/// plane. 50 bisections of depth_below.
inline Vec3d entry_shadow(const Quadric& quadric, Vec3d outside, Vec3d inside) noexcept {
  for (int i = 0; i < 50; ++i) {
    const Vec3d middle = (outside + inside) * 0.5;
    if (depth_below(quadric, middle) > 0)
      inside = middle;
    else
      outside = middle;
  }
  return inside - quadric.u0 * dot(inside, quadric.u0);
}

}  // namespace palpate::runtime
