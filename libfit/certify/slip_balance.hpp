#pragma once

// What a slip of the contact point of a bed of rings stores and pays, per metre, with the tool held
// (docs/method-certificate.md, section 19): one template for a place (double) and for a patch of a
// triangle over a range of depths (Interval).

#include "libfit/certify/sway_terms.hpp"

namespace palpate::certify {

constexpr double kMinStretch = 1e-3;  ///< of a ball's rest triangle: below it is a hollow

/// What rings 2 to N do while the contact point slips.
enum class OtherRings {
  any,     ///< anything that their limits allow: nothing of theirs pays
  sliding  ///< all slide with ring 1, as in gross slip
};

/// The worst direction of a place, or a bound over all directions of a patch. Terms are
/// per metre of slip and of depth [N/m] (M21).
struct Balance {
  double ratio = 0;     ///< what a slip stores over what it pays; <= 1: it dissipates
  int sector = 0;       ///< of the direction
  double friction = 0;  ///< mu(d)
  double paid = 0;      ///< by friction as it is
  double tilt = 0, mismatch = 0, turning = 0, rings = 0, sway = 0;  ///< what is stored, by cause
};

/// Whether the normal force stays a push and the stored energy positive (M22) as far as ring 1 may
/// be deflected. T: Interval, a bound; double, a place.
template <class T, class Where>
bool pushes(const Facet& e, const Where& where, const CurveTerms<T>& depth) {
  const T lambda = where.blend(e.lambda);
  if (!(lower(lambda) > 0)) return false;
  const BedTerms<T> bed = bed_at(e, where, lambda, depth.m);
  const T mu = not_negative(where.blend(e.friction_slope) * depth.m + where.blend(e.friction)) *
               limit_share(where, depth);
  double cut = 0;  // how the share of a bed that is cut may pull
  if (bed.sinks > 0) {
    const double furthest = upper(mu / lambda) + e.overshoot_m / lower(depth.m);
    cut = 0.5 * upper(lambda) * furthest * furthest * bed.spread * bed.sinks;
  }
  T g[3], slope[3];  // over d^2 and d
  for (int k = 0; k < 3; ++k) {
    const T two = where.blend(e.side2[k]), three = where.blend(e.side3[k]);
    g[k] = two + three * depth.m;
    slope[k] = two * 2.0 + three * 3.0 * depth.m;
  }
  const double reach_m = upper(mu / lambda) * upper(depth.m) + e.overshoot_m;
  // Rings that were spread farther than they would be now draw the tool in.
  const double draws = 2 * upper(where.blend(e.outward) * depth.m * mu * bed.others);
  return lower(where.blend(depth.force)) - cut - draws >= reach_m * size(slope) &&
         lower(where.blend(depth.energy)) >= reach_m * size(g);
}

/// What is the same in all directions of a slip at one depth (M21).
template <class T>
struct SlipTerms {
  const Facet& e;
  OtherRings others;
  T d, lambda, mu, sigma;
  T pressed, force;  ///< normal force over d, and with all that rings which are spread may add
  T pays, height;    ///< height: d + 1/2 q.kappa q
  double cut, all_slide_N_m;
  SurfaceTerms<T> frame;
  BedTerms<T> bed;
  SideTerms<T> side;
  T kappa_u[3]{};
  T omega[2]{}, tilt[2]{}, mismatch[2]{}, pull[2]{};  ///< of the first order in the way
  Symmetric<T> bent{}, Q{};                           ///< of the second
  Cubic<T> cubic{};
  /// Bounds by size of what is smaller still. steepest: by |q|, of the terms of third order;
  /// astray: how far the way of a segment may be from the deflection.
  double kappa_size{}, reach_m{}, slope_size{}, change_size{}, bend_rate{};
  double steepest{}, astray{}, noise{};
  /// Where the other rings may be spread as far as they may be deflected: the normal force of that,
  /// over the depth, and what it stores more, over that depth, where gamma grows by 1 / m a metre.
  double spread_N_m{}, spread_more_N{};
  SwayForce<T> swayed{};
  Settling settled{};
};

template <class T, class Where>
void add_orders(const Where& where, const CurveTerms<T>& depth, SlipTerms<T>& s) {
  const auto &u = s.frame.u, &U = s.frame.U, &L = s.frame.L;
  T kappa[6], kappa_L[3][2], kappa_U[3][2];
  double sizes[6];
  for (int i = 0; i < 6; ++i) sizes[i] = size_of(kappa[i] = where.blend(s.e.curvature[i]));
  s.kappa_size = curvature_size(sizes);
  times(kappa, L, kappa_L);
  times(kappa, U, kappa_U);
  s.kappa_u[0] = kappa[0] * u[0] + kappa[3] * u[1] + kappa[4] * u[2];
  s.kappa_u[1] = kappa[3] * u[0] + kappa[1] * u[1] + kappa[5] * u[2];
  s.kappa_u[2] = kappa[4] * u[0] + kappa[5] * u[1] + kappa[2] * u[2];
  s.height = s.d;
  if constexpr (std::is_same_v<T, Interval>) {
    const double bend = 0.5 * upper(s.sigma) * upper(s.sigma) * upper(s.d) * s.kappa_size;
    s.height = s.d * Interval(1 - bend, 1 + bend);
  }
  for (int j = 0; j < 2; ++j) {
    T follows = T(0), turns = T(0);
    s.pull[j] = T(0);
    for (int k = 0; k < 3; ++k) {
      follows = follows + L[k][j] * s.side.g[k];
      turns = turns + U[k][j] * s.side.g[k];
      s.pull[j] = s.pull[j] + L[k][j] * s.side.slope[k];
    }
    s.tilt[j] = s.pressed * u[j];
    s.mismatch[j] = follows - depth.energy_slope[j];
    s.omega[j] = s.tilt[j] + s.mismatch[j] + s.height * turns;
  }
  const auto LU = product(L, U);
  s.bent = LU + product(L, kappa_L) + product(L, kappa_U) * s.height;
  const Symmetric<T> pulled{s.pull[0] * u[0], (s.pull[0] * u[1] + s.pull[1] * u[0]) * 0.5,
                            s.pull[1] * u[1]};
  const auto uneven = LU * s.side.along + product(L, s.side.turn) * -1.0 + s.bent * (-s.force);
  s.Q = LU * (s.lambda * s.pays * s.height) + uneven * s.d + pulled;
  s.cubic = curvature_change(s.e, s.frame);
}

template <class T>
void add_bounds(const CurveTerms<T>& depth, SlipTerms<T>& s) {
  constexpr bool kIsBound = std::is_same_v<T, Interval>;
  const Facet& e = s.e;
  const SurfaceTerms<T>& frame = s.frame;
  const BedTerms<T>& bed = s.bed;
  s.reach_m = upper(s.sigma * s.d);
  s.slope_size = size(s.side.slope);
  s.change_size = 0;
  for (const auto& turn : e.curvature_turn) s.change_size += curvature_size(turn);
  s.bend_rate = size(s.kappa_u) * frame.turn_max + 0.5 * s.change_size / std::sqrt(frame.least);
  const double furthest_m = s.reach_m + e.overshoot_m;
  s.steepest = 2 * furthest_m *
                   (upper(s.force) * upper(s.d) * s.bend_rate +
                    s.slope_size *
                        (frame.turn_max + s.kappa_size * (1 + size_of(s.height) * frame.turn_max)) +
                    1.5 * furthest_m * s.slope_size * s.bend_rate +
                    0.5 * std::hypot(size_of(bed.change[0][0]), size_of(bed.change[0][1])) /
                        std::sqrt(frame.least)) +
               (bed.sinks > 0 ? furthest_m * upper(s.lambda) * bed.spread / lower(s.d) *
                                    (bed.sinks + bed.fades * upper(s.d) / std::sqrt(frame.least))
                              : 0);
  s.astray = kIsBound ? e.overshoot_m * frame.turn_max * (1 / lower(s.sigma) + 3) : 0;
  s.swayed = {s.force, 0, 0};
  if (e.sways) {  // its force, and how its sway settles in a slip
    const UnevenSizes sizes_of{upper(s.mu * (bed.stiffness[0] + bed.others)),
                               upper(s.sigma),
                               s.reach_m,
                               size_of(s.height),
                               s.kappa_size,
                               s.change_size,
                               s.slope_size};
    s.swayed = sway_force(e, frame, s.side, bed, depth, s.lambda, s.force, sizes_of);
    if constexpr (kIsBound)
      s.settled = settling(uneven_terms(e, frame, s.side, bed, depth, s.lambda, s.force, sizes_of),
                           largest_give(e));
  }
  s.noise = kRoundingSlack * (size_of(s.force) + size_of(depth.energy_slope[0]) +
                              size_of(depth.energy_slope[1]) + size_of(s.pays));
}

/// What is of one direction.
struct Spoke {
  double stores, sway, ring, bends, falls, pulls, stiffens, stretch_min, stretch_max, q;
};
template <class T>
Spoke spoke_at(const SlipTerms<T>& s, const Directions& way, int j) {
  Spoke at;
  const double x = way.x[1][j], y = way.y[1][j], x2 = way.x[2][j], y2 = way.y[2][j];
  at.sway = s.e.sways ? sway_stores(s.e, s.frame, s.swayed, s.d, x, y) : 0;
  at.stores = at.sway - lower(s.omega[0] * x + s.omega[1] * y) + s.cut * s.bed.fades * upper(s.d) +
              s.spread_N_m * size_of(s.frame.u[0] * x + s.frame.u[1] * y) +
              s.spread_more_N * std::abs(s.e.outward_turn[0] * x + s.e.outward_turn[1] * y);
  T turned[3];
  for (int k = 0; k < 3; ++k) turned[k] = s.frame.U[k][0] * x + s.frame.U[k][1] * y;
  // The other rings: as long as they may be, turned with the normal, over stiffer ground.
  at.ring = s.others == OtherRings::any ? size(turned) * upper(s.height * s.mu * s.bed.others) : 0;
  for (int i = 1; i < kRings; ++i) {
    const double limit = upper(s.sigma * s.bed.touching[i]),
                 rises = upper(s.bed.change[i][0] * x + s.bed.change[i][1] * y);
    if (!(rises <= 0)) at.ring += 0.5 * rises * limit * limit * upper(s.d);
  }
  at.stiffens = not_negative(upper(s.bed.change[0][0] * x + s.bed.change[0][1] * y));
  at.pulls = size_of(s.pull[0] * x + s.pull[1] * y);
  at.bends = size_of(form(s.bent, x2, y2));
  at.falls = not_negative(-lower(s.cubic.at(way, j)));
  const T stretch = form(s.frame.S, x2, y2);
  at.stretch_min = lower(stretch);
  at.stretch_max = upper(stretch);
  at.q = lower(form(s.Q, x2, y2));
  return at;
}

/// A sector between two directions, which are one at a place.
template <class T>
Balance balance_between(const SlipTerms<T>& s, const Spoke& a, const Spoke& b) {
  constexpr bool kIsBound = std::is_same_v<T, Interval>;
  constexpr double kNone = std::numeric_limits<double>::infinity();
  const double shortest = std::sqrt(most_of(least_of(a.stretch_min, b.stretch_min), s.frame.least)),
               longest = std::sqrt(most_of(a.stretch_max, b.stretch_max)),
               over = 1 / (shortest * shortest);
  const double friction = most_of(lower(s.mu * s.pays), s.all_slide_N_m) * shortest,
               ring = most_of(a.ring, b.ring);
  const double least_q = least_of(a.q, b.q);
  const double q = least_q / (least_q > 0 ? longest : shortest),
               turning = q * (q > 0 ? lower(s.sigma) : upper(s.sigma));
  const double third =
      upper(s.sigma) * s.reach_m *
      (upper(s.force) * upper(s.d) *
           (0.5 * most_of(a.falls, b.falls) * over + size(s.kappa_u) * s.frame.turn_max * longest) +
       most_of(a.pulls, b.pulls) * most_of(a.bends, b.bends) * over +
       s.reach_m * s.slope_size * s.bend_rate * longest + 0.5 * most_of(a.stiffens, b.stiffens));
  const double stray =
      s.astray *
      (upper(s.sigma) * (size_of(s.Q.xx) + size_of(s.Q.xy) + size_of(s.Q.yy)) / shortest + ring +
       0.5 * s.astray * friction);
  // Beyond its limit ring 1 pays more, or a little less.
  double rate = s.settled.share * lower(s.lambda * s.bed.stiffness[0] * s.bed.share) * shortest +
                (s.e.sways ? least_of(q, 0) : q) - s.steepest * longest;
  if (s.e.sways) rate = least_of(rate, 0.5 * s.settled.least_N_m * longest);
  const double beyond = kIsBound && !(rate >= 0) ? -rate * s.e.overshoot_m / lower(s.d) : 0;
  const double paid = friction + turning - ring - third - stray - beyond - s.noise,
               needed = most_of(a.stores, b.stores) + s.noise;
  Balance out;
  // Where one of them is no number, nothing is known to pay.
  out.ratio = paid > 0 && needed < kNone ? not_negative(needed) / paid : kNone;
  out.paid = friction;
  out.turning = -turning;
  out.rings = ring;
  out.sway = a.sway;
  return out;
}

/// What a slip stores over what it pays (M21), at the worst direction. Infinite where no friction
/// pays, where the bed is concave, and in a hollow that is too narrow for the ball.
template <class T, class Where>
Balance balance(const Facet& e, const Where& where, const CurveTerms<T>& depth, OtherRings others) {
  constexpr bool kIsBound = std::is_same_v<T, Interval>;
  constexpr double kNone = std::numeric_limits<double>::infinity();
  Balance worst;
  worst.ratio = kNone;
  const T d = depth.m;
  const SurfaceTerms<T> frame = frame_at<T>(e, where);
  const T lambda = where.blend(e.lambda);
  const T coefficient = not_negative(where.blend(e.friction_slope) * d + where.blend(e.friction));
  worst.friction = lower(coefficient);
  if (!(frame.least > kMinStretch && lower(lambda) > 0 && lower(coefficient) > 0)) return worst;
  const BedTerms<T> bed = bed_at(e, where, lambda, d);
  const T share = limit_share(where, depth), mu = coefficient * share;  // of the limits (B3a)
  if (!(lower(mu) > 0)) return worst;
  if (!(lower(bed.stiffness[0] * bed.share) > 0)) return worst;
  // Where the normal curve is concave, rings are cut and bear a share: by sizes, with all rings as
  // long as they may be, how that share presses and how it fades over the facet.
  const T sigma = mu / lambda;
  const double cut = 0.5 * upper(sigma * mu);
  T force = where.blend(depth.force);
  if constexpr (kIsBound) force = force + Interval(-cut * bed.sinks, cut * bed.sinks);
  // The other rings spread as far as they may be deflected; where all slide with ring 1 none is.
  const double borne = others == OtherRings::any ? upper(mu * bed.others * d) : 0,
               spread = 2 * borne * upper(where.blend(e.outward));
  T wide = force;
  if constexpr (kIsBound) wide = wide + Interval(-spread, spread);
  // All rings at such limits bear mu(d) f^z.
  const double all_slide_N_m = others == OtherRings::sliding && lower(where.blend(depth.bed)) > 0 &&
                                       upper(share) < runtime::kMaxLimitShare
                                   ? lower(coefficient * where.blend(depth.force))
                                   : 0;
  const T pays = bed.share *
                 (others == OtherRings::sliding ? bed.stiffness[0] + bed.others : bed.stiffness[0]);
  SlipTerms<T> s{e,     others,        d,     lambda, mu,
                 sigma, force,         wide,  pays,   d,
                 cut,   all_slide_N_m, frame, bed,    side_at(e, where, frame, d)};
  s.spread_N_m = spread;
  s.spread_more_N = borne * upper(d);
  add_orders(where, depth, s);
  add_bounds(depth, s);

  const Directions& way = directions(kIsBound);
  Spoke corner[kSectors + 1];
  for (int j = 0; j <= (kIsBound ? kSectors : kSectors - 1); ++j) corner[j] = spoke_at(s, way, j);
  worst.ratio = -kNone;
  for (int j = 0; j < kSectors; ++j) {
    Balance here = balance_between(s, corner[j], corner[kIsBound ? j + 1 : j]);
    if (here.ratio <= worst.ratio) continue;
    here.sector = j;
    here.friction = worst.friction;
    here.tilt = -lower(s.tilt[0] * way.x[1][j] + s.tilt[1] * way.y[1][j]);
    here.mismatch = -lower(s.mismatch[0] * way.x[1][j] + s.mismatch[1] * way.y[1][j]);
    worst = here;
  }
  return worst;
}

}  // namespace palpate::certify
