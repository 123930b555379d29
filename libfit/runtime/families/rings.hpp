// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// The law of a bed of stick-slip rings (docs/method.md, section 17): what a contact stores (B1) is
//
//     E = Z_c(d) + q.g_c(d) + 1/2 sum lambda c_i |q_i|^2
//
// over the tool's place alone, with the anchors of the rings as its memory. A ring is the part of
// the contact that touches from the depth d_i on; its stiffness is read off the press curve. Each
// holds until |q_i| = mu(d) (d - d_i) / lambda, then its anchor follows. Ring 1 is anchored at the
// contact point c itself and slips last: its slip is the slide of c over the surface.
//
// One template for the engine (scalar double, or Jet3 for the tangent) and the fitter (double or
// ceres::Jet). Forces are those of the tool ON the body.

#include <type_traits>
#include <utility>

#include "../slide.hpp"

namespace palpate {
namespace runtime {

/// Parts of a node beside its normal curve.
constexpr int kLambda = 1;         ///< lateral over normal stiffness of a ring [1]
constexpr int kFriction = 2;       ///< mu_0 [1]
constexpr int kFrictionSlope = 3;  ///< mu_1 [1/m]: a ball ploughs
constexpr int kSide2 = 4;          ///< g_2 [N/m^2]
constexpr int kSide3 = 5;          ///< g_3 [N/m^3]
constexpr int kCurvature = 6;      ///< kappa = -du/dc [1/m]

/// How far a ring may be deflected at a depth.
template <class T>
struct RingLimit {
  T lambda, friction, friction_slope;

  /// mu(d) [1], never below 0.
  T friction_at(const T& depth_m) const noexcept {
    const T mu = friction + friction_slope * depth_m;
    return value_of(mu) > 0 ? mu : T(0);
  }
};
template <class T, class Spot>
RingLimit<T> ring_limit(const Spot& spot) noexcept {
  return {spot.control(kLambda, 0), spot.control(kFriction, 0), spot.control(kFrictionSlope, 0)};
}

/// The rings under a spot and the side force there.
template <class T, int N>
struct RingBed {
  RingLimit<T> limit;
  T stiffness_N_m[N];  ///< lambda c_i >= 0
  /// lambda c_i that was cut at 0 where the normal curve is concave, as its size; see ring_share().
  T excess_N_m[N];
  bool is_cut;
  Vec3<T> side2, side3;  ///< g = side2 d^2 + side3 d^3, tangential
};

template <class T>
Vec3<T> tangential(const Vec3<T>& v, const Vec3<T>& normal) noexcept {
  return v - normal * dot(v, normal);
}

template <class T, int N, class Spot>
RingBed<T, N> ring_bed(const RingTable<N>& table, const Spot& spot) noexcept {
  RingBed<T, N> bed;
  bed.limit = ring_limit<T>(spot);
  bed.is_cut = false;
  T below = T(0);
  T b[kMaxDegree + 1];  // alive at edge i: neighbours share most of them
  int first = -1;
  for (int i = 0; i < N; ++i) {
    const int step = first < 0 ? table.order : table.first[i] - first;
    first = table.first[i];
    for (int k = 0; k < table.order; ++k)
      b[k] = k + step < table.order ? b[k + step] : spot.control(kNormal, first + k);
    T slope = b[0] * table.slope[i][0];
    for (int k = 1; k < table.order; ++k) slope = slope + b[k] * table.slope[i][k];
    const T stiffness = bed.limit.lambda * (slope - below);
    const bool is_cut = !(value_of(stiffness) >= 0);
    bed.stiffness_N_m[i] = is_cut ? T(0) : stiffness;
    bed.excess_N_m[i] = is_cut ? T(0) - stiffness : T(0);
    bed.is_cut = bed.is_cut || is_cut;
    below = slope;
  }
  const auto vector = [&](int part) noexcept {
    return tangential<T>({spot.control(part, 0), spot.control(part, 1), spot.control(part, 2)},
                         spot.normal);
  };
  bed.side2 = vector(kSide2);
  bed.side3 = vector(kSide3);
  return bed;
}

/// How a tool stands against its contact point: q = P (x - c), d = (x - c).u - 1/2 q.kappa q, for
/// it presses on the surface under it and not on the tangent plane of c.
template <class T>
struct RingStance {
  Vec3<T> q;
  T depth_m;    ///< d, > 0 in contact
  Vec3<T> dip;  ///< P kappa q [1]: d falls by dip . dx where x moves sideways
};
template <class T, class Spot>
RingStance<T> ring_stance(const Spot& spot, const Vec3<T>& x) noexcept {
  const Vec3<T> delta = x - spot.point;
  const T height = dot(delta, spot.normal);
  const Vec3<T> q = delta - spot.normal * height;
  const T xy = spot.control(kCurvature, 3), xz = spot.control(kCurvature, 4),
          yz = spot.control(kCurvature, 5);
  const Vec3<T> bent{spot.control(kCurvature, 0) * q.x + xy * q.y + xz * q.z,
                     xy * q.x + spot.control(kCurvature, 1) * q.y + yz * q.z,
                     xz * q.x + yz * q.y + spot.control(kCurvature, 2) * q.z};
  return {q, height - 0.5 * dot(q, bent), tangential(bent, spot.normal)};
}

/// lambda |q| - mu(d) d [m]: a slide of the contact point brings it to zero. Needs no curve.
template <class T, class Spot>
T ring_slip_excess(const Spot& spot, const Vec3<T>& x) noexcept {
  using std::sqrt;
  const RingStance<T> at = ring_stance(spot, x);
  const RingLimit<T> limit = ring_limit<T>(spot);
  const T squared = dot(at.q, at.q);
  const T size = value_of(squared) > kLateralZero_m * kLateralZero_m ? sqrt(squared) : T(0);
  const T depth = value_of(at.depth_m) > 0 ? at.depth_m : T(0);
  return limit.lambda * size - limit.friction_at(depth) * depth;
}

/// Where rings 2 to N are anchored, relative to the contact point and tangential there [m].
template <class T, int N>
struct RingAnchors {
  Vec3<T> at[N - 1];
};
template <class T, int N>
RingAnchors<T, N> no_anchors() noexcept {
  RingAnchors<T, N> out;
  for (Vec3<T>& a : out.at) a = {T(0), T(0), T(0)};
  return out;
}

template <class T, int N>
RingAnchors<double, N> values_of(const RingAnchors<T, N>& anchors) noexcept {
  RingAnchors<double, N> out;
  for (int i = 0; i + 1 < N; ++i) out.at[i] = values_of(anchors.at[i]);
  return out;
}

/// After the contact point moved by `way` to a place of another normal: the anchors stay where they
/// are in space, but for what sticks out of the tangent plane.
template <class T, int N>
void carry_anchors(RingAnchors<T, N>& anchors, const Vec3<T>& way, const Vec3<T>& normal) noexcept {
  for (Vec3<T>& a : anchors.at) a = tangential(a - way, normal);
}

/// 1 where every ring has the stiffness that the curve says. Where the curve is concave, rings that
/// would be negative are none, and the others bear sum c_i h_i / sum max(c_i, 0) h_i of theirs, so
/// that the whole bed still bears f^z. Its slope belongs to the energy.
template <class T>
struct RingShare {
  T value, slope;
};
template <class T, int N>
RingShare<T> ring_share(const RingTable<N>& table, const RingBed<T, N>& bed,
                        const T& depth_m) noexcept {
  if (!bed.is_cut) return {T(1), T(0)};
  T kept = T(0), cut = T(0), kept_slope = T(0), cut_slope = T(0);
  for (int i = 0; i < N; ++i) {
    const T reach = depth_m - table.threshold_m[i];
    if (!(value_of(reach) > 0)) break;
    kept = kept + bed.stiffness_N_m[i] * reach;
    cut = cut + bed.excess_N_m[i] * reach;
    kept_slope = kept_slope + bed.stiffness_N_m[i];
    cut_slope = cut_slope + bed.excess_N_m[i];
  }
  if (!(value_of(kept) > value_of(cut))) return {T(value_of(kept) > 0 ? 0 : 1), T(0)};
  const T ratio = cut / kept;
  return {T(1) - ratio, (ratio * kept_slope - cut_slope) / kept};
}

/// What the rings of a contact do at a depth: sum of lambda c_i q_i [N] and what they store [J].
template <class T>
struct RingPull {
  Vec3<T> force_N;
  T stored_J;
};
/// Without letting any ring slip.
template <class T, int N>
RingPull<T> ring_pull(const RingBed<T, N>& bed, const RingStance<T>& at,
                      const RingAnchors<T, N>& anchors) noexcept {
  Vec3<T> force = at.q * bed.stiffness_N_m[0];
  T twice = bed.stiffness_N_m[0] * dot(at.q, at.q);
  for (int i = 1; i < N; ++i) {
    const Vec3<T> q = at.q - anchors.at[i - 1];
    force = force + q * bed.stiffness_N_m[i];
    twice = twice + bed.stiffness_N_m[i] * dot(q, q);
  }
  return {force, 0.5 * twice};
}

/// (B3) of rings 2 to N: what a ring is deflected beyond its limit its anchor takes. Rings that do
/// not touch are anchored under the tool. Shortens every |q_i|, so the stored energy falls whatever
/// the tick. Returns the sum of lambda c_i times what the squares of |q_i| lost [J], twice the
/// energy.
template <class T, int N>
double settle_rings(const RingTable<N>& table, const RingBed<T, N>& bed, const RingStance<T>& at,
                    RingAnchors<T, N>& anchors) noexcept {
  using std::sqrt;
  const T lambda = bed.limit.lambda, mu = bed.limit.friction_at(at.depth_m);
  double lost = 0;
  for (int i = 1; i < N; ++i) {
    Vec3<T>& a = anchors.at[i - 1];
    const Vec3<T> q = at.q - a;
    const T squared = dot(q, q), reach = at.depth_m - table.threshold_m[i];
    const T most = value_of(reach) > 0 ? mu * reach : T(0), length = lambda * lambda * squared;
    if (!(value_of(length) > value_of(most) * value_of(most))) {
      if (!(value_of(reach) > 0)) a = at.q;
      continue;
    }
    const T share = value_of(most) > 0 ? most / sqrt(length) : T(0);
    a = at.q - q * share;
    lost += value_of(bed.stiffness_N_m[i]) * value_of(squared) *
            (1 - value_of(share) * value_of(share));
  }
  return lost;
}

/// g(d) and its slope.
template <class T>
struct SideForce {
  Vec3<T> value_N, slope_N_m;
};
template <class T, int N>
SideForce<T> side_force(const RingBed<T, N>& bed, const T& depth_m) noexcept {
  const T d = depth_m, dd = d * d;
  return {bed.side2 * dd + bed.side3 * (dd * d), bed.side2 * (2.0 * d) + bed.side3 * (3.0 * dd)};
}

/// E of (B1) [J] at anchors that hold. normal_J: Z_c(d).
template <class T, int N>
T ring_energy_J(const RingTable<N>& table, const RingBed<T, N>& bed, const RingStance<T>& at,
                const RingAnchors<T, N>& anchors, const T& normal_J) noexcept {
  const T lateral_J =
      ring_share(table, bed, at.depth_m).value * ring_pull(bed, at, anchors).stored_J;
  if (!(value_of(at.depth_m) > 0)) return lateral_J;  // of rings that let go at this tick
  return normal_J + dot(at.q, side_force(bed, at.depth_m).value_N) + lateral_J;
}

/// (B2), the gradient of E by x [N]: (f^z + q.g') (u - P kappa q) + g + sum lambda c_i q_i. Zero
/// where d <= 0. normal_N: f^z_c(d).
template <class T, int N>
Vec3<T> ring_force(const RingTable<N>& table, const RingBed<T, N>& bed, const RingStance<T>& at,
                   const RingAnchors<T, N>& anchors, const Vec3<T>& normal,
                   const T& normal_N) noexcept {
  if (!(value_of(at.depth_m) > 0)) return {T(0), T(0), T(0)};
  const SideForce<T> side = side_force(bed, at.depth_m);
  const RingPull<T> pull = ring_pull(bed, at, anchors);
  T along_N = normal_N + dot(at.q, side.slope_N_m);
  Vec3<T> lateral = pull.force_N;
  if (bed.is_cut) {
    const RingShare<T> share = ring_share(table, bed, at.depth_m);
    along_N = along_N + share.slope * pull.stored_J;
    lateral = lateral * share.value;
  }
  return (normal - at.dip) * along_N + side.value_N + lateral;
}

/// lambda |q| - mu(d) d [m] along a path: what a slide of the contact point brings to zero.
template <class T, class Path>
T ring_excess_along(const Path& path, const Vec3<T>& x, const T& s) noexcept {
  return ring_slip_excess(path.at(s), x);
}

/// A path as the excess reads it; a path that can be read faster brings an overload.
template <class Path>
const Path& way_of_excess(const Path& path) noexcept {
  return path;
}

/// First root of the excess on [0, end] by Newton from the start, within a bracket that ends where
/// the excess is known to be negative; s < 0 where there is none. excess(0) > 0.
template <class Path>
SlipRoot first_ring_root(const Path& path, const Vec3d& x, double end, double scale) noexcept {
  const Vec3<Dual> tip = widened<Dual>(x);
  double lo = 0, hi = end, s = 0, slope = 0;
  bool is_bracket = false;
  for (int i = 0; i < kMaxRootSteps; ++i) {
    const Dual excess = ring_excess_along(path, tip, Dual(s, 1));
    slope = excess.v;
    if (std::fabs(excess.a) <= kRootTolerance * scale) return {s, slope};
    if (excess.a > 0) {
      lo = s;
    } else {
      hi = s;
      is_bracket = true;
    }
    const double newton = s - excess.a / excess.v;
    const bool is_inside = newton > lo && newton < hi;
    if (!is_inside && !is_bracket) {
      if (!(ring_excess_along(path, x, end) < 0)) return {-1, 0};
      is_bracket = true;
    }
    s = is_inside ? newton : 0.5 * (lo + hi);
  }
  if (!is_bracket && !(ring_excess_along(path, x, end) < 0)) return {-1, 0};
  return {hi, slope};
}

template <class T, class Path>
T differentiable_ring_root(const Path& path, const Vec3<T>& x, const SlipRoot& root) noexcept {
  if (!(root.slope < 0)) return T(root.s);
  return T(root.s) - ring_excess_along(path, x, T(root.s)) / root.slope;
}
template <class Path>
double differentiable_ring_root(const Path&, const Vec3d&, const SlipRoot& root) noexcept {
  return root.s;
}

/// The rings under a spot. A spot that has them at hand brings an overload.
template <class T, class Spot>
RingBed<T, kRings> bed_under(const CurveViews& views, const Spot& spot) noexcept {
  return ring_bed<T>(views.rings, spot);
}

/// Where the fitter's spot lies from the test point about which the body is uneven; nowhere
/// else.
template <class Spot>
struct IsUneven : std::false_type {};

/// bed: made where the footing is, read by settle, force and energy.
template <class T, class Spot>
struct RingFooting {
  Spot spot;
  Deflection<T> d;  ///< normal_m: d of (B1); lateral_m: |q|
  RingStance<T> at;
  decltype(bed_under<T>(std::declval<const CurveViews&>(), std::declval<const Spot&>())) bed;
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
  static constexpr int kNumbers = 15;
  static constexpr int kMemory = 3 * (kRings - 1);

  template <class T>
  using Memory = RingAnchors<T, kRings>;
  template <class T>
  static Memory<T> load(const double* from) noexcept {
    Memory<T> out;
    for (int i = 0; i + 1 < kRings; ++i) out.at[i] = make_vec3<T>(from + 3 * i);
    return out;
  }
  static void save(const Memory<double>& memory, double* to) noexcept {
    for (int i = 0; i + 1 < kRings; ++i) {
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
  static RingFooting<T, Spot> footing(const CurveViews& views, const Spot& spot,
                                      const Vec3<T>& x) noexcept {
    return footing_on(bed_under<T>(views, spot), spot, x);
  }
  /// On a bed that is at hand.
  template <class T, class Spot>
  static RingFooting<T, Spot> footing_on(const RingBed<T, kRings>& bed, const Spot& spot,
                                         const Vec3<T>& x) noexcept {
    const RingStance<T> at = ring_stance(spot, x);
    return {spot, deflection_of(at.depth_m, at.q), at, bed};
  }

  template <class T, class Spot>
  static bool is_slipping(const CurveViews&, const RingFooting<T, Spot>& foot) noexcept {
    const RingLimit<double> limit{value_of(foot.spot.control(kLambda, 0)),
                                  value_of(foot.spot.control(kFriction, 0)),
                                  value_of(foot.spot.control(kFrictionSlope, 0))};
    const double depth_m = value_of(foot.d.normal_m) > 0 ? value_of(foot.d.normal_m) : 0;
    return limit.lambda * value_of(foot.d.lateral_m) * (1 - kSlipTolerance) >
           limit.friction_at(depth_m) * depth_m;
  }

  template <class T, class Spot>
  static double settle(const CurveViews& views, const RingFooting<T, Spot>& foot,
                       Memory<T>& memory) noexcept {
    const double lost = settle_rings(views.rings, foot.bed, foot.at, memory);
    return 0.5 * lost * value_of(ring_share(views.rings, foot.bed, foot.at.depth_m).value);
  }

  /// (B2)
  template <class T, class Spot>
  static Vec3<T> force(const CurveViews& views, const RingFooting<T, Spot>& foot,
                       const Memory<T>& memory) noexcept {
    const T normal_N = curve_at(views, foot.spot, kNormal, foot.at.depth_m);
    if constexpr (IsUneven<Spot>::value) {
      RingBed<T, kRings> bed = foot.bed;
      const auto added = unevenness(foot.spot, bed, foot.at.depth_m, normal_N);
      return ring_force(views.rings, bed, foot.at, memory, foot.spot.normal,
                        normal_N + added.slope_N_m);
    } else {
      return ring_force(views.rings, foot.bed, foot.at, memory, foot.spot.normal, normal_N);
    }
  }

  /// (B1)
  template <class T, class Spot>
  static T energy_J(const CurveViews& views, const RingFooting<T, Spot>& foot,
                    const Memory<T>& memory) noexcept {
    const T normal_J = energy_at(views, foot.spot, kNormal, foot.at.depth_m);
    if constexpr (IsUneven<Spot>::value) {
      RingBed<T, kRings> bed = foot.bed;
      const auto added = unevenness(foot.spot, bed, foot.at.depth_m,
                                    curve_at(views, foot.spot, kNormal, foot.at.depth_m));
      return ring_energy_J(views.rings, bed, foot.at, memory, normal_J + added.value_N);
    } else {
      return ring_energy_J(views.rings, foot.bed, foot.at, memory, normal_J);
    }
  }

  /// Lets the contact point slide until ring 1 holds; the other rings settle before and after.
  /// Work: at most kMaxSegments segments, each with kMaxRootSteps + 2 excesses, which read no
  /// curve.
  template <class T, class Surface, class Spot>
  static SlideEnd slide(const CurveViews& views, const Vec3<T>& x, Surface& surface,
                        RingFooting<T, Spot>& foot, Memory<T>& memory) noexcept {
    surface.pay(settle(views, foot, memory));
    if (!is_slipping(views, foot)) return SlideEnd::stick;
    SlideEnd end = SlideEnd::unfinished;
    for (int segment = 0; segment < kMaxSegments && end == SlideEnd::unfinished; ++segment) {
      if (!is_slipping(views, foot)) return SlideEnd::slid;
      end = slide_segment(views, x, surface, foot, memory);
    }
    return end;
  }

 private:
  template <class T, class Surface, class Spot>
  static SlideEnd slide_segment(const CurveViews& views, const Vec3<T>& x, Surface& surface,
                                RingFooting<T, Spot>& foot, Memory<T>& memory) noexcept {
    const auto path = surface.aim(foot.spot, foot.d.lateral);
    const Vec3d tip = values_of(x);
    const double size_m = value_of(foot.d.lateral_m), path_end = value_of(path.end());
    const double end = path_end < size_m ? path_end : size_m;
    const auto& plain = path.plain();
    if (path.is_blocked()) return SlideEnd::stopped;
    const auto& way = way_of_excess(plain);
    const auto last = way.at(end);
    const Vec3d q_end = tangential(tip - last.point, last.normal);
    if (end > 0 && dot(q_end, q_end) > size_m * size_m) return SlideEnd::stopped;  // it would flee
    const double scale = value_of(foot.spot.control(kLambda, 0)) * size_m;
    const SlipRoot root = first_ring_root(way, tip, kInside * end, scale);
    const bool holds_within = root.s >= 0;
    const T s = holds_within        ? differentiable_ring_root(path, x, root)
                : path_end < size_m ? T(path.end())
                                    : foot.d.lateral_m;
    const Vec3<T> from = foot.spot.point;
    const Memory<double> held = values_of(memory);
    surface.begin([&]() noexcept { return value_of(energy_J(views, foot, memory)); });
    const Move move = surface.move(path, s, [&](const auto& there) noexcept {
      Memory<double> carried = held;
      carry_anchors(carried, there.point - values_of(from), there.normal);
      const auto stand = footing(views, there, tip);
      settle(views, stand, carried);
      return energy_J(views, stand, carried);
    });
    foot = footing(views, surface.standing(), x);
    carry_anchors(memory, foot.spot.point - from, foot.spot.normal);
    settle(views, foot, memory);  // its work is in the energies that the surface compared
    if (move == Move::stopped) return SlideEnd::stopped;
    return holds_within ? SlideEnd::slid : SlideEnd::unfinished;
  }
};

}  // namespace runtime
}  // namespace palpate
