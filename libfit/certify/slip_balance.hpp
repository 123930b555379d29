#pragma once

// What a slip of the contact point of a bed of rings stores and pays, per metre, with the tool held
// (docs/method.md, section 19): one template for a place (double) and for a patch of a triangle
// over a range of depths (Interval).

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
  return lower(where.blend(depth.force)) - cut >= reach_m * size(slope) &&
         lower(where.blend(depth.energy)) >= reach_m * size(g);
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
  const SideTerms<T> side = side_at(e, where, frame, d);
  const auto& u = frame.u;
  const auto& U = frame.U;
  const auto& L = frame.L;
  const T sigma = mu / lambda;
  // Where the normal curve is concave, rings are cut and bear a share: by sizes, with all rings as
  // long as they may be, how that share presses and how it fades over the facet.
  const double cut = 0.5 * upper(sigma * mu);
  // All rings at such limits bear mu(d) f^z.
  const double all_slide_N_m = others == OtherRings::sliding && lower(where.blend(depth.bed)) > 0 &&
                                       upper(share) < runtime::kMaxLimitShare
                                   ? lower(coefficient * where.blend(depth.force))
                                   : 0;
  T force = where.blend(depth.force);
  if constexpr (kIsBound) force = force + Interval(-cut * bed.sinks, cut * bed.sinks);
  const T pays = bed.share *
                 (others == OtherRings::sliding ? bed.stiffness[0] + bed.others : bed.stiffness[0]);

  T kappa[6], kappa_L[3][2], kappa_U[3][2], kappa_u[3];
  double sizes[6];
  for (int i = 0; i < 6; ++i) sizes[i] = size_of(kappa[i] = where.blend(e.curvature[i]));
  const double kappa_size = curvature_size(sizes);
  times(kappa, L, kappa_L);
  times(kappa, U, kappa_U);
  kappa_u[0] = kappa[0] * u[0] + kappa[3] * u[1] + kappa[4] * u[2];
  kappa_u[1] = kappa[3] * u[0] + kappa[1] * u[1] + kappa[5] * u[2];
  kappa_u[2] = kappa[4] * u[0] + kappa[5] * u[1] + kappa[2] * u[2];
  T height = d;  // d + 1/2 q.kappa q
  if constexpr (kIsBound) {
    const double bend = 0.5 * upper(sigma) * upper(sigma) * upper(d) * kappa_size;
    height = d * Interval(1 - bend, 1 + bend);
  }

  // Of the first order in the way (omega), of the second (Q).
  T omega[2], tilt[2], mismatch[2], pull[2];
  for (int j = 0; j < 2; ++j) {
    T follows = T(0), turns = T(0);
    pull[j] = T(0);
    for (int k = 0; k < 3; ++k) {
      follows = follows + L[k][j] * side.g[k];
      turns = turns + U[k][j] * side.g[k];
      pull[j] = pull[j] + L[k][j] * side.slope[k];
    }
    tilt[j] = force * u[j];
    mismatch[j] = follows - depth.energy_slope[j];
    omega[j] = tilt[j] + mismatch[j] + height * turns;
  }
  const auto LU = product(L, U);
  const auto bent = LU + product(L, kappa_L) + product(L, kappa_U) * height;
  const Symmetric<T> pulled{pull[0] * u[0], (pull[0] * u[1] + pull[1] * u[0]) * 0.5,
                            pull[1] * u[1]};
  const auto uneven = LU * side.along + product(L, side.turn) * -1.0 + bent * (-force);
  const auto Q = LU * (lambda * pays * height) + uneven * d + pulled;
  const auto cubic = curvature_change(e, frame);

  // Bounds by size of what is smaller still.
  const double reach_m = upper(sigma * d), slope_size = size(side.slope);
  double change_size = 0;
  for (const auto& turn : e.curvature_turn) change_size += curvature_size(turn);
  const double bend_rate =
      size(kappa_u) * frame.turn_max + 0.5 * change_size / std::sqrt(frame.least);
  const double furthest_m = reach_m + e.overshoot_m;
  const double steepest =  // by |q|, of the terms of third order
      2 * furthest_m *
          (upper(force) * upper(d) * bend_rate +
           slope_size * (frame.turn_max + kappa_size * (1 + size_of(height) * frame.turn_max)) +
           1.5 * furthest_m * slope_size * bend_rate +
           0.5 * std::hypot(size_of(bed.change[0][0]), size_of(bed.change[0][1])) /
               std::sqrt(frame.least)) +
      (bed.sinks > 0 ? furthest_m * upper(lambda) * bed.spread / lower(d) *
                           (bed.sinks + bed.fades * upper(d) / std::sqrt(frame.least))
                     : 0);
  // How far the way of a segment may be astray from the deflection.
  const double astray = kIsBound ? e.overshoot_m * frame.turn_max * (1 / lower(sigma) + 3) : 0;
  // A body that sways: its force, and how its sway settles in a slip.
  SwayForce<T> swayed{force, 0, 0};
  Settling settled;
  if (e.sways) {
    const UnevenSizes sizes_of{upper(mu * (bed.stiffness[0] + bed.others)),
                               upper(sigma),
                               reach_m,
                               size_of(height),
                               kappa_size,
                               change_size,
                               slope_size};
    swayed = sway_force(e, frame, side, bed, depth, lambda, force, sizes_of);
    if constexpr (kIsBound)
      settled = settling(uneven_terms(e, frame, side, bed, depth, lambda, force, sizes_of),
                         largest_give(e));
  }
  const double noise = kRoundingSlack * (size_of(force) + size_of(depth.energy_slope[0]) +
                                         size_of(depth.energy_slope[1]) + size_of(pays));

  struct Spoke {
    double stores, sway, ring, bends, falls, pulls, stiffens, stretch_min, stretch_max, q;
  } corner[kSectors + 1];
  const Directions& way = directions(kIsBound);
  for (int j = 0; j <= (kIsBound ? kSectors : kSectors - 1); ++j) {
    Spoke& at = corner[j];
    const double x = way.x[1][j], y = way.y[1][j], x2 = way.x[2][j], y2 = way.y[2][j];
    at.sway = e.sways ? sway_stores(e, frame, swayed, d, x, y) : 0;
    at.stores = at.sway - lower(omega[0] * x + omega[1] * y) + cut * bed.fades * upper(d);
    T turned[3];
    for (int k = 0; k < 3; ++k) turned[k] = U[k][0] * x + U[k][1] * y;
    // The other rings: as long as they may be, turned with the normal, over stiffer ground.
    at.ring = others == OtherRings::any ? size(turned) * upper(height * mu * bed.others) : 0;
    for (int i = 1; i < kRings; ++i) {
      const double limit = upper(sigma * bed.touching[i]),
                   rises = upper(bed.change[i][0] * x + bed.change[i][1] * y);
      if (!(rises <= 0)) at.ring += 0.5 * rises * limit * limit * upper(d);
    }
    at.stiffens = not_negative(upper(bed.change[0][0] * x + bed.change[0][1] * y));
    at.pulls = size_of(pull[0] * x + pull[1] * y);
    at.bends = size_of(form(bent, x2, y2));
    at.falls = not_negative(-lower(cubic.at(way, j)));
    const T stretch = form(frame.S, x2, y2);
    at.stretch_min = lower(stretch);
    at.stretch_max = upper(stretch);
    at.q = lower(form(Q, x2, y2));
  }
  worst.ratio = -kNone;
  for (int j = 0; j < kSectors; ++j) {
    const Spoke &a = corner[j], &b = kIsBound ? corner[j + 1] : a;
    const double shortest = std::sqrt(most_of(least_of(a.stretch_min, b.stretch_min), frame.least)),
                 longest = std::sqrt(most_of(a.stretch_max, b.stretch_max)),
                 over = 1 / (shortest * shortest);
    const double friction = most_of(lower(mu * pays), all_slide_N_m) * shortest,
                 ring = most_of(a.ring, b.ring);
    const double least_q = least_of(a.q, b.q);
    const double q = least_q / (least_q > 0 ? longest : shortest),
                 turning = q * (q > 0 ? lower(sigma) : upper(sigma));
    const double third =
        upper(sigma) * reach_m *
        (upper(force) * upper(d) *
             (0.5 * most_of(a.falls, b.falls) * over + size(kappa_u) * frame.turn_max * longest) +
         most_of(a.pulls, b.pulls) * most_of(a.bends, b.bends) * over +
         reach_m * slope_size * bend_rate * longest + 0.5 * most_of(a.stiffens, b.stiffens));
    const double stray =
        astray * (upper(sigma) * (size_of(Q.xx) + size_of(Q.xy) + size_of(Q.yy)) / shortest + ring +
                  0.5 * astray * friction);
    // Beyond its limit ring 1 pays more, or a little less.
    double rate = settled.share * lower(lambda * bed.stiffness[0] * bed.share) * shortest +
                  (e.sways ? least_of(q, 0) : q) - steepest * longest;
    if (e.sways) rate = least_of(rate, 0.5 * settled.least_N_m * longest);
    const double beyond = kIsBound && !(rate >= 0) ? -rate * e.overshoot_m / lower(d) : 0;
    const double paid = friction + turning - ring - third - stray - beyond - noise,
                 needed = most_of(a.stores, b.stores) + noise;
    // Where one of them is no number, nothing is known to pay.
    const double ratio = paid > 0 && needed < kNone ? not_negative(needed) / paid : kNone;
    if (ratio <= worst.ratio) continue;
    worst.ratio = ratio;
    worst.sector = j;
    worst.paid = friction;
    worst.turning = -turning;
    worst.rings = ring;
    worst.sway = a.sway;
    worst.tilt = -lower(tilt[0] * way.x[1][j] + tilt[1] * way.y[1][j]);
    worst.mismatch = -lower(mismatch[0] * way.x[1][j] + mismatch[1] * way.y[1][j]);
  }
  return worst;
}

}  // namespace palpate::certify
