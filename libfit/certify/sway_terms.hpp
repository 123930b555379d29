#pragma once

// What a slip changes on a body that sways as a whole (docs/method-certificate.md, section 19,
// docs/method-body.md, section 21).

#include "libfit/certify/slip_terms.hpp"

namespace palpate::certify {

/// A symmetric 3 x 3 matrix (xx, yy, zz, xy, xz, yz) times a vector.
template <class S, class T>
void times(const S* s, const T v[3], T out[3]) {
  out[0] = v[0] * s[0] + v[1] * s[3] + v[2] * s[4];
  out[1] = v[0] * s[3] + v[1] * s[1] + v[2] * s[5];
  out[2] = v[0] * s[4] + v[1] * s[5] + v[2] * s[2];
}

/// The force under which the body sways, over the depth: f^z along the normal, and bounds of what
/// there is beside it along the normal and across.
template <class T>
struct SwayForce {
  T normal;
  double along, across;
};

/// What the sway stores more, over the depth, as the contact point goes a unit step over the facet
/// towards (x, y): -1/2 f.(dC) f, with f anywhere in its bounds (M29a). Convex in (x, y).
template <class T>
double sway_stores(const Facet& e, const SurfaceTerms<T>& frame, const SwayForce<T>& force,
                   const T& d, double x, double y) {
  double change[6];
  for (int i = 0; i < 6; ++i) change[i] = e.sway_turn[0][i] * x + e.sway_turn[1][i] * y;
  T turned[3];
  times(change, frame.u, turned);
  const T along = turned[0] * frame.u[0] + turned[1] * frame.u[1] + turned[2] * frame.u[2];
  T squared = T(0);  // of the change's part between normal and tangents
  for (int k = 0; k < 3; ++k) {
    turned[k] = turned[k] - frame.u[k] * along;
    squared = squared + square(turned[k]);
  }
  const double whole = curvature_size(change), between = size(turned),
               across = std::sqrt(
                   not_negative(whole * whole - 2 * lower(squared) - lower(square(along)))),
               p = force.along, q = force.across;
  return upper(square(force.normal) * along * d * -0.5) +
         upper(d) * (upper(force.normal) * (p * size_of(along) + q * between) +
                     0.5 * p * p * size_of(along) + p * q * between + 0.5 * q * q * across);
}

/// What the sizes below are made of, at a place or over a patch and its depths.
struct UnevenSizes {
  double held;        ///< mu sum c_i h_i / d [N/m]: largest lateral force of the rings, over d
  double sigma;       ///< mu / lambda
  double reach_m;     ///< sigma d
  double height_m;    ///< h
  double kappa;       ///< of the curvature [1/m]
  double kappa_turn;  ///< of its change over the facet
  double side_slope;  ///< of g' [N/m]
};

/// Ring 1 is at its limit, but for what another C moves it.
template <class T>
SwayForce<T> sway_force(const Facet& e, const SurfaceTerms<T>& frame, const SideTerms<T>& side,
                        const BedTerms<T>& bed, const CurveTerms<T>& depth, const T& lambda,
                        const T& force, const UnevenSizes& of) {
  double change = 0;
  for (const auto& turn : e.sway_turn) change += curvature_size(turn);
  const double astray = e.overshoot_m / std::sqrt(frame.least) * change *
                        (size_of(force) + of.held),  // of its deflection, over the depth
      along = (of.sigma + astray) * of.side_slope;
  return {force, along,
          of.held + upper(lambda * bed.stiffness[0]) * astray + size(side.g) +
              (upper(force) + along) * (of.sigma + astray) * of.kappa * upper(depth.m)};
}

/// Sizes of what the energy of the law has beside springs, per metre by which |q| falls [N/m].
struct UnevenTerms {
  double spring;  ///< of ring 1 less what curvature and side force take from it
  double turns;   ///< B: how the force of the law changes where tool and contact point go together
  double others;  ///< how that of the other rings changes as the contact point goes on below them
  double bends;   ///< J: second derivatives of the energy where tool and contact point go together
};
template <class T>
UnevenTerms uneven_terms(const Facet& e, const SurfaceTerms<T>& frame, const SideTerms<T>& side,
                         const BedTerms<T>& bed, const CurveTerms<T>& depth, const T& lambda,
                         const T& force, const UnevenSizes& of) {
  const double step = 1 / std::sqrt(frame.least), turn = frame.turn_max, d = upper(depth.m),
               q_m = of.reach_m + e.overshoot_m, arm_m = of.height_m + q_m,
               normal_N = upper(force) * d, bent = 1 + of.kappa * q_m;
  const auto uneven = [&](const T change[2]) {
    return std::hypot(size_of(change[0]), size_of(change[1])) * step;
  };
  double stiff = 0, others = 2 * of.held * d * turn;
  for (int i = 0; i < kRings; ++i) {
    if (upper(bed.touching[i]) <= 0) continue;
    stiff += upper(bed.stiffness[i]);
    if (i > 0) others += uneven(bed.change[i]) * of.sigma * upper(bed.touching[i]) * d;
  }
  const double spring = upper(lambda * bed.stiffness[0]), uneven_spring = uneven(bed.change[0]),
               sinks = uneven(depth.force_slope) * d + stiff * q_m * turn,
               side_turn = (size(side.turn) * step + 2 * size(side.g) * turn) * d +
                           3 * of.side_slope * arm_m * turn;
  UnevenTerms out;
  out.spring = lower(lambda * bed.stiffness[0]) - normal_N * of.kappa * bent -
               2 * of.side_slope * (1 + of.kappa * arm_m);
  out.turns = sinks * bent +
              normal_N * (turn * (1 + of.kappa * arm_m) + 0.5 * of.kappa_turn * step * q_m) +
              uneven_spring * q_m + spring * turn * arm_m + side_turn;
  out.others = others;
  out.bends = turn * (2 * q_m * sinks + 4 * normal_N * turn * arm_m * (1 + of.kappa * arm_m) +
                      2 * uneven_spring * q_m * arm_m + spring * turn * arm_m * (arm_m + 4 * q_m) +
                      4 * arm_m * side_turn + 2 * turn * of.held * d * q_m);
  return out;
}

/// The largest compliance of a facet, or more: the trace of C at a corner.
inline double largest_give(const Facet& e) {
  double most = 0;
  for (int l = 0; l < 3; ++l) most = most_of(most, e.sway[0][l] + e.sway[1][l] + e.sway[2][l]);
  return most;
}

/// The sway settles while the contact point slips, so the law's tool goes on as well.
struct Settling {
  double share = 1;    ///< of what ring 1 pays more for a metre beyond its limit
  double least_N_m{};  ///< least second derivative of what is stored along a slip (M29b)
};
/// give_m_N: the largest compliance. Infinite where the contact would snap.
inline Settling settling(const UnevenTerms& of, double give_m_N) {
  Settling out;
  const double fold = 1 + 2 * give_m_N * of.spring;
  if (!(fold > 0)) return {0, -std::numeric_limits<double>::infinity()};
  out.share = 1 / (1 + 2 * give_m_N * not_negative(of.spring));
  out.least_N_m = (of.spring - 2 * of.turns - 2 * give_m_N * of.turns * of.turns) / fold -
                  2 * give_m_N * of.others * of.others - of.bends;
  return out;
}

}  // namespace palpate::certify
