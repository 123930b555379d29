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
  int* piece;            ///< of each curve: the interval last read
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

template <class S>
int piece_at(const SplineView& view, const MeshSpot<S>& spot, int curve, double x) noexcept {
  if (curve >= kCurves) return find_piece(view, x);
  return spot.piece[curve] = find_piece(view, x, spot.piece[curve]);
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
  int* piece;         ///< of each curve: the interval last read
  const Arm* arm;     ///< of a ball
  P n[3], rate[3];    ///< [1], [1/m]
  P end_m;            ///< where a coordinate reaches zero
  int exit;           ///< which one
  bool blocked;       ///< a border leaves no way to go

  P end() const noexcept { return end_m; }
  bool is_blocked() const noexcept { return blocked; }
  decltype(auto) plain() const noexcept {
    if constexpr (std::is_same<P, double>::value)
      return (*this);  // itself, no copy
    else
      return MeshPath<double, kIsBall>{facet,
                                       offset,
                                       piece,
                                       arm,
                                       {value_of(n[0]), value_of(n[1]), value_of(n[2])},
                                       {value_of(rate[0]), value_of(rate[1]), value_of(rate[2])},
                                       value_of(end_m),
                                       exit,
                                       blocked};
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
    spot.piece = piece;
    if constexpr (kIsBall) {
      const Vec3<S> skew = make_vec3<S>(arm->skew_m);
      const S along = dot(skew, spot.normal);
      spot.point = spot.point - skew - spot.normal * (arm->reach_m - along);
    }
    return spot;
  }
};

/// What rings' excess reads along a straight way (families/rings.hpp), each as value + s rate: the
/// corners are read once for all places of the way.
template <bool kIsBall>
struct MeshWay {
  static constexpr int kPart[] = {kLambda, kFriction, kFrictionSlope, kCurvature};
  static constexpr int kSlot[kMaxParts] = {-1, 0, 1, 2, -1, -1, 3, -1};  ///< of a part
  static constexpr int kNumbers = 9;
  const Arm* arm;
  Vec3d point, point_rate, field, field_rate;
  double value[kNumbers], rate[kNumbers];

  explicit MeshWay(const MeshPath<double, kIsBall>& path) noexcept : arm(path.arm) {
    point = point_rate = field = field_rate = {0, 0, 0};
    for (int k = 0; k < 3; ++k) {
      point = point + path.facet->vertex[k] * path.n[k];
      point_rate = point_rate + path.facet->vertex[k] * path.rate[k];
      field = field + path.facet->normal[k] * path.n[k];
      field_rate = field_rate + path.facet->normal[k] * path.rate[k];
    }
    for (const int part : kPart)
      for (int j = 0; j < (part == kCurvature ? 6 : 1); ++j) {
        const int at = path.offset[part] + j;
        const double p = double(path.facet->node[0][at]), q = double(path.facet->node[1][at]),
                     r = double(path.facet->node[2][at]);
        value[kSlot[part] + j] = path.n[0] * p + path.n[1] * q + path.n[2] * r;
        rate[kSlot[part] + j] = path.rate[0] * p + path.rate[1] * q + path.rate[2] * r;
      }
  }

  template <class S>
  struct Place {
    Vec3<S> point, normal;
    const MeshWay* way;
    S s;
    S control(int part, int j) const noexcept {
      const int i = kSlot[part] + j;
      return s * way->rate[i] + way->value[i];
    }
  };
  template <class S>
  Place<S> at(const S& s) const noexcept {
    using std::sqrt;
    const auto along = [&](const Vec3d& from, const Vec3d& by) noexcept {
      return Vec3<S>{s * by.x + from.x, s * by.y + from.y, s * by.z + from.z};
    };
    const Vec3<S> blend = along(field, field_rate);
    Place<S> place{along(point, point_rate), blend * (1.0 / sqrt(dot(blend, blend))), this, s};
    if constexpr (kIsBall) {
      const Vec3<S> skew = make_vec3<S>(arm->skew_m);
      place.point = place.point - skew - place.normal * (arm->reach_m - dot(skew, place.normal));
    }
    return place;
  }
};
template <bool kIsBall>
MeshWay<kIsBall> way_of_excess(const MeshPath<double, kIsBall>& path) noexcept {
  return MeshWay<kIsBall>(path);
}

}  // namespace runtime
}  // namespace palpate
