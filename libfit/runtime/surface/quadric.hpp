// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// The fitter's view of the body around a test point: a quadric surface on which the stick/slip law
// of slide.hpp replays a whole experiment, with derivatives when the scalar carries them.
// All positions are relative to the test point.

#include <type_traits>

#include "../families/families.hpp"
#include "../sway.hpp"

namespace palpate {
namespace runtime {

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

/// About its test point a body is uneven by its side force: Z grows by p.g(d) along the way p of
/// the contact point, and the rings stiffen as f^z does.
constexpr double kLeastStiffening = 0.2;
template <class T>
struct Unevenness {
  T value_N, slope_N_m;  ///< p.g [J] and p.g' [N]
  T stiffening;          ///< of the rings
};
template <class S, class C, bool kIsPlain>
Unevenness<S> unevenness(const QuadricSpot<S, C, kIsPlain>& spot, const RingBed<S, kRings>& bed,
                         const S& depth_m, const S& normal_N) noexcept {
  const SideForce<S> side = side_force(bed, depth_m);
  Unevenness<S> out{dot(spot.shadow, side.value_N), dot(spot.shadow, side.slope_N_m), S(1)};
  if (!(value_of(normal_N) > 0)) return out;
  out.stiffening = S(1) + out.slope_N_m / normal_N;
  if (!(value_of(out.stiffening) > kLeastStiffening)) out.stiffening = S(kLeastStiffening);
  return out;
}

/// A way over the quadric whose shadow on the tangent plane is straight. P: scalar of the place,
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

  QuadricSpot<T, T, false> standing() const noexcept { return way({T(0), T(0), T(0)}).at(T(0)); }
  /// The direction is tangent to the quadric (its normal is the field's), so only its shadow
  /// counts.
  QuadricPath<T, T> aim(const QuadricSpot<T, T, false>&, const Vec3<T>& direction) const noexcept {
    return way(direction);
  }
  QuadricPath<T, T> way(const Vec3<T>& direction) const noexcept {
    const Vec3<T> u0 = widened<T>(quadric->u0);
    return {quadric, p, direction - u0 * dot(direction, u0), controls};
  }
  bool is_spent() const noexcept { return false; }
  void move(const QuadricPath<T, T>& path, const T& s) noexcept {
    p = path.start + path.direction * s;
  }
};

/// Where the straight way from `outside` to `inside` enters the body, as a shadow on the tangent
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

/// A contact on a quadric between two rows of a replay.
template <class F, class T>
struct QuadricContact {
  QuadricSurface<T> surface;
  typename F::template Memory<T> memory;
  bool is_first = true, in_contact = true, has_slipped = false;
  Vec3d before{0, 0, 0};
  Vec3<T> tool{T(0), T(0), T(0)};  ///< where it was last

  QuadricContact(const CurveViews& views, const Quadric& quadric,
                 const ControlPointers<T>& controls) noexcept
      : surface{&quadric, controls, {T(0), T(0), T(0)}},
        memory(F::template load<T>(no_memory(), views.relaxation)) {}

  /// The force on the body of a tool that goes to x. left: of half of the time that this takes,
  /// where the body relaxes.
  Vec3<T> go_to(const CurveViews& views, const Vec3<T>& x, const Decay& left) noexcept {
    const Quadric& quadric = *surface.quadric;
    const Vec3<T> nothing{T(0), T(0), T(0)};
    const Vec3d tip = values_of(x);
    has_slipped = false;
    if (!in_contact && depth_below(quadric, before) <= 0 && depth_below(quadric, tip) > 0) {
      surface.p = widened<T>(entry_shadow(quadric, before, tip));
      memory = F::template load<T>(no_memory(), views.relaxation);
      tool = widened<T>(before);
      in_contact = true;
    }
    before = tip;
    if (!in_contact) return nothing;
    if constexpr (F::kCanRelax)
      if (F::relaxes(views))
        F::relax(views, F::kinematics(views, surface.standing(), tool, memory), left, memory);
    tool = x;
    auto kinematics = F::kinematics(views, surface.standing(), x, memory);
    const Vec3<T> from = kinematics.spot.point;
    Vec3<T> seen = x;
    if constexpr (F::kCanRelax)
      if (F::relaxes(views)) {
        F::relax(views, kinematics, left, memory);
        seen = F::seen(views, kinematics, x, memory);
        kinematics = F::kinematics(views, surface.standing(), seen, memory);
      }
    if (slide<F>(views, seen, surface, kinematics, memory) != SlideEnd::stick) {
      has_slipped = true;
      F::carry(views, memory, kinematics.spot.point - from, kinematics.spot.normal);
    }
    if (has_slipped || F::relaxes(views))
      kinematics = F::kinematics(views, surface.standing(), x, memory);
    const auto& under = F::under(views, kinematics);
    const Vec3<T> force =
        F::answer(views, under, kinematics, F::slip(views, under, kinematics, memory)).force_N;
    in_contact = value_of(kinematics.d.normal_m) > 0 || is_first;
    is_first = false;
    return force;
  }
};

/// The compliance among a point's numbers, with plain numbers; with derivatives none: rows that a
/// fit replays are without the sway.
template <class F, class T>
Compliance compliance_of(const ControlPointers<T>& controls) noexcept {
  Compliance out;
  if constexpr (F::kSwayPart >= 0 && std::is_same<T, double>::value)
    for (int i = 0; i < 6; ++i) out.c[i] = controls.part[F::kSwayPart][i];
  return out;
}

/// Into how many ticks a replay divides a row in which the tool moves: the law lets dashpots flow
/// for half of a tick at either end, so a branch's force errs by 1/24 (dt/time)^2, 1/1500 of it at
/// these. The cap is for branches that are over long before the row is.
constexpr double kTicksPerRelaxation = 8;
constexpr int kMaxReplayTicks = 64;
inline int replay_ticks(const RelaxationView& relaxation, double dt_s, bool moves) noexcept {
  if (relaxation.branches == 0 || !moves) return 1;
  const double wanted = kTicksPerRelaxation * dt_s / relaxation.time_s[0];
  return wanted < kMaxReplayTicks ? 1 + static_cast<int>(wanted) : kMaxReplayTicks;
}

/// What is replayed: rows x 3 [m], tool position relative to the test point, in order, and when
/// each was reached [s] since first touch. time_s: null where rows are of slow motion.
struct ReplayedRows {
  const double* deflection_m;
  int rows;
  const double* time_s = nullptr;
};

/// Forces of the tool on the body along one press, drag or path: the law predicting a record. The
/// first touch is at the test point, later ones (after a lift) where the way enters the body.
/// deeper_m: how much deeper along the inward normal the tool was. force_N: rows results. The
/// contact is carried from row to row; each row is one tick of the engine, or more where the body
/// relaxes, so steps should not be much longer than the lateral deflection at which the tool slips.
/// A body that relaxes answers rows without time as in slow motion. Returns how many rows slipped.
/// Derivatives flow through every slip's root.
template <class F, class T>
int replay_as(const CurveViews& any_time, const ControlPointers<T>& controls,
              const Quadric& quadric, const ReplayedRows& record, const T* deeper_m,
              Vec3<T>* force_N) noexcept {
  CurveViews slow;
  const bool is_slow = record.time_s == nullptr && F::relaxes(any_time);
  if (is_slow) {
    slow = any_time;
    slow.relaxation = RelaxationView();
  }
  const CurveViews& views = is_slow ? slow : any_time;
  QuadricContact<F, T> contact(views, quadric, controls);
  const Compliance give = compliance_of<F>(controls);
  Sway sway;
  int slipped = 0;
  Vec3<T> from{T(0), T(0), T(0)};
  for (int row = 0; row < record.rows; ++row) {
    Vec3<T> x = widened<T>(make_vec3<double>(record.deflection_m + 3 * row));
    if (deeper_m != nullptr) x = x + widened<T>(quadric.u0) * *deeper_m;
    const Vec3<T> way = x - from;
    const double dt_s =
        record.time_s == nullptr ? 0 : record.time_s[row] - (row > 0 ? record.time_s[row - 1] : 0);
    const int ticks =
        F::relaxes(views) ? replay_ticks(views.relaxation, dt_s, value_of(dot(way, way)) > 0) : 1;
    const Decay left = decay_over(views.relaxation, 0.5 * dt_s / ticks);
    bool has_slipped = false;
    for (int tick = 1; tick <= ticks; ++tick) {
      const Vec3<T> at = tick == ticks ? x : from + way * (double(tick) / ticks);
      bool is_done = false;
      if constexpr (std::is_same<T, double>::value) {
        if (give.is_any()) {
          let_creep(views.relaxation, left, sway);
          const Vec3d rest = at - give.times(rest_force(views.relaxation, sway));
          const Compliance fast = give.over(views.relaxation.fast);
          const QuadricContact<F, T> start = contact;
          settle(fast, sway, [&](const Vec3d& f) noexcept {
            contact = start;
            return force_N[row] = contact.go_to(views, rest - fast.times(f), left);
          });
          is_done = true;
        }
      }
      if (!is_done) force_N[row] = contact.go_to(views, at, left);
      has_slipped |= contact.has_slipped;
    }
    from = x;
    slipped += has_slipped;
  }
  return slipped;
}
template <class T>
int replay_drag(const CurveViews& views, const ControlPointers<T>& controls, const Quadric& quadric,
                const ReplayedRows& record, const T* deeper_m, Vec3<T>* force_N) noexcept {
  return with_family(views, [&](auto f) noexcept {
    return replay_as<decltype(f)>(views, controls, quadric, record, deeper_m, force_N);
  });
}

template <class T>
int replay_drag(const CurveViews& views, const ControlPointers<T>& controls, const Quadric& quadric,
                const double* deflection_m, int rows, Vec3<T>* force_N) noexcept {
  return replay_drag<T>(views, controls, quadric, {deflection_m, rows}, nullptr, force_N);
}

}  // namespace runtime
}  // namespace palpate
