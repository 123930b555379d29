// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// The stick/slip law (docs/method.md, sections 1 to 4), one template for the engine (scalar double,
// the surface is a mesh) and the fitter (scalar double or ceres::Jet, the surface is the quadric of
// quadric.hpp, which also has replay_drag). Forces here are those of the tool ON the body.
//
// A Path is a way the contact point can slide, with parameter s >= 0 [m] measured laterally:
//   path.at(s)   -> Spot: .point [m], .normal (inward unit), .control(curve, j) [N], .lean(j) [m]
//   path.end()   -> where the path leaves its triangle, may be infinite
//   path.plain() -> the same path with plain numbers; path.is_blocked(): no way to go
// A Surface holds the contact point:
//   surface.standing()      -> Spot at the contact point
//   surface.aim(spot, direction) -> Path from there (the standing spot) along the lateral unit
//                              vector, projected obliquely along the spot's normal so that the
//                              lateral deflection shrinks by s
//   surface.move(path, s, x) -> Move: the contact point goes to path(s)

#include "scalar.hpp"
#include "spline.hpp"

namespace palpate {
namespace runtime {

constexpr int kNormal = 0, kLateral = 1, kLimit = 2;  ///< f^z(dz), f^r(dr), L(dz)
constexpr int kCurves = 3;
constexpr int kLean = 3;  ///< where the lean l(dz) stands after them

constexpr int kMaxRootSteps = 12;  ///< Newton needs 3 or 4; 12 bisections leave 1/4096 of a slip
constexpr int kMaxSegments =
    16;  ///< straight pieces of one slip per tick; 14 seen on 800 k triangles
constexpr double kLateralZero_m = 1e-12;  ///< below a picometre the lateral direction is noise
constexpr double kSlipTolerance = 1e-10;  ///< of f^r: keeps a solved slip from slipping again
constexpr double kRootTolerance = 1e-13;  ///< of f^r: where Newton stops
constexpr double kInside =
    1 - 1e-9;  ///< where a path's end is judged: at a skirt's rim all is zero

/// The bases of the three curves and of the lean, shared by the body.
struct CurveViews {
  SplineView view[kCurves];
  SplineView lean;  ///< of l(dz); no pieces: the body does not lean
};

/// A tool's deflection in the frame of its contact point.
template <class T>
struct Deflection {
  T normal_m;       ///< dz, > 0 in contact
  T lateral_m;      ///< dr >= 0, from where the body leans to; exactly 0 below kLateralZero_m
  Vec3<T> lateral;  ///< u^r; zero vector where dr is 0
  T lean_rate;      ///< u^r . dl/d(dz) [1]: what the lateral force takes from the normal one
};

/// l and dl/d(dz) of a spot.
template <class T>
struct Lean {
  Vec3<T> value_m, slope;
};
template <class T, class Spot>
Lean<T> lean_at(const SplineView& view, const Spot& spot, const T& depth_m) noexcept {
  const SplineWeights<T> w = spline_weights(view, find_piece(view, value_of(depth_m)), depth_m);
  const Vec3<T> nothing{T(0), T(0), T(0)};
  Lean<T> out{nothing, nothing};
  for (int k = 0; k <= view.degree; ++k) {
    const Vec3<T> control = spot.lean(w.first + k);
    out.value_m = out.value_m + control * w.value[k];
    out.slope = out.slope + control * w.slope[k];
  }
  return out;
}

/// The deflection of a tool at x [m] whose contact point is the spot.
template <class T, class Spot>
Deflection<T> deflection(const CurveViews& views, const Spot& spot, const Vec3<T>& x) noexcept {
  using std::sqrt;
  const Vec3<T> delta = x - spot.point;
  Deflection<T> out{dot(delta, spot.normal), T(0), {T(0), T(0), T(0)}, T(0)};
  Vec3<T> lateral = delta - spot.normal * out.normal_m;
  const bool leans = views.lean.pieces > 0 && value_of(out.normal_m) > 0;
  Vec3<T> slope{T(0), T(0), T(0)};
  if (leans) {
    const Lean<T> lean = lean_at(views.lean, spot, out.normal_m);
    lateral = lateral - (lean.value_m - spot.normal * dot(lean.value_m, spot.normal));
    slope = lean.slope;
  }
  const T squared = dot(lateral, lateral);
  if (!(value_of(squared) > kLateralZero_m * kLateralZero_m)) return out;
  out.lateral_m = sqrt(squared);
  out.lateral = lateral * (1.0 / out.lateral_m);
  if (leans) out.lean_rate = dot(slope, out.lateral);
  return out;
}

/// The control values alive on one interval.
template <int kOrder, class T>
struct LiveControls {
  T b[kOrder];
};
/// Those of a spot from `first` on. A spot that has them at hand brings an overload.
template <int kOrder, class Spot>
auto live_controls(const Spot& spot, int curve, int first) noexcept
    -> LiveControls<kOrder, decltype(spot.control(curve, first))> {
  LiveControls<kOrder, decltype(spot.control(curve, first))> out;
  for (int k = 0; k < kOrder; ++k) out.b[k] = spot.control(curve, first + k);
  return out;
}

/// Interval of x in a curve. A spot that remembers the last one brings an overload.
template <class Spot>
int piece_at(const SplineView& view, const Spot&, int /*curve*/, double x) noexcept {
  return find_piece(view, x);
}

/// Sum of a spot's control values times the basis at x, on a basis of a known order: the compiler
/// unrolls it, which is half of a tick's time.
template <int kOrder, class T, class Spot>
T curve_of_order(const SplineView& view, const Spot& spot, int curve, const T& x) noexcept {
  const int piece = piece_at(view, spot, curve, value_of(x)), first = first_control(view, piece);
  const auto live = live_controls<kOrder>(spot, curve, first);
  const T t = x - view.knots[piece];
  const double* c = view.weights + piece * kOrder * kOrder;
  T sum = live.b[0] * basis_value(c, kOrder, t);
  for (int k = 1; k < kOrder; ++k) sum = sum + live.b[k] * basis_value(c + k * kOrder, kOrder, t);
  return sum;
}

/// Force of one curve of a spot at x [m] -> [N]; exactly 0 for x <= 0.
template <class T, class Spot>
T curve_at(const CurveViews& views, const Spot& spot, int curve, const T& x) noexcept {
  if (!(value_of(x) > 0)) return T(0);
  const SplineView& view = views.view[curve];
  switch (view.degree) {
    case 1:
      return curve_of_order<2>(view, spot, curve, x);
    case 2:
      return curve_of_order<3>(view, spot, curve, x);
    case 3:
      return curve_of_order<4>(view, spot, curve, x);
    default:
      return curve_of_order<5>(view, spot, curve, x);
  }
}

/// Area under a curve of a spot up to the interval `piece` that the control values below `first`
/// bring. A spot that has it at hand brings an overload.
template <class Spot>
auto area_before(const SplineView& view, const Spot& spot, int curve, int piece, int first) noexcept
    -> decltype(spot.control(curve, first)) {
  using S = decltype(spot.control(curve, first));
  const double* whole = view.integrals + piece * view.size();
  S sum[4] = {S(0), S(0), S(0), S(0)};  // four at a time: one chain of sums would wait for each
  int j = 0;
  for (; j + 4 <= first; j += 4) {
    const auto live = live_controls<4>(spot, curve, j);
    for (int i = 0; i < 4; ++i) sum[i] = sum[i] + live.b[i] * whole[j + i];
  }
  for (int i = 0; j < first; ++j, ++i) sum[i] = sum[i] + spot.control(curve, j) * whole[j];
  return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

template <int kOrder, class T, class Spot>
T energy_of_order(const SplineView& view, const Spot& spot, int curve, const T& x) noexcept {
  const int piece = piece_at(view, spot, curve, value_of(x)), first = first_control(view, piece);
  const auto live = live_controls<kOrder>(spot, curve, first);
  const T t = x - view.knots[piece];
  const double* whole = view.integrals + piece * view.size();
  const double* c = view.weights + piece * kOrder * kOrder;
  T last = T(0);
  for (int k = 0; k < kOrder; ++k)
    last = last + live.b[k] * (basis_integral(c + k * kOrder, kOrder, t) * t + whole[first + k]);
  return area_before(view, spot, curve, piece, first) + last;
}

/// Area under one curve of a spot from 0 to x [J], exact; 0 for x <= 0.
template <class T, class Spot>
T energy_at(const CurveViews& views, const Spot& spot, int curve, const T& x) noexcept {
  if (!(value_of(x) > 0)) return T(0);
  const SplineView& view = views.view[curve];
  switch (view.degree) {
    case 1:
      return energy_of_order<2>(view, spot, curve, x);
    case 2:
      return energy_of_order<3>(view, spot, curve, x);
    case 3:
      return energy_of_order<4>(view, spot, curve, x);
    default:
      return energy_of_order<5>(view, spot, curve, x);
  }
}

/// Gradient of Z(dz) + R(dr), force of the tool on the body [N] (docs/method.md, section 2):
/// (f^z - f^r u^r . dl/d(dz)) u + f^r u^r; zero where dz <= 0.
/// lateral_N: f^r(dr), where the caller knows it already.
template <class T, class Spot>
Vec3<T> response(const CurveViews& views, const Spot& spot, const Deflection<T>& d,
                 const T& lateral_N) noexcept {
  if (!(value_of(d.normal_m) > 0)) return {T(0), T(0), T(0)};
  const T normal_N = curve_at(views, spot, kNormal, d.normal_m) - lateral_N * d.lean_rate;
  return spot.normal * normal_N + d.lateral * lateral_N;
}
template <class T, class Spot>
Vec3<T> response(const CurveViews& views, const Spot& spot, const Deflection<T>& d) noexcept {
  return response(views, spot, d, curve_at(views, spot, kLateral, d.lateral_m));
}

/// A spot without lateral stiffness cannot reach any limit: it slides as if frictionless.
template <class Spot>
bool is_frictionless(const CurveViews& views, const Spot& spot) noexcept {
  return !(value_of(spot.control(kLateral, views.view[kLateral].size() - 1)) > 0);
}

/// What a slip brings to zero: f^r(dr) - L(dz) [N]; without lateral stiffness, dr itself (as N).
template <class T, class Spot>
T slip_excess(const CurveViews& views, const Spot& spot, const Deflection<T>& d,
              bool frictionless) noexcept {
  if (frictionless) return d.lateral_m;
  return curve_at(views, spot, kLateral, d.lateral_m) - curve_at(views, spot, kLimit, d.normal_m);
}

template <class T, class Path>
T slip_excess_along(const CurveViews& views, const Path& path, const Vec3<T>& x, const T& s,
                    bool frictionless) noexcept {
  const auto spot = path.at(s);
  return slip_excess(views, spot, deflection(views, spot, x), frictionless);
}

/// A contact point with what a tool at x feels there: made once, read by slip test and response.
template <class T, class Spot>
struct Footing {
  Spot spot;
  Deflection<T> d;
  T lateral_N;  ///< f^r(dr)
};
template <class T, class Spot>
Footing<T, Spot> footing(const CurveViews& views, const Spot& spot, const Vec3<T>& x) noexcept {
  const Deflection<T> d = deflection(views, spot, x);
  return {spot, d, curve_at(views, spot, kLateral, d.lateral_m)};
}

/// Whether the contact point cannot hold: f^r(dr) > L(dz).
template <class T, class Spot>
bool is_slipping(const CurveViews& views, const Footing<T, Spot>& foot) noexcept {
  if (!(value_of(foot.d.lateral_m) > 0)) return false;
  if (is_frictionless(views, foot.spot)) return true;
  const double limit_N = value_of(curve_at(views, foot.spot, kLimit, foot.d.normal_m));
  return value_of(foot.lateral_N) * (1 - kSlipTolerance) > limit_N || !(limit_N > 0);
}

/// Root of the excess on [0, end] and its slope there.
struct SlipRoot {
  double s;      ///< [m]
  double slope;  ///< d excess / d s at s [N/m], < 0 where it can be trusted
};

/// Safeguarded Newton with exact slopes inside a bisection bracket: excess(0) > 0 >= excess(end).
/// scale: f^r at the start, what the tolerance is a share of; of the excess itself it would fall
/// below rounding when slips are small. At most kMaxRootSteps evaluations; unfinished, it returns
/// the side that holds.
template <class Path>
SlipRoot slip_root(const CurveViews& views, const Path& path, const Vec3d& x, double end,
                   double scale, bool frictionless) noexcept {
  const Vec3<Dual> tip = widened<Dual>(x);
  double lo = 0, hi = end, s = 0, slope = 0;
  for (int i = 0; i < kMaxRootSteps; ++i) {
    const Dual excess = slip_excess_along(views, path, tip, Dual(s, 1), frictionless);
    slope = excess.v;
    if (std::fabs(excess.a) <= kRootTolerance * scale) return {s, slope};
    if (excess.a > 0)
      lo = s;
    else
      hi = s;
    const double newton = s - excess.a / excess.v;
    s = newton > lo && newton < hi ? newton : 0.5 * (lo + hi);
  }
  return {hi, slope};
}

/// The root as the law's scalar: one Newton step in T gives the implicit derivatives, since the
/// value is converged. path is in T, root from the same path in double.
template <class T, class Path>
T differentiable_root(const CurveViews& views, const Path& path, const Vec3<T>& x,
                      const SlipRoot& root, bool frictionless) noexcept {
  if (!(root.slope < 0)) return T(root.s);
  return T(root.s) - slip_excess_along(views, path, x, T(root.s), frictionless) / root.slope;
}
template <class Path>
double differentiable_root(const CurveViews&, const Path&, const Vec3d&, const SlipRoot& root,
                           bool) noexcept {
  return root.s;
}

/// Whether going to the path's end would lengthen the lateral deflection.
template <class Path>
bool flees(const CurveViews& views, const Path& path, const Vec3d& x, double lateral_m,
           double end) noexcept {
  return end > 0 && deflection(views, path.at(end), x).lateral_m > lateral_m;
}

/// What a surface did with a requested move.
enum class Move { whole, stopped };  ///< stopped: the energy guard held part of it back

/// How a slip ended. unfinished: the segments ran out, the next tick goes on from the state.
enum class SlideEnd { stick, slid, stopped, unfinished };

/// Lets the contact point slide until f^r(dr) <= L(dz) for the tool at x [m].
/// foot: the footing of surface.standing() at x, on entry and on return.
/// A slip is made of straight segments: a new one begins where the path crosses into another
/// triangle and where dr would run out first. Work: at most kMaxSegments segments, each with at
/// most kMaxRootSteps + 4 evaluations of the curves. Derivatives are those of the branches taken.
/// Stops where sliding would not shorten dr: deeper than the centre of a convex body's curvature
/// the contact point would flee (the elements' max_depth_m keeps well below).
template <class T, class Surface, class Spot>
SlideEnd slide(const CurveViews& views, const Vec3<T>& x, Surface& surface,
               Footing<T, Spot>& foot) noexcept {
  for (int segment = 0; segment < kMaxSegments; ++segment) {
    if (!is_slipping(views, foot)) return segment == 0 ? SlideEnd::stick : SlideEnd::slid;
    const Deflection<T>& d = foot.d;
    const bool frictionless = is_frictionless(views, foot.spot);
    const auto path = surface.aim(foot.spot, d.lateral);
    const double lateral_m = value_of(d.lateral_m), path_end = value_of(path.end());
    const double end = path_end < lateral_m ? path_end : lateral_m;
    const auto& plain = path.plain();
    if (path.is_blocked() || flees(views, plain, values_of(x), lateral_m, end))
      return SlideEnd::stopped;
    const double inside = kInside * end;
    const bool holds_within =
        slip_excess_along(views, plain, values_of(x), inside, frictionless) < 0;
    T s = path_end < lateral_m ? T(path.end()) : d.lateral_m;
    if (holds_within) {
      const double scale = frictionless ? lateral_m : value_of(foot.lateral_N);
      const SlipRoot root = slip_root(views, plain, values_of(x), inside, scale, frictionless);
      s = differentiable_root(views, path, x, root, frictionless);
    }
    const Move move = surface.move(path, s, x);
    foot = footing(views, surface.standing(), x);
    if (move == Move::stopped) return SlideEnd::stopped;
    if (holds_within) return SlideEnd::slid;
  }
  return SlideEnd::unfinished;
}

template <class T, class Surface>
SlideEnd slide(const CurveViews& views, const Vec3<T>& x, Surface& surface) noexcept {
  auto foot = footing(views, surface.standing(), x);
  return slide(views, x, surface, foot);
}

}  // namespace runtime
}  // namespace palpate
