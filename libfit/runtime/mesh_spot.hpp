// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// A place on a triangle of the asset, as a Spot of slide.hpp, and a straight way over the triangle,
// as a Path.

#include <type_traits>

#include "view.hpp"

namespace palpate {
namespace runtime {

/// How a ball's centre stands from its contact point. At first touch the centre is p and the
/// contact point c: reach is (c - p).u and skew what is left of c - p, so that nothing is deflected
/// there (M15). Where normals and facets agree, reach is the radius and skew is nothing.
struct Arm {
  double reach_m = 0;            ///< along the inward normal
  double skew_m[3] = {0, 0, 0};  ///< aside, about R times the angle of facet and normal
};

/// A spot of the mesh: everything blended by area coordinates n [1], so energies, too (M4).
template <class S>
struct MeshSpot {
  Vec3<S> point;   ///< where the tool's reference point is with no deflection
  Vec3<S> normal;  ///< inward unit
  S length;        ///< of the blended normal before it was made unit
  S n[3];
  const float* node[3];  ///< controls of the corners
  const int* offset;     ///< of each part within them
  S control(int curve, int j) const noexcept {
    const int at = offset[curve] + j;
    return n[0] * double(node[0][at]) + n[1] * double(node[1][at]) + n[2] * double(node[2][at]);
  }
};

template <int kOrder, class S>
LiveControls<kOrder, S> live_controls(const MeshSpot<S>& spot, int curve, int first) noexcept {
  const int at = spot.offset[curve] + first;
  const float *p = spot.node[0] + at, *q = spot.node[1] + at, *r = spot.node[2] + at;
  LiveControls<kOrder, S> out;
  for (int k = 0; k < kOrder; ++k)
    out.b[k] = spot.n[0] * double(p[k]) + spot.n[1] * double(q[k]) + spot.n[2] * double(r[k]);
  return out;
}

inline void copy_controls(const MeshSpot<double>& spot, int part, int j, int count,
                          double* out) noexcept {
  const int at = spot.offset[part] + j;
  const float *p = spot.node[0] + at, *q = spot.node[1] + at, *r = spot.node[2] + at;
  const double a = spot.n[0], b = spot.n[1], c = spot.n[2];
  for (int k = 0; k < count; ++k) out[k] = a * double(p[k]) + b * double(q[k]) + c * double(r[k]);
}

/// A triangle as the law computes with it: read once, used by every spot of a way.
struct Facet {
  Vec3d vertex[3], normal[3];
  const float* node[3];  ///< controls of the corners

  static Facet of(const AssetView& asset, int triangle) noexcept {
    Facet out;
    for (int k = 0; k < 3; ++k) {
      const int v = asset.corner(triangle, k);
      out.vertex[k] = asset.vertex_at(v);
      out.normal[k] = asset.normal_at(v);
      out.node[k] = asset.control + static_cast<std::ptrdiff_t>(v) * asset.controls_per_vertex;
    }
    return out;
  }
};

/// A straight way within one triangle: area coordinates n(s) = n + s rate. P: scalar of the place.
/// A ball rests at c - reach u - skew (skew without its part along u) (M16); a tip rests at c
/// itself.
template <class P, bool kIsBall>
struct MeshPath {
  const Facet* facet;
  const int* offset;  ///< of each curve in the controls
  const Arm* arm;     ///< of a ball
  P n[3], rate[3];    ///< [1], [1/m]
  P end_m;            ///< where a coordinate reaches zero, or the slip budget does
  int exit;           ///< which coordinate; -1: the budget
  bool blocked;       ///< no way to go
  bool is_bent;       ///< a border leaves only the part along it
  double length;      ///< of the blended normal at the start

  P end() const noexcept { return end_m; }
  bool is_blocked() const noexcept { return blocked; }
  bool is_straight() const noexcept { return !is_bent; }
  decltype(auto) plain() const noexcept {
    if constexpr (std::is_same<P, double>::value)
      return (*this);  // itself, no copy
    else
      return MeshPath<double, kIsBall>{facet,
                                       offset,
                                       arm,
                                       {value_of(n[0]), value_of(n[1]), value_of(n[2])},
                                       {value_of(rate[0]), value_of(rate[1]), value_of(rate[2])},
                                       value_of(end_m),
                                       exit,
                                       blocked,
                                       is_bent,
                                       length};
  }

  template <class S>
  MeshSpot<S> at(const S& s) const noexcept {
    using std::sqrt;
    MeshSpot<S> spot;
    Vec3<S> field{S(0), S(0), S(0)};
    spot.point = field;
    for (int k = 0; k < 3; ++k) {
      spot.n[k] = s * rate[k] + n[k];
      spot.point = spot.point + facet->vertex[k] * spot.n[k];
      field = field + facet->normal[k] * spot.n[k];
      spot.node[k] = facet->node[k];
    }
    spot.length = sqrt(dot(field, field));
    spot.normal = field * (1.0 / spot.length);
    spot.offset = offset;
    if constexpr (kIsBall) {
      const Vec3<S> skew = make_vec3<S>(arm->skew_m);
      const S along = dot(skew, spot.normal);
      spot.point = spot.point - skew - spot.normal * (arm->reach_m - along);
    }
    return spot;
  }
};

/// A straight way as the rings' slip reads it: tool and blended normal are linear in s, and so are
/// a node's numbers. The corners are read once for all places of the way.
template <bool kIsBall>
struct MeshWay {
  const MeshPath<double, kIsBall>* path;
  Vec3d point, point_rate, field, field_rate, skew{0, 0, 0};
  double reach_m = 0, start_inverse;
  double value[9], rate[9];  ///< lambda, mu_0, mu_1, kappa

  explicit MeshWay(const MeshPath<double, kIsBall>& of) noexcept
      : path(&of), start_inverse(1 / of.length) {
    point = point_rate = field = field_rate = {0, 0, 0};
    for (int k = 0; k < 3; ++k) {
      point = point + of.facet->vertex[k] * of.n[k];
      point_rate = point_rate + of.facet->vertex[k] * of.rate[k];
      field = field + of.facet->normal[k] * of.n[k];
      field_rate = field_rate + of.facet->normal[k] * of.rate[k];
    }
    if constexpr (kIsBall) {
      skew = make_vec3<double>(of.arm->skew_m);
      reach_m = of.arm->reach_m;
    }
    read<3>(of.offset[kLambda], value, rate);
    read<6>(of.offset[kCurvature], value + 3, rate + 3);
  }
  MeshSpot<double> at(double s) const noexcept { return path->at(s); }

  /// lambda |q| - mu(d) d [m] and its slope by s, of a tool at x.
  Dual excess(const Vec3d& x, double s) const noexcept {
    const Vec3d blend = field + field_rate * s;
    const double inverse = s == 0 ? start_inverse : 1 / std::sqrt(dot(blend, blend));
    const Vec3d delta = x - point - point_rate * s, u = blend * inverse,
                du = tangential(field_rate, u) * inverse;
    const Vec3d w = delta + skew;  // a ball's: aside of its reach
    const double along = dot(w, u), sinking = dot(point_rate, u);
    const Vec3d q = w - u * along, dq = (u * (sinking - dot(w, du)) - point_rate) - du * along;
    const double height = dot(delta, u) + reach_m, dheight = dot(delta, du) - sinking;
    double kappa[6];
    for (int j = 0; j < 6; ++j) kappa[j] = value[3 + j] + s * rate[3 + j];
    const Vec3d curved = curvature_times(kappa, q);
    const double depth = height - 0.5 * dot(q, curved);
    const double ddepth = dheight - dot(dq, curved) - 0.5 * dot(q, curvature_times(rate + 3, q));
    const double squared = dot(q, q);
    const bool is_aside = squared > kLateralZero_m * kLateralZero_m;
    const double size = is_aside ? std::sqrt(squared) : 0;
    const double dsize = is_aside ? dot(q, dq) / size : 0;
    const double lambda = value[0] + s * rate[0];
    Dual out(lambda * size, rate[0] * size + lambda * dsize);
    if (!(depth > 0)) return out;
    const double mu_1 = value[2] + s * rate[2], mu = value[1] + s * rate[1] + mu_1 * depth;
    if (!(mu > 0)) return out;
    out.a -= mu * depth;
    out.v -= (rate[1] + rate[2] * depth + mu_1 * ddepth) * depth + mu * ddepth;
    return out;
  }

 private:
  template <int kCount>
  void read(int at, double* to, double* by) const noexcept {
    const float *p = path->facet->node[0] + at, *q = path->facet->node[1] + at,
                *r = path->facet->node[2] + at;
    for (int j = 0; j < kCount; ++j) {
      const double a = double(p[j]), b = double(q[j]), c = double(r[j]);
      to[j] = path->n[0] * a + path->n[1] * b + path->n[2] * c;
      by[j] = path->rate[0] * a + path->rate[1] * b + path->rate[2] * c;
    }
  }
  static Vec3d curvature_times(const double* kappa, const Vec3d& q) noexcept {
    return {kappa[0] * q.x + kappa[3] * q.y + kappa[4] * q.z,
            kappa[3] * q.x + kappa[1] * q.y + kappa[5] * q.z,
            kappa[4] * q.x + kappa[5] * q.y + kappa[2] * q.z};
  }
};
template <bool kIsBall>
MeshWay<kIsBall> way_of_excess(const MeshPath<double, kIsBall>& path) noexcept {
  return MeshWay<kIsBall>(path);
}
template <bool kIsBall>
Dual ring_excess_along(const MeshWay<kIsBall>& way, const Vec3d& x, double s) noexcept {
  return way.excess(x, s);
}

}  // namespace runtime
}  // namespace palpate
