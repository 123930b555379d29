#pragma once

#include <array>

#include "libfit/runtime/families/rings.hpp"
#include "libfit/runtime/quadric.hpp"

// The ring law on the fitter's quadric, one template with and without derivatives. Lengths and
// forces in the caller's units.

namespace palpate::fit {

/// What a point's record is replayed with. N: scalar of the numbers.
template <class N>
struct RingPoint {
  const N* normal;  ///< control values of f^z
  std::array<N, runtime::kRingNumbers> number;
};

template <class S, class N, bool kIsPlain>
struct RingSpot {
  runtime::Vec3<S> point, normal, shadow;
  const RingPoint<N>* of;
  S control(int, int j) const noexcept { return convert(of->normal[j]); }
  S number(int k) const noexcept { return convert(of->number[static_cast<std::size_t>(k)]); }

 private:
  static S convert(const N& n) noexcept {
    if constexpr (kIsPlain)
      return S(runtime::value_of(n));
    else
      return S(n);
  }
};

/// A way over the quadric whose shadow on the tangent plane is straight: QuadricPath of the rings.
template <class P, class N>
struct RingPath {
  const runtime::Quadric* quadric;
  runtime::Vec3<P> start, direction;
  const RingPoint<N>* of;

  double end() const noexcept { return 1e300; }
  bool is_blocked() const noexcept { return false; }
  template <class S>
  RingSpot<S, N, !std::is_same_v<P, N>> at(const S& s) const noexcept {
    const runtime::Vec3<S> p{start.x + direction.x * s, start.y + direction.y * s,
                             start.z + direction.z * s};
    const runtime::Vec3<S> u0 = runtime::widened<S>(quadric->u0),
                           bend = gradient_times(*quadric, p);
    return {p - u0 * (0.5 * dot(p, bend)), normalized(u0 + bend), p, of};
  }
  RingPath<double, N> plain() const noexcept {
    return {quadric, runtime::values_of(start), runtime::values_of(direction), of};
  }
};

template <class T>
struct RingSurface {
  const runtime::Quadric* quadric;
  const RingPoint<T>* of;
  runtime::Vec3<T> p;  ///< shadow of the contact point on the tangent plane

  RingSpot<T, T, false> standing() const noexcept {
    return RingPath<T, T>{quadric, p, {T(0), T(0), T(0)}, of}.at(T(0));
  }
  RingPath<T, T> aim(const RingSpot<T, T, false>&,
                     const runtime::Vec3<T>& direction) const noexcept {
    const runtime::Vec3<T> u0 = runtime::widened<T>(quadric->u0);
    return {quadric, p, direction - u0 * dot(direction, u0), of};
  }
  runtime::Move move(const RingPath<T, T>& path, const T& s, const runtime::Vec3<T>&) noexcept {
    p = path.start + path.direction * s;
    return runtime::Move::whole;
  }
};

/// How far the body's unevenness may scale the rings along a drag.
inline constexpr double kLeastRingScale = 0.2;

/// Force of a stance on the quadric. About the test point the body is uneven by g: its stored
/// energy is Z(d) + X.g(d) with X where the tool is, and rings are stiffer by what f^z is.
template <class T>
runtime::Vec3<T> uneven_ring_force(const runtime::RingTable<runtime::kRings>& table,
                                   const runtime::CurveViews& views,
                                   const RingSpot<T, T, false>& spot, const runtime::Vec3<T>& x,
                                   const runtime::RingAnchors<T, runtime::kRings>& anchors) {
  const auto at = ring_stance(spot, x);
  auto bed = runtime::ring_bed<T>(table, spot);
  const auto side = side_force(bed, at.depth_m);
  const T normal = curve_at(views, spot, runtime::kNormal, at.depth_m);
  const T along = dot(spot.shadow, side.slope_N_m);
  if (runtime::value_of(normal) > 0) {
    T scale = 1.0 + (along + dot(at.q, side.slope_N_m)) / normal;
    if (!(runtime::value_of(scale) > kLeastRingScale)) scale = T(kLeastRingScale);
    for (int i = 0; i < runtime::kRings; ++i) {
      bed.stiffness_N_m[i] = bed.stiffness_N_m[i] * scale;
      bed.excess_N_m[i] = bed.excess_N_m[i] * scale;
    }
  }
  return ring_force(table, bed, at, anchors, spot.normal, normal + along);
}

/// runtime::replay_drag with the ring law: forces of the tool on the body, a row per deflection.
/// Returns how many rows slid.
template <class T>
int replay_rings(const runtime::RingTable<runtime::kRings>& table, const runtime::CurveViews& views,
                 const RingPoint<T>& point, const runtime::Quadric& quadric,
                 const double* deflection, int rows, runtime::Vec3<T>* force) {
  const runtime::Vec3<T> nothing{T(0), T(0), T(0)};
  RingSurface<T> surface{&quadric, &point, nothing};
  auto anchors = runtime::no_anchors<T, runtime::kRings>();
  bool in_contact = true;
  int slid = 0;
  runtime::Vec3d before{0, 0, 0};
  for (int row = 0; row < rows; ++row) {
    const runtime::Vec3d tip = runtime::make_vec3<double>(deflection + 3 * row);
    force[row] = nothing;
    if (!in_contact && depth_below(quadric, before) <= 0 && depth_below(quadric, tip) > 0) {
      surface.p = runtime::widened<T>(runtime::entry_shadow(quadric, before, tip));
      anchors = runtime::no_anchors<T, runtime::kRings>();
      in_contact = true;
    }
    before = tip;
    if (!in_contact) continue;
    const runtime::Vec3<T> x = runtime::widened<T>(tip);
    slid += slide_rings(table, x, surface, anchors) != runtime::SlideEnd::stick;
    const auto spot = surface.standing();
    force[row] = uneven_ring_force(table, views, spot, x, anchors);
    in_contact = runtime::value_of(ring_stance(spot, x).depth_m) > 0 || row == 0;
  }
  return slid;
}

}  // namespace palpate::fit
