#pragma once

// How many floating-point operations a press or stick tick cannot do without: the engine's own law
// with a scalar that counts, on curves that are blended already.

#include <array>

#include "libfit/runtime/engine.hpp"

namespace palpate::tools {

/// A double that counts what is done with it.
struct Counted {
  double a = 0;
  static inline long operations = 0;
  Counted() noexcept = default;
  explicit Counted(double value) noexcept : a(value) {}
  static Counted of(double value) noexcept {
    ++operations;
    return Counted(value);
  }
};
#define PALPATE_COUNTED(op)                                                 \
  inline Counted operator op(const Counted& x, const Counted& y) noexcept { \
    return Counted::of(x.a op y.a);                                         \
  }                                                                         \
  inline Counted operator op(const Counted& x, double y) noexcept {         \
    return Counted::of(x.a op y);                                           \
  }                                                                         \
  inline Counted operator op(double x, const Counted& y) noexcept { return Counted::of(x op y.a); }
PALPATE_COUNTED(+)
PALPATE_COUNTED(-)
PALPATE_COUNTED(*)
PALPATE_COUNTED(/)
#undef PALPATE_COUNTED
inline Counted sqrt(const Counted& x) noexcept { return Counted::of(std::sqrt(x.a)); }

/// The contact's spot, its controls at hand.
struct CountedSpot {
  runtime::Vec3<Counted> point, normal;
  const runtime::MeshSpot<double>* spot;
  Counted control(int curve, int j) const noexcept { return Counted(spot->control(curve, j)); }
};
/// So are its curves around the depth.
inline runtime::CurvePiece<Counted> piece_at(const runtime::CurveViews& views,
                                             const CountedSpot& spot, int curve, double x,
                                             bool with_area) noexcept {
  const auto plain = piece_at(views, *spot.spot, curve, x, with_area);
  runtime::CurvePiece<Counted> out;
  out.order = plain.order;
  out.knot = plain.knot;
  for (int k = 0; k < plain.order; ++k) out.c[k] = Counted(plain.c[k]);
  out.area_J = Counted(plain.area_J);
  return out;
}

/// Additions, multiplications, divisions and roots of a tick that sticks at x [m].
inline long flops_of_a_tick(const runtime::AssetView& asset, const runtime::Contact& contact,
                            const double tip_m[3]) noexcept {
  using namespace runtime;
  Corners corners;
  const MeshSurface<double, false> surface(corners, asset, contact.triangle, contact.weight,
                                           contact.arm);
  const MeshSpot<double> standing = surface.standing();
  const CountedSpot spot{widened<Counted>(standing.point), widened<Counted>(standing.normal),
                         &standing};
  const runtime::Vec3<Counted> x = make_vec3<Counted>(tip_m) - make_vec3<Counted>(asset.origin_m);
  with_family(asset.curves, [&](auto f) noexcept {
    auto memory = f.template load<Counted>(contact.memory);
    const auto& under = f.under(asset.curves, f.kinematics(asset.curves, spot, x, memory));
    Counted::operations = 0;  // what is under the spot is at hand
    const auto kinematics = f.kinematics(asset.curves, spot, x, memory);
    f.is_slipping(asset.curves, kinematics);
    f.answer(asset.curves, under, kinematics, f.slip(asset.curves, under, kinematics, memory));
  });
  return Counted::operations;
}

/// As many operations with nothing to wait for: multiply and add in eight chains.
inline double do_flops(long flops) noexcept {
  std::array<double, 8> chain{1, 2, 3, 4, 5, 6, 7, 8};
  for (long i = 0; i < flops; i += 16)
    for (double& each : chain) each = each * 0.999 + 0.001;
  double sum = 0;
  for (double each : chain) sum += each;
  return sum;
}

}  // namespace palpate::tools
