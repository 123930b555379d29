#pragma once

// What a slip of the contact point of a bed of rings stores and pays, per metre, with the tool held
// (docs/method.md, section 19): one template for a place (double) and for a patch of a triangle
// over a range of depths (Interval).

#include <array>

#include "libfit/certify/interval.hpp"
#include "libfit/runtime/engine.hpp"

namespace palpate::certify {

constexpr int kRings = runtime::kRings;

/// What rings 2 to N do while the contact point slips.
enum class OtherRings {
  any,     ///< anything that their limits allow: nothing of theirs pays
  sliding  ///< all slide with ring 1, as in gross slip
};

/// A triangle of a body of rings in a frame of its own: x and y in the facet, z along its inward
/// normal. Vectors are [component][corner].
struct Element {
  double gradient[3][2];            ///< of the area coordinates [1/m]
  double normal[3][3], turn[3][2];  ///< u_l, and the gradient of their blend
  double lambda[3], friction[3], friction_slope[3], stiffness[kRings][3];
  double side2[3][3], side3[3][3], side2_turn[3][2], side3_turn[3][2];
  double curvature[6][3], curvature_turn[2][6];  ///< and its gradient [1/m^2]
  double threshold[kRings];
  double radius_m = 0;             ///< of the ball that slides; 0: a tip
  double overshoot_m = 0;          ///< how far beyond its limit ring 1 may be at a tick
  runtime::Vec3d origin, axis[3];  ///< of the frame, in the asset's
};

/// A place of a triangle, and a patch: the triangle between three places.
struct Place {
  double n[3];
  template <class T>
  T blend(const T* v) const {
    return v[0] * n[0] + v[1] * n[1] + v[2] * n[2];
  }
};
struct Patch {
  Place corner[3];
  template <class T>
  Interval blend(const T* v) const {
    return hull(hull(Interval(corner[0].blend(v)), Interval(corner[1].blend(v))),
                Interval(corner[2].blend(v)));
  }
};

/// What the normal curves of the corners say at a depth or over a range of depths, all over it.
template <class T>
struct Depth {
  T m;                ///< d
  T force[3];         ///< f^z / d [N/m]
  T energy_slope[2];  ///< of the blended Z over the facet, / d [N/m]
  T energy[3];        ///< Z / d^2 [N/m]
};

constexpr int kSectors = 24;          ///< of directions
constexpr double kMinStretch = 1e-3;  ///< of a ball's rest triangle: below it is a hollow

/// A bound over directions t of the facet, by sectors; terms / d [N/m] (M21).
struct Balance {
  double ratio = 0;  ///< what a slip stores over what it pays; <= 1: it dissipates
  int sector = 0;    ///< where
  double paid = 0;   ///< there [N/m], at friction as it is
  double tilt = 0, mismatch = 0, turning = 0, rings = 0;  ///< what is stored there, by cause
  double friction = 0;                                    ///< mu there
};

namespace detail {

template <class T>
struct Symmetric {
  T xx, xy, yy;
};
template <class T>
Symmetric<T> operator+(const Symmetric<T>& a, const Symmetric<T>& b) {
  return {a.xx + b.xx, a.xy + b.xy, a.yy + b.yy};
}
template <class T>
Symmetric<T> operator*(const Symmetric<T>& a, const T& s) {
  return {a.xx * s, a.xy * s, a.yy * s};
}
/// sym(A^T B) of 3 x 2 matrices.
template <class T>
Symmetric<T> product(const T a[3][2], const T b[3][2]) {
  Symmetric<T> out{T(0), T(0), T(0)};
  for (int k = 0; k < 3; ++k) {
    out.xx = out.xx + a[k][0] * b[k][0];
    out.xy = out.xy + (a[k][0] * b[k][1] + a[k][1] * b[k][0]) * T(0.5);
    out.yy = out.yy + a[k][1] * b[k][1];
  }
  return out;
}
template <class T>
void times_symmetric(const T* s, const T a[3][2], T out[3][2]) {
  for (int j = 0; j < 2; ++j) {
    out[0][j] = s[0] * a[0][j] + s[3] * a[1][j] + s[4] * a[2][j];
    out[1][j] = s[3] * a[0][j] + s[1] * a[1][j] + s[5] * a[2][j];
    out[2][j] = s[4] * a[0][j] + s[5] * a[1][j] + s[2] * a[2][j];
  }
}
template <class T>
double size(const T a[3][2]) {
  double squared = 0;
  for (int k = 0; k < 3; ++k)
    for (int j = 0; j < 2; ++j) squared += size_of(a[k][j]) * size_of(a[k][j]);
  return std::sqrt(squared);
}

/// Unit vectors whose polygon holds the arcs between them.
struct Directions {
  double x[kSectors + 1], y[kSectors + 1], x2[kSectors + 1], y2[kSectors + 1], x3[kSectors + 1],
      y3[kSectors + 1];
  explicit Directions(bool is_around) {
    const double step = 2 * 3.14159265358979323846 / kSectors;
    const double out = is_around ? 1 / std::cos(step / 2) : 1,
                 out2 = is_around ? 1 / std::cos(step) : 1,
                 out3 = is_around ? 1 / std::cos(1.5 * step) : 1;
    for (int j = 0; j <= kSectors; ++j) {
      const double angle = step * j;
      x[j] = out * std::cos(angle);
      y[j] = out * std::sin(angle);
      x2[j] = out2 * std::cos(2 * angle);
      y2[j] = out2 * std::sin(2 * angle);
      x3[j] = out3 * std::cos(3 * angle);
      y3[j] = out3 * std::sin(3 * angle);
    }
  }
};
inline const Directions& directions(bool is_around) {
  static const Directions kOn(false), kAround(true);
  return is_around ? kAround : kOn;
}
template <class T>
T form(const Symmetric<T>& q, double cos2, double sin2) {
  return (q.xx + q.yy) * T(0.5) + (q.xx - q.yy) * T(0.5 * cos2) + q.xy * T(sin2);
}

}  // namespace detail

/// Whether the normal force stays a push and the stored energy positive (M22), as far as a ring may
/// be deflected: f^z - |q| |g'| >= 0 and Z - |q| |g| >= 0. T: Interval, a bound; double, a place.
template <class T, class Where>
bool pushes(const Element& e, const Where& where, const Depth<T>& depth) {
  const T lambda = where.blend(e.lambda),
          mu =
              not_negative(T(where.blend(e.friction)) + T(where.blend(e.friction_slope)) * depth.m);
  if (!(lower(lambda) > 0)) return false;
  double g = 0, slope = 0;
  for (int k = 0; k < 3; ++k) {
    const T two = where.blend(e.side2[k]), three = where.blend(e.side3[k]);
    const double at = size_of(two + three * depth.m),
                 rate = size_of(two * T(2) + three * T(3) * depth.m);
    g += at * at;
    slope += rate * rate;
  }
  const double reach_m = upper(mu / lambda) * upper(depth.m) + e.overshoot_m;
  return lower(where.blend(depth.force)) >= reach_m * std::sqrt(slope) &&
         lower(where.blend(depth.energy)) >= reach_m * std::sqrt(g);
}

/// What a slip stores over what it pays, at the worst direction (M21).
template <class T, class Where>
Balance balance(const Element& e, const Where& where, const Depth<T>& depth, OtherRings others) {
  using std::sqrt;
  constexpr bool kIsBound = std::is_same_v<T, Interval>;
  constexpr double kNone = std::numeric_limits<double>::infinity();
  const T d = depth.m, R = T(e.radius_m);

  // The normal, how it turns (U), and how the lateral deflection follows the facet (L).
  T u[3], squared = T(0);
  for (int k = 0; k < 3; ++k) {
    u[k] = where.blend(e.normal[k]);
    squared = squared + square(u[k]);
  }
  const T inverse = T(1) / sqrt(squared);
  for (T& x : u) x = x * inverse;
  T U[3][2], L[3][2];
  for (int j = 0; j < 2; ++j) {
    const T along = u[0] * T(e.turn[0][j]) + u[1] * T(e.turn[1][j]) + u[2] * T(e.turn[2][j]);
    for (int k = 0; k < 3; ++k) {
      U[k][j] = (T(e.turn[k][j]) - u[k] * along) * inverse;
      L[k][j] = T(k == j ? 1 : 0) - u[k] * u[j] - R * U[k][j];
    }
  }
  const auto S = detail::product(L, L), LU = detail::product(L, U);
  const double middle = 0.5 * (lower(S.xx) + lower(S.yy)),
               spread = 0.5 * std::max(size_of(S.xx - S.yy), 0.0), off = size_of(S.xy);
  const double least = middle - std::sqrt(spread * spread + off * off);
  Balance worst;
  worst.ratio = kNone;
  if (!(least > kMinStretch)) return worst;
  const double longest = 1 / std::sqrt(least);  // of t

  const T lambda = where.blend(e.lambda);
  const T mu = not_negative(T(where.blend(e.friction)) + T(where.blend(e.friction_slope)) * d);
  worst.friction = lower(mu);
  if (!(lower(lambda) > 0 && lower(mu) > 0)) return worst;
  const T sigma = mu / lambda;  // lateral deflection over depth

  T kappa[6], kL[3][2], kU[3][2];
  double kappa_squared = 0;
  for (int i = 0; i < 6; ++i) {
    kappa[i] = where.blend(e.curvature[i]);
    kappa_squared += (i < 3 ? 1 : 2) * size_of(kappa[i]) * size_of(kappa[i]);
  }
  const double kappa_size = std::sqrt(kappa_squared);
  detail::times_symmetric(kappa, L, kL);
  detail::times_symmetric(kappa, U, kU);

  // The side force over depth, its gradient, its slope.
  T raw[3], g[3], slope[3], G[3][2], along = T(0), slope_along = T(0);
  for (int k = 0; k < 3; ++k) {
    const T two = where.blend(e.side2[k]), three = where.blend(e.side3[k]);
    raw[k] = (two + three * d) * d;
    slope[k] = (two * T(2) + three * T(3) * d) * d;
    for (int j = 0; j < 2; ++j) G[k][j] = (T(e.side2_turn[k][j]) + T(e.side3_turn[k][j]) * d) * d;
    along = along + raw[k] * u[k];
    slope_along = slope_along + slope[k] * u[k];
  }
  double slope_size = 0;
  for (int k = 0; k < 3; ++k) {
    g[k] = raw[k] - u[k] * along;
    slope[k] = slope[k] - u[k] * slope_along;
    slope_size += size_of(slope[k]) * size_of(slope[k]);
  }
  slope_size = std::sqrt(slope_size);

  const T force = where.blend(depth.force);
  T height = d;  // d + 1/2 q.kappa q
  if constexpr (kIsBound) {
    const double bend = 0.5 * upper(sigma) * upper(sigma) * upper(d) * kappa_size;
    height = d * Interval(1 - bend, 1 + bend);
  }

  // Rings.
  T stiffness[kRings], touching[kRings];  // c_i, and h_i / d
  T sliding = where.blend(e.stiffness[0]), others_bear = T(0);
  stiffness[0] = sliding;
  touching[0] = T(1);
  for (int i = 1; i < kRings; ++i) {
    stiffness[i] = where.blend(e.stiffness[i]);
    touching[i] = T(0);
    const double from_m = e.threshold[i] - (kIsBound ? 0.5 * e.overshoot_m : 0);
    if (!(upper(d) > from_m)) continue;
    if constexpr (kIsBound)  // a slip may end deeper than it began
      touching[i] =
          Interval(d.lo > 0 ? not_negative(1 - e.threshold[i] / d.lo) : 0, 1 - from_m / d.hi);
    else
      touching[i] = not_negative(1 - from_m / d);
    others_bear = others_bear + stiffness[i] * touching[i];
  }
  if (others == OtherRings::sliding) sliding = sliding + others_bear;
  for (const T& c : stiffness)
    if (!(lower(c) >= 0)) return worst;  // concave curves

  // First order in the lateral deflection: omega; second: Q.
  T omega[2], tilt[2], mismatch[2];
  for (int j = 0; j < 2; ++j) {
    T follows = T(0), turns = T(0);
    for (int k = 0; k < 3; ++k) {
      follows = follows + L[k][j] * g[k];
      turns = turns + U[k][j] * g[k];
    }
    tilt[j] = force * u[j];
    mismatch[j] = follows - depth.energy_slope[j];
    omega[j] = tilt[j] + mismatch[j] + height * turns;
  }
  const T along_side[3][2] = {{u[0], u[1]}, {T(0), T(0)}, {T(0), T(0)}};
  T pulled[3][2] = {{T(0), T(0)}, {T(0), T(0)}, {T(0), T(0)}};
  for (int j = 0; j < 2; ++j)
    for (int k = 0; k < 3; ++k) pulled[0][j] = pulled[0][j] + L[k][j] * slope[k];
  const auto bent = LU + detail::product(L, kL) + detail::product(L, kU) * height;
  const auto uneven = LU * along + detail::product(L, G) * T(-1) + bent * (T(0) - force);
  const auto Q =
      LU * (lambda * sliding * height) + uneven * d + detail::product(along_side, pulled);

  // Changes of ring stiffness over the facet.
  T change[kRings][2];
  for (int i = 0; i < kRings; ++i)
    for (int j = 0; j < 2; ++j) {
      T of_c = T(0), of_lambda = T(0);
      for (int l = 0; l < 3; ++l) {
        of_c = of_c + T(e.stiffness[i][l] * e.gradient[l][j]);
        of_lambda = of_lambda + T(e.lambda[l] * e.gradient[l][j]);
      }
      change[i][j] = of_c * lambda + of_lambda * stiffness[i];
    }

  // Third order: along the way kappa changes, c(t) = sum t_j t.A_j t, which is of cos and sin of
  // one and of three angles.
  T one[2], three[2];
  {
    detail::Symmetric<T> A[2];
    for (int j = 0; j < 2; ++j) {
      T change_of[6], changed[3][2];
      for (int i = 0; i < 6; ++i) change_of[i] = T(e.curvature_turn[j][i]);
      detail::times_symmetric(change_of, L, changed);
      A[j] = detail::product(L, changed);
    }
    one[0] = (A[0].xx * T(3) + A[0].yy + A[1].xy * T(2)) * T(0.25);
    one[1] = (A[1].yy * T(3) + A[1].xx + A[0].xy * T(2)) * T(0.25);
    three[0] = (A[0].xx - A[0].yy - A[1].xy * T(2)) * T(0.25);
    three[1] = (A[0].xy * T(2) + A[1].xx - A[1].yy) * T(0.25);
  }
  T pull[2];
  for (int j = 0; j < 2; ++j) pull[j] = pulled[0][j];
  double kappa_normal = 0, change_size = 0;
  for (int k = 0; k < 3; ++k) {
    const int row[3][3] = {{0, 3, 4}, {3, 1, 5}, {4, 5, 2}};
    const double part = size_of(kappa[row[k][0]] * u[0] + kappa[row[k][1]] * u[1] +
                                kappa[row[k][2]] * u[2]);
    kappa_normal += part * part;
  }
  kappa_normal = std::sqrt(kappa_normal);
  for (int j = 0; j < 2; ++j)
    for (int i = 0; i < 6; ++i)
      change_size += (i < 3 ? 1 : 2) * e.curvature_turn[j][i] * e.curvature_turn[j][i];
  const double turn_size = detail::size(U) * longest;
  const double bend_rate = kappa_normal * turn_size + 0.5 * std::sqrt(change_size) * longest;
  const double swing = turn_size + kappa_size * (1 + size_of(height) * turn_size);
  const double first_change = std::hypot(size_of(change[0][0]), size_of(change[0][1])) * longest;
  const double reach_m = upper(sigma * d), furthest_m = reach_m + e.overshoot_m;
  // Slope of these by |q|, at most.
  const double steepest =
      2 * furthest_m *
      (upper(force) * upper(d) * bend_rate + slope_size * swing +
       1.5 * furthest_m * slope_size * bend_rate + 0.5 * first_change);
  // How far a segment's direction may be from that of the deflection.
  const double astray = kIsBound ? e.overshoot_m * turn_size * (1 / lower(sigma) + 3) : 0;

  const auto& way = detail::directions(kIsBound);
  double stores[kSectors + 1], ring_loss[kSectors + 1];
  for (int j = 0; j <= kSectors; ++j) {
    const T x = T(way.x[j]), y = T(way.y[j]);
    stores[j] = -lower(omega[0] * x + omega[1] * y);
    double turned = 0;
    for (int k = 0; k < 3; ++k) {
      const double rate = size_of(U[k][0] * x + U[k][1] * y);
      turned += rate * rate;
    }
    // (B3) of the others: as long as they may be, turned with the normal, on stiffer ground.
    ring_loss[j] =
        others == OtherRings::any ? std::sqrt(turned) * upper(height * mu * others_bear) : 0;
    for (int i = 1; i < kRings; ++i) {
      const double rises = upper(change[i][0] * x + change[i][1] * y),
                   limit = upper(sigma * touching[i]);
      if (rises > 0) ring_loss[j] += 0.5 * rises * limit * limit * upper(d);
    }
  }
  const double noise = kRoundingSlack * (size_of(force) + size_of(depth.energy_slope[0]) +
                                         size_of(depth.energy_slope[1]) + size_of(sliding));
  worst.ratio = -kNone;
  for (int j = 0; j < kSectors; ++j) {
    const int next = kIsBound ? j + 1 : j;
    const T s = T(std::min(lower(detail::form(S, way.x2[j], way.y2[j])),
                           lower(detail::form(S, way.x2[next], way.y2[next])))),
            s_most = T(std::max(upper(detail::form(S, way.x2[j], way.y2[j])),
                                upper(detail::form(S, way.x2[next], way.y2[next]))));
    const double shortest = std::sqrt(std::max(lower(s), least)), most = std::sqrt(upper(s_most));
    const double q = std::min(lower(detail::form(Q, way.x2[j], way.y2[j])),
                              lower(detail::form(Q, way.x2[next], way.y2[next])));
    const double bent_q = q / (q > 0 ? most : shortest);
    const double friction = lower(mu * sliding) * shortest;
    const double ring = std::max(ring_loss[j], ring_loss[next]);
    const double stray =
        astray *
            (upper(sigma) * (size_of(Q.xx) + size_of(Q.xy) + size_of(Q.yy)) / shortest + ring) +
        0.5 * astray * astray * friction;
    const double turning = bent_q * (bent_q > 0 ? lower(sigma) : upper(sigma));
    double falls = 0, pulls = 0, stiffens = 0, bends = 0;
    for (const int k : {j, next}) {
      const T x = T(way.x[k]), y = T(way.y[k]);
      const double by_one = lower(one[0] * x + one[1] * y);
      falls = std::max(falls, -by_one - lower(three[0] * T(way.x3[k]) + three[1] * T(way.y3[k])));
      pulls = std::max(pulls, size_of(pull[0] * x + pull[1] * y));
      stiffens = std::max(stiffens, upper(change[0][0] * x + change[0][1] * y));
      bends = std::max(bends, size_of(detail::form(bent, way.x2[k], way.y2[k])));
    }
    const double squared_m = upper(sigma) * reach_m;  // |q|^2 / d
    const double third =
        squared_m * (upper(force) * upper(d) *
                         (0.5 * falls / (shortest * shortest) + kappa_normal * turn_size * most) +
                     pulls * bends / (shortest * shortest) +
                     reach_m * slope_size * bend_rate * most + 0.5 * stiffens);
    // Beyond its limit ring 1 pays more, or a little less.
    const double rate = lower(lambda * stiffness[0]) * shortest + bent_q - steepest * most;
    const double beyond = kIsBound && rate < 0 ? -rate * e.overshoot_m / lower(d) : 0;
    const double paid =
        friction + turning - ring - third - stray - beyond - noise;
    const double needed = std::max(stores[j], stores[next]) + (kIsBound ? noise : 0);
    const double ratio = paid > 0 ? std::max(needed, 0.0) / paid : kNone;
#ifdef SHOW
    if (kIsBound && j==0) std::printf("friction %.3g turning %.3g ring %.3g third %.3g stray %.3g beyond %.3g noise %.3g needed %.3g\n", friction,turning,ring,third,stray,beyond,noise,needed);
#endif
    if (!(ratio > worst.ratio)) continue;
    worst.ratio = ratio;
    worst.sector = j;
    worst.paid = friction;
    worst.turning = -turning;
    worst.rings = ring;
    worst.tilt = -lower(tilt[0] * T(way.x[j]) + tilt[1] * T(way.y[j]));
    worst.mismatch = -lower(mismatch[0] * T(way.x[j]) + mismatch[1] * T(way.y[j]));
  }
  return worst;
}

}  // namespace palpate::certify
