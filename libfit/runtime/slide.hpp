// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// The stick/slip law of one anchor (docs/method.md, sections 1 to 4), one template for the engine
// (scalar double, the surface is a mesh) and the fitter (scalar double or ceres::Jet, the surface
// is the quadric of quadric.hpp, which also has replay_drag). Forces here are those of the tool ON
// the body.
//
// A Path is a way the contact point can slide, with parameter s >= 0 [m] measured laterally:
//   path.at(s)   -> Spot of deflection.hpp
//   path.end()   -> where the path leaves its triangle, may be infinite
//   path.plain() -> the same path with plain numbers; path.is_blocked(): no way to go
// A Surface holds the contact point:
//   surface.standing()      -> Spot at the contact point
//   surface.aim(spot, direction) -> Path from there (the standing spot) along the lateral unit
//                              vector, projected obliquely along the spot's normal so that the
//                              lateral deflection shrinks by s
//   surface.move(path, s, energy) -> Move: the contact point goes to path(s); energy(spot) [J] is
//                              what would be stored there

#include "response.hpp"

namespace palpate {
namespace runtime {

constexpr int kMaxRootSteps = 12;  ///< Newton needs 3 or 4; 12 bisections leave 1/4096 of a slip
constexpr int kMaxSegments =
    16;  ///< straight pieces of one slip per tick; 14 seen on 800 k triangles
constexpr double kSlipTolerance = 1e-10;  ///< of f^r: keeps a solved slip from slipping again
constexpr double kRootTolerance = 1e-13;  ///< of f^r: where Newton stops
constexpr double kInside =
    1 - 1e-9;  ///< where a path's end is judged: at a skirt's rim all is zero

/// A spot without lateral stiffness cannot reach any limit: it slides as if frictionless.
template <class Spot>
bool is_frictionless(const CurveViews& views, const Spot& spot) noexcept {
  return !(value_of(spot.control(kLateral, views.view[kLateral].size() - 1)) > 0);
}

/// What a slip brings to zero (M8): the lateral force - L(dz) [N]; without lateral stiffness, dr
/// itself (as N).
template <class T, class Spot>
T slip_excess(const CurveViews& views, const Spot& spot, const Deflection<T>& d,
              bool frictionless) noexcept {
  if (frictionless) return d.lateral_m;
  return lateral_force(views, spot, d) - curve_at(views, spot, kLimit, d.normal_m);
}

template <class F, class T, class Path>
T slip_excess_along(const CurveViews& views, const Path& path, const Vec3<T>& x, const T& s,
                    bool frictionless) noexcept {
  const auto spot = path.at(s);
  return slip_excess(views, spot, F::deflection(views, spot, x), frictionless);
}

/// A contact point with what a tool at x feels there: made once, read by slip test and force.
template <class T, class Spot>
struct Footing {
  Spot spot;
  Deflection<T> d;
  T lateral_N;  ///< f^r(dr)
};
template <class F, class T, class Spot>
Footing<T, Spot> footing_as(const CurveViews& views, const Spot& spot, const Vec3<T>& x) noexcept {
  const Deflection<T> d = F::deflection(views, spot, x);
  return {spot, d, lateral_force(views, spot, d)};
}

/// Whether the contact point cannot hold: the lateral force is above L(dz).
template <class T, class Spot>
bool is_slipping(const CurveViews& views, const Footing<T, Spot>& foot) noexcept {
  if (!(value_of(foot.d.lateral_m) > 0)) return false;
  if (is_frictionless(views, foot.spot)) return true;
  const double limit_N = value_of(curve_at(views, foot.spot, kLimit, foot.d.normal_m));
  const double lateral_N = value_of(foot.lateral_N);
  return lateral_N * (1 - kSlipTolerance) > limit_N || !(limit_N > 0);
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
template <class F, class Path>
SlipRoot slip_root(const CurveViews& views, const Path& path, const Vec3d& x, double end,
                   double scale, bool frictionless) noexcept {
  const Vec3<Dual> tip = widened<Dual>(x);
  double lo = 0, hi = end, s = 0, slope = 0;
  for (int i = 0; i < kMaxRootSteps; ++i) {
    const Dual excess = slip_excess_along<F>(views, path, tip, Dual(s, 1), frictionless);
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
template <class F, class T, class Path>
T differentiable_root(const CurveViews& views, const Path& path, const Vec3<T>& x,
                      const SlipRoot& root, bool frictionless) noexcept {
  if (!(root.slope < 0)) return T(root.s);
  return T(root.s) - slip_excess_along<F>(views, path, x, T(root.s), frictionless) / root.slope;
}
template <class F, class Path>
double differentiable_root(const CurveViews&, const Path&, const Vec3d&, const SlipRoot& root,
                           bool) noexcept {
  return root.s;
}

/// Whether going to the path's end would lengthen the lateral deflection.
template <class F, class Path>
bool flees(const CurveViews& views, const Path& path, const Vec3d& x, double lateral_m,
           double end) noexcept {
  return end > 0 && F::deflection(views, path.at(end), x).lateral_m > lateral_m;
}

/// What a surface did with a requested move.
enum class Move { whole, stopped };  ///< stopped: the energy guard held part of it back

/// How a slip ended. unfinished: the segments ran out, the next tick goes on from the state.
enum class SlideEnd { stick, slid, stopped, unfinished };

/// Lets the contact point slide until the lateral force is at most L(dz) for the tool at x [m].
/// F: the family, by its deflection. foot: the footing of surface.standing() at x, on entry and on
/// return. A slip is made of straight segments: a new one begins where the path crosses into
/// another triangle and where dr would run out first. Work: at most kMaxSegments segments, each
/// with at most kMaxRootSteps + 4 evaluations of the curves. Derivatives are those of the branches
/// taken. Stops where sliding would not shorten dr: deeper than the centre of a convex body's
/// curvature the contact point would flee (the elements' max_depth_m keeps well below).
template <class F, class T, class Surface, class Spot>
SlideEnd slide_until_it_holds(const CurveViews& views, const Vec3<T>& x, Surface& surface,
                              Footing<T, Spot>& foot) noexcept {
  for (int segment = 0; segment < kMaxSegments; ++segment) {
    if (!is_slipping(views, foot)) return segment == 0 ? SlideEnd::stick : SlideEnd::slid;
    const Deflection<T>& d = foot.d;
    const bool frictionless = is_frictionless(views, foot.spot);
    const auto path = surface.aim(foot.spot, d.lateral);
    const double lateral_m = value_of(d.lateral_m), path_end = value_of(path.end());
    const double end = path_end < lateral_m ? path_end : lateral_m;
    const auto& plain = path.plain();
    if (path.is_blocked() || flees<F>(views, plain, values_of(x), lateral_m, end))
      return SlideEnd::stopped;
    const double inside = kInside * end;
    const bool holds_within =
        slip_excess_along<F>(views, plain, values_of(x), inside, frictionless) < 0;
    T s = path_end < lateral_m ? T(path.end()) : d.lateral_m;
    if (holds_within) {
      const double scale = frictionless ? lateral_m : value_of(foot.lateral_N);
      const SlipRoot root = slip_root<F>(views, plain, values_of(x), inside, scale, frictionless);
      s = differentiable_root<F>(views, path, x, root, frictionless);
    }
    const Move move = surface.move(path, s, [&](const auto& there) noexcept {
      return F::energy_J(views, F::deflection(views, there, values_of(x)), there);
    });
    foot = footing_as<F>(views, surface.standing(), x);
    if (move == Move::stopped) return SlideEnd::stopped;
    if (holds_within) return SlideEnd::slid;
  }
  return SlideEnd::unfinished;
}

}  // namespace runtime
}  // namespace palpate
