// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// The law of a bed of stick-slip rings (docs/method.md, B0 to B3): what a contact stores is
//
//     E = Z_c(d) + q.g_c(d) + 1/2 sum lambda c_i |q_i|^2
//
// over the tool's place alone, with the anchors of the rings as its memory. A ring is the part of
// the contact that touches from the depth d_i on; its stiffness is read off the press curve. Each
// holds until |q_i| = mu(d) (d - d_i) / lambda, then its anchor follows. Ring 1 is anchored at the
// contact point c itself and slips last: its slip is the slide of c over the surface.
//
// One template for the engine (scalar double, or Jet3 for the tangent) and the fitter (double or
// ceres::Jet). Forces are those of the tool ON the body. A Spot is as in slide.hpp and brings
// .number(k), the numbers of a node from kLambda on.

#include "../slide.hpp"

namespace palpate {
namespace runtime {

constexpr int kRings = 8;  ///< 4 are too few; 6 to 24 agree to 0.3 % of force

/// Numbers of a node beside its normal curve, in this order.
constexpr int kLambda = 0;         ///< lateral over normal stiffness of a ring [1]
constexpr int kFriction = 1;       ///< mu_0 [1]
constexpr int kFrictionSlope = 2;  ///< mu_1 [1/m]: a ball ploughs
constexpr int kSide = 3;           ///< g_2, xyz [N/m^2], then g_3, xyz [N/m^3]
constexpr int kCurvature = 9;      ///< kappa = -du/dc [1/m]: xx, yy, zz, xy, xz, yz
constexpr int kRingNumbers = 15;

/// Where the rings of a body touch, and how their stiffness follows from the control values of a
/// normal curve. Edges e_i = D (i/N)^1.5; thresholds are their middles, the first 0.
template <int N>
struct RingTable {
  int order = 0;
  double edge_m[N] = {}, threshold_m[N] = {};
  int first[N] = {};                     ///< first control value alive at edge i
  double slope[N][kMaxDegree + 1] = {};  ///< [1/m], of the basis at edge i
};

/// depth_m: D > 0, where the last ring ends.
template <int N>
RingTable<N> ring_table(const SplineView& normal, double depth_m) noexcept {
  RingTable<N> table;
  table.order = normal.degree + 1;
  for (int i = 0; i < N; ++i) {
    const double share = double(i + 1) / N, edge_m = depth_m * (share * std::sqrt(share));
    table.edge_m[i] = edge_m;
    table.threshold_m[i] = i == 0 ? 0 : 0.5 * (table.edge_m[i - 1] + edge_m);
    const SplineWeights<double> at = spline_weights(normal, find_piece(normal, edge_m), edge_m);
    table.first[i] = at.first;
    for (int k = 0; k < table.order; ++k) table.slope[i][k] = at.slope[k];
  }
  return table;
}

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
  return {spot.number(kLambda), spot.number(kFriction), spot.number(kFrictionSlope)};
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
  for (int i = 0; i < N; ++i) {
    T slope = spot.control(kNormal, table.first[i]) * table.slope[i][0];
    for (int k = 1; k < table.order; ++k)
      slope = slope + spot.control(kNormal, table.first[i] + k) * table.slope[i][k];
    const T stiffness = bed.limit.lambda * (slope - below);
    const bool is_cut = !(value_of(stiffness) >= 0);
    bed.stiffness_N_m[i] = is_cut ? T(0) : stiffness;
    bed.excess_N_m[i] = is_cut ? -stiffness : T(0);
    bed.is_cut = bed.is_cut || is_cut;
    below = slope;
  }
  const auto vector = [&](int k) noexcept {
    return tangential<T>({spot.number(k), spot.number(k + 1), spot.number(k + 2)}, spot.normal);
  };
  bed.side2 = vector(kSide);
  bed.side3 = vector(kSide + 3);
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
  const T xy = spot.number(kCurvature + 3), xz = spot.number(kCurvature + 4),
          yz = spot.number(kCurvature + 5);
  const Vec3<T> bent{spot.number(kCurvature) * q.x + xy * q.y + xz * q.z,
                     xy * q.x + spot.number(kCurvature + 1) * q.y + yz * q.z,
                     xz * q.x + yz * q.y + spot.number(kCurvature + 2) * q.z};
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

/// Where a flat, even body brings the contact point: the deflection that ring 1 keeps, in closed
/// form. Elsewhere the start of the search along the surface.
template <class T>
T flat_slip_m(const RingLimit<T>& limit, const RingStance<T>& at) noexcept {
  using std::sqrt;
  const T size = sqrt(dot(at.q, at.q));
  return size - limit.friction_at(at.depth_m) * at.depth_m / limit.lambda;
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
  return {1.0 - ratio, (ratio * kept_slope - cut_slope) / kept};
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
/// the tick. Returns whether any anchor moved.
template <class T, int N>
bool settle_rings(const RingTable<N>& table, const RingLimit<T>& limit, const RingStance<T>& at,
                  RingAnchors<T, N>& anchors) noexcept {
  using std::sqrt;
  const T mu = limit.friction_at(at.depth_m);
  bool has_moved = false;
  for (int i = 1; i < N; ++i) {
    Vec3<T>& a = anchors.at[i - 1];
    const T reach = at.depth_m - table.threshold_m[i];
    if (!(value_of(reach) > 0)) {
      for (int j = i; j < N; ++j) anchors.at[j - 1] = at.q;
      return true;
    }
    const Vec3<T> q = at.q - a;
    const T squared = limit.lambda * limit.lambda * dot(q, q), most = mu * reach;
    if (!(value_of(squared) > value_of(most) * value_of(most))) continue;
    a = at.q - q * (most / sqrt(squared));
    has_moved = true;
  }
  return has_moved;
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

/// Lets the contact point slide until ring 1 holds, then the other rings slip: slide() of slide.hpp
/// with (B3). Work: at most kMaxSegments segments, each with kMaxRootSteps + 2 excesses.
template <class T, int N, class Surface>
SlideEnd slide_rings(const RingTable<N>& table, const Vec3<T>& x, Surface& surface,
                     RingAnchors<T, N>& anchors) noexcept {
  using std::sqrt;
  SlideEnd end_is = SlideEnd::unfinished;
  auto spot = surface.standing();
  RingStance<T> at = ring_stance(spot, x);
  for (int segment = 0; segment < kMaxSegments; ++segment) {
    const T squared = dot(at.q, at.q);
    const RingLimit<T> limit = ring_limit<T>(spot);
    end_is = segment == 0 ? SlideEnd::stick : SlideEnd::slid;
    if (!(value_of(squared) > kLateralZero_m * kLateralZero_m)) break;
    const T size = sqrt(squared);
    const double size_m = value_of(size), scale = value_of(limit.lambda) * size_m;
    const double depth_m = value_of(at.depth_m) > 0 ? value_of(at.depth_m) : 0;
    if (!(scale * (1 - kSlipTolerance) > value_of(limit.friction_at(at.depth_m)) * depth_m)) break;
    const auto path = surface.aim(spot, at.q * (1.0 / size));
    const double path_end = value_of(path.end()), end = path_end < size_m ? path_end : size_m;
    const auto& plain = path.plain();
    end_is = SlideEnd::stopped;
    if (path.is_blocked()) break;
    const Vec3d q_end = ring_stance(plain.at(end), values_of(x)).q;
    if (end > 0 && dot(q_end, q_end) > size_m * size_m) break;  // it would flee
    const SlipRoot root = first_ring_root(plain, values_of(x), kInside * end, scale);
    const bool holds_within = root.s >= 0;
    const T s = holds_within        ? differentiable_ring_root(path, x, root)
                : path_end < size_m ? T(path.end())
                                    : size;
    const Move move = surface.move(path, s, x);
    const Vec3<T> before = spot.point;
    spot = surface.standing();
    at = ring_stance(spot, x);
    carry_anchors(anchors, spot.point - before, spot.normal);
    if (move == Move::stopped) break;
    end_is = holds_within ? SlideEnd::slid : SlideEnd::unfinished;
    if (holds_within) break;
  }
  settle_rings(table, ring_limit<T>(spot), at, anchors);
  return end_is;
}

}  // namespace runtime
}  // namespace palpate
