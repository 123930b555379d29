#pragma once

// What a slip changes at a place of a triangle, or over a patch of it (docs/method-certificate.md,
// section 19).

#include <algorithm>

#include "libfit/certify/facet.hpp"

namespace palpate::certify {

constexpr int kSectors = 48;    ///< of directions
constexpr int kSlopeTurns = 3;  ///< of limit_share(): each squares what is left of its width

template <class T>
struct Symmetric {
  T xx, xy, yy;
};
template <class T>
Symmetric<T> operator+(const Symmetric<T>& a, const Symmetric<T>& b) {
  return {a.xx + b.xx, a.xy + b.xy, a.yy + b.yy};
}
template <class T, class S>
Symmetric<T> operator*(const Symmetric<T>& a, const S& s) {
  return {a.xx * s, a.xy * s, a.yy * s};
}
/// sym(A^T B) of 3 x 2 matrices.
template <class T>
Symmetric<T> product(const T a[3][2], const T b[3][2]) {
  Symmetric<T> out{T(0), T(0), T(0)};
  for (int k = 0; k < 3; ++k) {
    out.xx = out.xx + a[k][0] * b[k][0];
    out.xy = out.xy + (a[k][0] * b[k][1] + a[k][1] * b[k][0]) * 0.5;
    out.yy = out.yy + a[k][1] * b[k][1];
  }
  return out;
}
/// A symmetric 3 x 3 matrix (xx, yy, zz, xy, xz, yz) times a 3 x 2 matrix.
template <class S, class T>
void times(const S* s, const T a[3][2], T out[3][2]) {
  for (int j = 0; j < 2; ++j) {
    out[0][j] = a[0][j] * s[0] + a[1][j] * s[3] + a[2][j] * s[4];
    out[1][j] = a[0][j] * s[3] + a[1][j] * s[1] + a[2][j] * s[5];
    out[2][j] = a[0][j] * s[4] + a[1][j] * s[5] + a[2][j] * s[2];
  }
}
template <class T>
double size(const T a[3][2]) {
  double squared = 0;
  for (int k = 0; k < 3; ++k)
    for (int j = 0; j < 2; ++j) squared += size_of(a[k][j]) * size_of(a[k][j]);
  return std::sqrt(squared);
}
template <class T>
double size(const T a[3]) {
  return std::sqrt(size_of(a[0]) * size_of(a[0]) + size_of(a[1]) * size_of(a[1]) +
                   size_of(a[2]) * size_of(a[2]));
}
inline double curvature_size(const double* k) {
  return std::sqrt(k[0] * k[0] + k[1] * k[1] + k[2] * k[2] +
                   2 * (k[3] * k[3] + k[4] * k[4] + k[5] * k[5]));
}

/// Cosine and sine of a direction's angle, of twice and of three times it. A linear function of
/// such a pair over an arc is at most its larger value at two corners of the polygon around the
/// circle, so a bound reads the corners and a place the directions themselves.
struct Directions {
  double x[4][kSectors + 1], y[4][kSectors + 1];
  explicit Directions(bool is_around) {
    const double step = 2 * 3.14159265358979323846 / kSectors;
    for (int times = 1; times <= 3; ++times)
      for (int j = 0; j <= kSectors; ++j) {
        const double out = is_around ? 1 / std::cos(0.5 * times * step) : 1;
        x[times][j] = out * std::cos(times * step * j);
        y[times][j] = out * std::sin(times * step * j);
      }
  }
};
inline const Directions& directions(bool is_around) {
  static const Directions kOn(false), kAround(true);
  return is_around ? kAround : kOn;
}
/// t.q t of the direction whose double angle has this cosine and sine.
template <class T>
T form(const Symmetric<T>& q, double cos2, double sin2) {
  return (q.xx + q.yy) * 0.5 + (q.xx - q.yy) * (0.5 * cos2) + q.xy * sin2;
}

/// The normal u, how it turns by a step over the facet (U), how the lateral deflection falls (L).
template <class T>
struct SurfaceTerms {
  T u[3], U[3][2], L[3][2];
  Symmetric<T> S;   ///< L^T L: |L t|^2
  double least;     ///< of t.S t over |t|^2
  double turn_max;  ///< of |U t| over |L t|
};
template <class T, class Where>
SurfaceTerms<T> frame_at(const Facet& e, const Where& where) {
  using std::sqrt;
  SurfaceTerms<T> out;
  T squared = T(0);
  for (int k = 0; k < 3; ++k) {
    out.u[k] = where.blend(e.normal[k]);
    squared = squared + square(out.u[k]);
  }
  const T inverse = T(1) / sqrt(squared);
  for (T& x : out.u) x = x * inverse;
  for (int j = 0; j < 2; ++j) {
    const T along = out.u[0] * e.turn[0][j] + out.u[1] * e.turn[1][j] + out.u[2] * e.turn[2][j];
    for (int k = 0; k < 3; ++k) {
      out.U[k][j] = (T(e.turn[k][j]) - out.u[k] * along) * inverse;
      out.L[k][j] = T(k == j ? 1 : 0) - out.u[k] * out.u[j] - out.U[k][j] * e.radius_m;
    }
  }
  out.S = product(out.L, out.L);
  const double spread = 0.5 * size_of(out.S.xx - out.S.yy), off = size_of(out.S.xy);
  out.least = 0.5 * (lower(out.S.xx) + lower(out.S.yy)) - std::sqrt(spread * spread + off * off);
  out.turn_max = out.least > 0 ? size(out.U) / std::sqrt(out.least) : 0;
  return out;
}

/// The side force over depth, its change over the facet, and its slope g'.
template <class T>
struct SideTerms {
  T g[3], slope[3], turn[3][2], along;  ///< along: of the blend before its projection
};
template <class T, class Where>
SideTerms<T> side_at(const Facet& e, const Where& where, const SurfaceTerms<T>& frame, const T& d) {
  SideTerms<T> out;
  T slope_along = T(0);
  out.along = T(0);
  for (int k = 0; k < 3; ++k) {
    const T two = where.blend(e.side2[k]), three = where.blend(e.side3[k]);
    out.g[k] = (two + three * d) * d;
    out.slope[k] = (two * 2.0 + three * 3.0 * d) * d;
    for (int j = 0; j < 2; ++j) out.turn[k][j] = (d * e.side3_turn[k][j] + e.side2_turn[k][j]) * d;
    out.along = out.along + out.g[k] * frame.u[k];
    slope_along = slope_along + out.slope[k] * frame.u[k];
  }
  for (int k = 0; k < 3; ++k) {
    out.g[k] = out.g[k] - frame.u[k] * out.along;
    out.slope[k] = out.slope[k] - frame.u[k] * slope_along;
  }
  return out;
}

/// The bed: c_i where they are not negative, h_i / d, how lambda c_i changes over the facet.
template <class T>
struct BedTerms {
  T stiffness[kRings], touching[kRings], change[kRings][2];
  T others;       ///< sum of c_i h_i / d from ring 2 on
  T share;        ///< of what the rings bear (the engine's ring_share())
  double sinks;   ///< size of how that share falls with depth, times sum c_i h_i [N/m]
  double fades;   ///< and over the facet, / d [N/m^2]
  double spread;  ///< sum c_i over sum c_i h_i / d
};
template <class T, class Where>
BedTerms<T> bed_at(const Facet& e, const Where& where, const T& lambda, const T& d) {
  constexpr bool kIsBound = std::is_same_v<T, Interval>;
  BedTerms<T> out;
  out.others = T(0);
  T cut = T(0);
  double cut_stiffness = 0, cut_turn = 0, stiffness = 0, turn = 0;
  for (int i = 0; i < kRings; ++i) {
    const T signed_c = where.blend(e.stiffness[i]);
    out.stiffness[i] = not_negative(signed_c);
    // A slip may end deeper than it began.
    const double from_m = e.threshold[i] - (kIsBound ? 0.5 * e.overshoot_m : 0);
    out.touching[i] = T(i == 0 ? 1 : 0);
    double of_c[2] = {0, 0};
    for (int j = 0; j < 2; ++j) {
      double of_lambda = 0;
      for (int l = 0; l < 3; ++l) {
        of_c[j] += e.stiffness[i][l] * e.gradient[l][j];
        of_lambda += e.lambda[l] * e.gradient[l][j];
      }
      out.change[i][j] =
          upper(signed_c) > 0 ? lambda * of_c[j] + out.stiffness[i] * of_lambda : T(0);
    }
    if (i > 0) {
      if (upper(d) <= from_m) continue;
      if constexpr (kIsBound)
        out.touching[i] =
            Interval(d.lo > 0 ? not_negative(1 - e.threshold[i] / d.lo) : 0, 1 - from_m / d.hi);
      else
        out.touching[i] = not_negative(1 - from_m / d);
      out.others = out.others + out.stiffness[i] * out.touching[i];
    }
    const double steep = std::hypot(of_c[0], of_c[1]) * upper(out.touching[i]);
    stiffness += upper(out.stiffness[i]);
    turn += steep;
    if (lower(signed_c) < 0) {
      cut = cut + not_negative(signed_c * -1.0) * out.touching[i];
      cut_stiffness = std::max(0.0, -lower(signed_c)) + cut_stiffness;
      cut_turn += steep;
    }
  }
  out.share = T(1);
  out.sinks = out.fades = out.spread = 0;
  const T kept = out.stiffness[0] + out.others;
  if (!(cut_stiffness > 0) || !(lower(kept) > 0)) return out;
  const T ratio = cut / kept;
  out.share = not_negative(T(1) - ratio);
  out.sinks = upper(ratio) * stiffness + cut_stiffness;
  out.fades = upper(ratio) * turn + cut_turn;
  out.spread = stiffness / lower(kept);
  return out;
}

/// What the limits of the rings are times (B3a), f^z over the sum of c_i h_i, at a place.
inline double limit_share(const PatchPoint& place, const CurveTerms<double>& depth) {
  const double bed = place.blend(depth.bed);
  return bed > 0 ? std::min(place.blend(depth.force) / bed, runtime::kMaxLimitShare) : 1;
}
/// And over a patch and a range of depths: within the patch the quotient of two blends is between
/// those of its corners, and along the depth it is bounded by its slope.
inline Interval limit_share(const Patch& patch, const CurveTerms<Interval>& depth) {
  const double most = runtime::kMaxLimitShare;
  const Interval step(-depth.half_m, depth.half_m);
  Interval out(most, 0);
  for (const PatchPoint& corner : patch.corner) {
    const Interval force = not_negative(corner.blend(depth.force)), bed = corner.blend(depth.bed);
    if (!(bed.lo > 0))  // 1 where there is no bed
      return {
          bed.hi > 0 ? std::min(lower(not_negative(patch.blend(depth.force))) / bed.hi, 1.0) : 0,
          most};
    Interval here = force / bed;
    const double f = corner.blend(depth.force_there), sum = corner.blend(depth.bed_there);
    const Interval rises = corner.blend(depth.force_rise), sinks = corner.blend(depth.bed_rise),
                   within = sinks * step + sum;
    for (int turn = 0; turn < kSlopeTurns && within.lo > 0; ++turn) {
      const Interval slope = (rises - here * sinks) / within, steep = slope * step + f / sum;
      here = {std::max(here.lo, steep.lo), std::min(here.hi, steep.hi)};
    }
    out = hull(out, here);
  }
  return {std::min(not_negative(out.lo), most), std::min(out.hi, most)};
}

/// c(t) = q.(d kappa along t) q for q = L t, as a sum over cosine and sine of one and three angles.
template <class T>
struct Cubic {
  T one[2], three[2];
  T at(const Directions& way, int j) const {
    return one[0] * way.x[1][j] + one[1] * way.y[1][j] + three[0] * way.x[3][j] +
           three[1] * way.y[3][j];
  }
};
template <class T>
Cubic<T> curvature_change(const Facet& e, const SurfaceTerms<T>& frame) {
  Symmetric<T> a[2];
  for (int j = 0; j < 2; ++j) {
    T changed[3][2];
    times(e.curvature_turn[j], frame.L, changed);
    a[j] = product(frame.L, changed);
  }
  return {{(a[0].xx * 3.0 + a[0].yy + a[1].xy * 2.0) * 0.25,
           (a[1].yy * 3.0 + a[1].xx + a[0].xy * 2.0) * 0.25},
          {(a[0].xx - a[0].yy - a[1].xy * 2.0) * 0.25, (a[0].xy * 2.0 + a[1].xx - a[1].yy) * 0.25}};
}

}  // namespace palpate::certify
