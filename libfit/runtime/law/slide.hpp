// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// Slides of a contact point (docs/method.md, section 4), one template for the engine (scalar
// double, the surface is a mesh) and the fitter (scalar double or ceres::Jet, the surface is the
// quadric of quadric.hpp, which also has replay_drag).
//
// A Path is a curve along which the contact point can slide, with parameter s >= 0 [m] measured
// laterally:
//   path.at(s)   -> Spot of response.hpp
//   path.end()   -> where the path leaves its triangle or the tick's slip budget ends, may be
//                   infinite
//   path.plain() -> the same path with plain numbers; path.is_blocked(): nothing can move;
//                   path.is_straight(): not along a border
// A Surface holds the contact point:
//   surface.standing()      -> Spot at the contact point
//   surface.aim(spot, direction) -> Path from there (the standing spot) along the lateral unit
//                              vector, projected obliquely along the spot's normal so that the
//                              lateral deflection shrinks by s
//   surface.move(path, s)   the contact point goes to path(s), s <= end, over the edge at its end
//   surface.is_spent()      whether the slip budget is why a path is blocked
// The concept of a family is in law/families.hpp.

#include "response.hpp"

namespace palpate::runtime {

/// End of a slip. stopped: a border, a hollow or the body's own shape blocks the path.
/// unfinished: budget or segments ran out, the next tick goes on from the state.
enum class SlideEnd { stick, slid, stopped, unfinished };

/// Direction in which friction draws the contact point.
template <class T>
struct SlideTarget {
  Vec3<T> direction;  ///< lateral unit vector
  T distance_m;       ///< largest slide
};
/// Target along a lateral vector [m] longer than kLateralZero_m.
template <class T>
SlideTarget<T> slide_target_of(const Vec3<T>& lateral) noexcept {
  using std::sqrt;
  const T size = sqrt(dot(lateral, lateral));
  return {lateral * (1.0 / size), size};
}

/// Root of what a slip brings to zero, and its slope there; s < 0: none on the path.
struct SlipRoot {
  double s;      ///< [m]
  double slope;  ///< < 0 where it can be trusted
};

/// First root of excess(s) on [0, end] by Newton with exact slopes, within a bracket that ends
/// where the excess is known to be negative. start: excess(0) > 0. guess: its mean slope to the
/// root, as of the slip before; 0: unknown, Newton begins at 0. scale: of the excess, what the
/// tolerance is a share of. The last step goes by the parabola of s over the excess through the
/// last two places and the last slope, without looking where it led; its error is of third order
/// and estimated by how far that slope is from the mean one; where the excess has knots (not
/// is_smooth), by the fall alone. At most kMaxRootSteps + 1 evaluations, whatever the guess;
/// unfinished, it returns the side that holds.
template <class Excess>
SlipRoot first_root(const Excess& excess, double start, double guess, double end, double scale,
                    bool is_smooth) noexcept {
  const double guessed = guess < 0 ? -start / guess : 0;
  double lo = 0, hi = end, s = guessed < end ? guessed : 0, before_s = 0;
  double before = s > 0 ? start : 0;  // 0: there is no place before
  Dual at(0);
  bool is_bracket = false;
  if (guessed >= end) {
    if (!(excess(end).a < 0)) return {-1, 0};
    is_bracket = true;
  }
  for (int i = 0; i < kMaxRootSteps; ++i) {
    at = excess(s);
    if (std::fabs(at.a) <= kRootTolerance * scale) return {s, at.v};
    if (at.a > 0) {
      lo = s;
    } else {
      hi = s;
      is_bracket = true;
    }
    const double step = -at.a / at.v, newton = s + step;
    const bool is_inside = newton > lo && newton < hi;
    if (!is_inside && !is_bracket) {
      if (!(excess(end).a < 0)) return {-1, 0};
      is_bracket = true;
    }
    if (is_inside && before != 0) {
      const double fall = before - at.a, mean = fall / (before_s - s), bend = 1 - at.v / mean;
      const double share = at.a / before;
      if (std::fabs(at.a * share) * (is_smooth ? 4 * bend * bend : 1) <= kRootTolerance * scale) {
        const double root = newton + step * (at.a / fall * bend);
        if (root > lo && root < hi)
          return {root, at.v + 2 * (at.v - mean) * (step / (s - before_s))};
      }
    }
    before = at.a;
    before_s = s;
    s = is_inside ? newton : 0.5 * (lo + hi);
  }
  if (!is_bracket && !(excess(end).a < 0)) return {-1, 0};
  return {hi, at.v};
}

/// Slides the contact point along a path until it holds (M8), (B3): to the first root of the
/// family's excess, or to its end. One Newton step in T brings the implicit derivatives, since
/// the value is converged. slope: the excess's mean slope over the last slip, 0 before the first;
/// it becomes that of this one.
template <class T>
struct Slip {
  T s;
  bool holds_within;
  bool flees;  ///< the end of the path is farther from the tool than its beginning
};
template <class F, class T, class Path, class Kinematics>
Slip<T> slip_along(const CurveViews& views, const Path& path, const Kinematics& kinematics,
                   const SlideTarget<T>& target, const Vec3<T>& x, double& slope) noexcept {
  const double reach = value_of(target.distance_m), path_end = value_of(path.end());
  const double end = path_end < reach ? path_end : reach;
  const auto& plain = path.plain();
  const Vec3d tip = values_of(x);
  const auto& slip_path = F::slip_path(plain, tip);
  const auto kind = F::excess_kind(views, kinematics);
  const double start = F::current_excess(views, kinematics, kind),
               scale = F::excess_scale(views, kinematics, kind);
  const bool has_limit = start < scale;  // a limit that begins on the path makes a bend
  const SlipRoot root =
      first_root([&](double s) noexcept { return F::excess_along(views, slip_path, tip, s, kind); },
                 start, slope, kPathEndShare * end, scale, F::kIsSmooth && has_limit);
  if (root.s < 0) {
    const bool flees = end > 0 && F::lateral_m(views, plain.at(end), tip) > reach;
    return {path_end < reach ? T(path.end()) : target.distance_m, false, flees};
  }
  slope = root.s > 0 ? -start / root.s : 0;
  if constexpr (std::is_same<T, double>::value) {
    return {root.s, true, false};
  } else {
    if (!(root.slope < 0)) return {T(root.s), true, false};
    const T s = T(root.s) - F::excess(views, path.at(T(root.s)), x, kind) / root.slope;
    return {s, true, false};
  }
}

/// Lets the contact point slide until it holds the tool at x [m]. kinematics: those of
/// surface.standing() at x on entry; on return its .spot is where the contact point stands and the
/// rest is used up. memory: the family's. Where the contact point
/// may not go (a border, a hollow, the slip budget) its anchor slips without it and comes to rest
/// beside it, so the limit always holds; it is drawn there at the next ticks. A slip is made of
/// straight segments: a new one begins where the path crosses into another triangle. Work: at most
/// kMaxSegments segments, each with at most kMaxRootSteps + 3 evaluations. Derivatives are those of
/// the branches taken. Stops where sliding would not bring it nearer: deeper than the centre of a
/// convex body's curvature the contact point would flee (the elements' max_depth_m keeps well
/// below).
template <class F, class T, class Surface, class Kinematics, class Memory>
SlideEnd slide(const CurveViews& views, const Vec3<T>& x, Surface& surface, Kinematics& kinematics,
               Memory& memory) noexcept {
  SlideEnd end = SlideEnd::stick;
  for (int segment = 0;; ++segment) {
    if (F::has_anchor_offset(memory)) F::slip_anchor(views, kinematics, memory);
    const bool has_anchor_offset = F::has_anchor_offset(memory);
    if (!has_anchor_offset && !F::is_slipping(views, kinematics)) return end;
    end = SlideEnd::unfinished;
    if (segment == kMaxSegments) break;
    const SlideTarget<T> target =
        has_anchor_offset ? slide_target_of(F::anchor_offset(memory)) : F::slide_target(kinematics);
    const auto path = surface.aim(kinematics.spot, target.direction);
    if (path.is_blocked()) {
      if (!surface.is_spent()) end = SlideEnd::stopped;
      break;
    }
    const double path_end = value_of(path.end());
    const Slip<T> slip =
        !has_anchor_offset ? slip_along<F>(views, path, kinematics, target, x, memory.slip_slope)
        : path_end < value_of(target.distance_m) ? Slip<T>{T(path.end()), false, false}
                                                 : Slip<T>{target.distance_m, true, false};
    if (slip.flees) {
      end = SlideEnd::stopped;
      break;
    }
    const Vec3<T> from = kinematics.spot.point;
    surface.move(path, slip.s);
    const auto spot = surface.standing();
    if (has_anchor_offset)
      F::transport_anchor(memory, spot.point - from, spot.normal,
                          slip.holds_within && path.is_straight());
    end = SlideEnd::slid;
    kinematics.spot = spot;
    if (slip.holds_within && !has_anchor_offset) return end;
    kinematics = F::kinematics(views, spot, x, memory);
  }
  F::slip_anchor(views, kinematics, memory);
  return end;
}

}  // namespace palpate::runtime
