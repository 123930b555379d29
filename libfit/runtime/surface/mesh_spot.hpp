// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// A place on a triangle of the asset, as a Spot of slide.hpp, and a straight path over the
// triangle, as a Path.

#include <type_traits>

#include "../asset/view.hpp"

namespace palpate::runtime {

/// Vector from a ball's centre to its contact point. At first touch the centre is p and the
/// contact point c: reach is (c - p).u and skew what is left of c - p, so that nothing is deflected
/// there (M15). Where normals and facets agree, reach is the radius and skew is nothing.
/// A tip on a body that was measured with a ball is that ball's lowest point at first touch (M15a):
/// the centre is then the tip less pole, reach is the radius and skew is nothing.
struct Arm {
  double reach_m = 0;            ///< along the inward normal
  double skew_m[3] = {0, 0, 0};  ///< aside, about R times the angle of facet and normal
  double pole_m[3] = {0, 0, 0};  ///< from the centre to the tip that stands for the ball
};

/// A corner alone as a spot for curves.
struct CornerSpot {
  const float* node;
  const int* offset;
  double control(int part, int j) const noexcept { return double(node[offset[part] + j]); }
};

/// The piece of a node for the indenter (M83).
inline CurvePiece<double> piece_at(const CurveViews& views, const CornerSpot& spot, int curve,
                                   double x, bool with_area) noexcept {
  CurvePiece<double> out = piece_of(views.view[curve], spot, curve, x, with_area);
  if (curve != kNormal || !has_radius_effect(views)) return out;
  const double k = spot.control(kRadiusEffect, 0), w = spot.control(kRadiusEffect, 1);
  const double share[kRadiusEffects] = {k, w};
  for (int m = 0; m < out.order; ++m) out.c[m] -= w * out.c[m];
  out.area_J -= w * out.area_J;
  for (int i = 0; i < kRadiusEffects; ++i) {
    if (share[i] == 0) continue;
    const auto more = piece_of(views.indenter->by_radius[i], spot, kNormal, x, with_area);
    for (int m = 0; m < out.order; ++m) out.c[m] += share[i] * more.c[m];
    out.area_J += share[i] * more.area_J;
  }
  return out;
}
/// c_i (B0) likewise.
inline void node_stiffness(const CurveViews& views, const CornerSpot& spot, double* c) noexcept {
  ring_stiffness(views.rings, spot, c);
  if (!has_radius_effect(views)) return;
  const double k = spot.control(kRadiusEffect, 0), w = spot.control(kRadiusEffect, 1);
  const double share[kRadiusEffects] = {k, w};
  for (int r = 0; r < kRings; ++r) c[r] -= w * c[r];
  for (int i = 0; i < kRadiusEffects; ++i) {
    if (share[i] == 0) continue;
    double more[kRings];
    ring_stiffness(views.indenter->rings_by_radius[i], spot, more);
    for (int r = 0; r < kRings; ++r) c[r] += share[i] * more[r];
  }
}

/// A row of doubles holds a node's numbers, so that a spot's is one weighted sum: place, inward
/// normal, and of a body of rings what a slip reads (RingNumbers), gamma, the side force and c_i.
enum NodeRow : int {
  kPlaceAt = 0,
  kNormalAt = 3,
  kNumbersAt = 6,
  kSpreadAt = 15,
  kSideAt = 16,
  kStiffnessAt = 22,
  kRowSize = kStiffnessAt + kRings  // even: processors take two at once
};

/// A node as the law computes with it.
struct Corner {
  int vertex = -1;
  const float* node = nullptr;  ///< its controls
  double row[kRowSize] = {};
  CurvePiece<double> curve[kCurves];  ///< around the depth of the last tick

  Vec3d place() const noexcept { return make_vec3<double>(row + kPlaceAt); }
  Vec3d normal() const noexcept { return make_vec3<double>(row + kNormalAt); }
};

/// A spot of the mesh: everything blended by area coordinates n [1], so energies, too (M4).
template <class S>
struct MeshSpot {
  Vec3<S> point;   ///< where the tool's reference point is with no deflection
  Vec3<S> normal;  ///< inward unit
  S length;        ///< of the blended normal before it was made unit
  S n[3];
  const Corner* corner[3];
  const int* offset;  ///< of each part within a node's controls
  S control(int curve, int j) const noexcept {
    const int at = offset[curve] + j;
    return n[0] * double(corner[0]->node[at]) + n[1] * double(corner[1]->node[at]) +
           n[2] * double(corner[2]->node[at]);
  }
};

template <int kOrder, class S>
LiveControls<kOrder, S> live_controls(const MeshSpot<S>& spot, int curve, int first) noexcept {
  const int at = spot.offset[curve] + first;
  const float *p = spot.corner[0]->node + at, *q = spot.corner[1]->node + at,
              *r = spot.corner[2]->node + at;
  LiveControls<kOrder, S> out;
  for (int k = 0; k < kOrder; ++k)
    out.b[k] = spot.n[0] * double(p[k]) + spot.n[1] * double(q[k]) + spot.n[2] * double(r[k]);
  return out;
}

/// Number `at` of a spot's rows.
template <class S>
S row_number(const MeshSpot<S>& spot, int at) noexcept {
  return spot.n[0] * spot.corner[0]->row[at] + spot.n[1] * spot.corner[1]->row[at] +
         spot.n[2] * spot.corner[2]->row[at];
}
template <class T, class S>
RingNumbers<T> ring_numbers(const MeshSpot<S>& spot) noexcept {
  RingNumbers<T> out;
  out.limit = {row_number(spot, kNumbersAt), row_number(spot, kNumbersAt + 1),
               row_number(spot, kNumbersAt + 2)};
  for (int i = 0; i < 6; ++i) out.curvature[i] = row_number(spot, kNumbersAt + 3 + i);
  return out;
}
template <class T, class S>
RingBed<T> bed_at(const CurveViews&, const MeshSpot<S>& spot) noexcept {
  RingBed<T> bed;
  T c[kRings], side[6];
  for (int i = 0; i < kRings; ++i) c[i] = row_number(spot, kStiffnessAt + i);
  for (int i = 0; i < 6; ++i) side[i] = row_number(spot, kSideAt + i);
  make_ring_bed(c, ring_numbers<T>(spot).limit, T(row_number(spot, kSpreadAt)), side, spot.normal,
                bed);
  return bed;
}
/// Another indenter has curves of each node by itself.
template <class S>
CurvePiece<S> piece_at(const CurveViews& views, const MeshSpot<S>& spot, int curve, double x,
                       bool with_area) noexcept {
  if (curve != kNormal || !has_radius_effect(views))
    return piece_of(views.view[curve], spot, curve, x, with_area);
  CurvePiece<S> out;
  out.area_J = S(0);
  for (int k = 0; k < 3; ++k) {
    const CurvePiece<double> own =
        piece_at(views, CornerSpot{spot.corner[k]->node, spot.offset}, curve, x, with_area);
    out.piece = own.piece;
    out.order = own.order;
    out.knot = own.knot;
    for (int m = 0; m < own.order; ++m) out.c[m] = out.c[m] + spot.n[k] * own.c[m];
    out.area_J = out.area_J + spot.n[k] * own.area_J;
  }
  return out;
}

/// Identifies an asset together with the indenter that it is opened for.
inline const double* basis_of(const AssetView& asset) noexcept {
  return asset.curves.view[kNormal].knots;
}

/// A node for the indenter of the asset.
inline void read_corner(const AssetView& asset, int v, Corner& out) noexcept {
  out.vertex = v;
  out.node = asset.node(v);
  for (int i = 0; i < 3; ++i) {
    out.row[kPlaceAt + i] = double(asset.vertex[3 * v + i]);
    out.row[kNormalAt + i] = double(asset.normal[3 * v + i]);
  }
  for (CurvePiece<double>& piece : out.curve) piece.piece = -1;
  if (asset.curves.family != int(Family::rings)) return;
  const CornerSpot spot{out.node, asset.control_offset};
  double* const number = out.row + kNumbersAt;
  copy_controls(spot, kLambda, 0, 3, number);
  copy_controls(spot, kCurvature, 0, 6, number + 3);
  copy_controls(spot, kSpread, 0, 1, out.row + kSpreadAt);
  copy_controls(spot, kSide2, 0, 6, out.row + kSideAt);
  node_stiffness(asset.curves, spot, out.row + kStiffnessAt);
  const IndenterView* const other = asset.curves.indenter;
  if (other == nullptr) return;
  number[1] += number[2] * other->plough_offset_m;  // (M84)
  number[2] *= other->plough_slope;
  offset_curvature(number + 3, other->surface_offset_m);
  for (int i = kSideAt; i < kSideAt + 3; ++i) {
    const double g2 = out.row[i], g3 = out.row[i + 3];
    out.row[i] = other->side[0][0] * g2 + other->side[0][1] * g3;
    out.row[i + 3] = other->side[1][0] * g2 + other->side[1][1] * g3;
  }
}

/// The corners of a triangle: read once, used by every spot there. Those that it shares with the
/// triangle before stay. The row of the spot that was asked for last stays as well.
struct Corners {
  const double* basis = nullptr;  ///< knots of the asset's normal curves, for the indenter
  int triangle = -1;
  Corner node[3];           ///< in any order
  int slot[3] = {0, 1, 2};  ///< where corner k is among them
  bool has_rings = false;

  const Corner& operator[](int k) const noexcept { return node[slot[k]]; }
  Corner& operator[](int k) noexcept { return node[slot[k]]; }

  void take(const AssetView& asset, int t) noexcept {
    if (basis == basis_of(asset) && triangle == t) return;
    if (basis != basis_of(asset))
      for (Corner& corner : node) corner.vertex = -1;
    basis = basis_of(asset);
    triangle = t;
    has_rings = asset.curves.family == int(Family::rings);
    at_[0] = -1;
    bool is_taken[3] = {false, false, false};
    for (int k = 0; k < 3; ++k) {
      slot[k] = -1;
      for (int j = 0; j < 3; ++j)
        if (node[j].vertex == asset.corner(t, k)) is_taken[slot[k] = j] = true;
    }
    for (int k = 0, j = 0; k < 3; ++k) {
      if (slot[k] >= 0) continue;
      while (is_taken[j]) ++j;
      read_corner(asset, asset.corner(t, k), node[slot[k] = j++]);
    }
  }

  /// The row at area coordinates n [1] of the triangle; of a body without rings, place and normal.
  const double* row_at(const double n[3]) noexcept {
    if (at_[0] == n[0] && at_[1] == n[1] && at_[2] == n[2]) return row_;
    for (int k = 0; k < 3; ++k) at_[k] = n[k];
    if (has_rings)
      blend<kRowSize>(n, row_);
    else
      blend<kNumbersAt>(n, row_);
    return row_;
  }
  /// The sum of the first kCount numbers of the rows, weighted by area coordinates n (M4) or by
  /// their rates.
  template <int kCount>
  void blend(const double n[3], double* __restrict out) const noexcept {
    const double *p = (*this)[0].row, *q = (*this)[1].row, *r = (*this)[2].row;
    const double a = n[0], b = n[1], c = n[2];
    for (int i = 0; i < kCount; ++i) out[i] = a * p[i] + b * q[i] + c * r[i];
  }

 private:
  double at_[3] = {-1, 0, 0};  ///< where row_ is; a coordinate below 0: nowhere
  double row_[kRowSize] = {};
};

/// A straight path within one triangle: area coordinates n(s) = n + s rate. P: scalar of the place.
/// A ball rests at c - reach u - skew (skew without its part along u) (M16); a tip rests at c
/// itself.
template <class P, bool kIsBall>
struct MeshPath {
  Corners* corners;
  const int* offset;  ///< of each curve in the controls
  const Arm* arm;     ///< of a ball
  P n[3], rate[3];    ///< [1], [1/m]
  P end_m;            ///< where a coordinate reaches zero, or the slip budget does
  int exit;           ///< which coordinate; -1: the budget
  bool blocked;       ///< nothing can move
  bool is_bent;       ///< a border leaves only the part along it

  P end() const noexcept { return end_m; }
  bool is_blocked() const noexcept { return blocked; }
  bool is_straight() const noexcept { return !is_bent; }
  decltype(auto) plain() const noexcept {
    if constexpr (std::is_same<P, double>::value)
      return (*this);  // itself, no copy
    else
      return MeshPath<double, kIsBall>{corners,
                                       offset,
                                       arm,
                                       {value_of(n[0]), value_of(n[1]), value_of(n[2])},
                                       {value_of(rate[0]), value_of(rate[1]), value_of(rate[2])},
                                       value_of(end_m),
                                       exit,
                                       blocked,
                                       is_bent};
  }

  template <class S>
  MeshSpot<S> at(const S& s) const noexcept {
    MeshSpot<S> spot;
    Vec3<S> field{S(0), S(0), S(0)};
    spot.point = field;
    for (int k = 0; k < 3; ++k) {
      spot.n[k] = s * rate[k] + n[k];
      const Corner& corner = (*corners)[k];
      spot.point = spot.point + corner.place() * spot.n[k];
      field = field + corner.normal() * spot.n[k];
      spot.corner[k] = &corner;
    }
    rest(field, spot);
    return spot;
  }
  /// at(0) of a path of doubles, out of the row there.
  MeshSpot<double> at_row(const double* row) const noexcept {
    MeshSpot<double> spot;
    spot.point = make_vec3<double>(row + kPlaceAt);
    for (int k = 0; k < 3; ++k) {
      spot.n[k] = n[k];
      spot.corner[k] = &(*corners)[k];
    }
    rest(make_vec3<double>(row + kNormalAt), spot);
    return spot;
  }

 private:
  // Moves a ball's spot from its contact point to its rest position, and completes the spot.
  template <class S>
  void rest(const Vec3<S>& field, MeshSpot<S>& spot) const noexcept {
    using std::sqrt;
    spot.length = sqrt(dot(field, field));
    spot.normal = field * (1.0 / spot.length);
    spot.offset = offset;
    if constexpr (kIsBall) {
      const Vec3<S> skew = make_vec3<S>(arm->skew_m);
      const S along = dot(skew, spot.normal);
      spot.point = spot.point - skew - spot.normal * (arm->reach_m - along);
    }
  }
};

/// A straight path as the rings' slip reads it: tool and blended normal are linear in s, and so are
/// a node's numbers. The corners are read once for all places of the path.
template <bool kIsBall>
class MeshSlipPath {
 public:
  MeshSlipPath(const MeshPath<double, kIsBall>& path, const Vec3d& x) noexcept
      : value_(path.corners->row_at(path.n)) {
    path.corners->template blend<kSlipRow>(path.rate, rate_);
    to_tool_ = x - make_vec3<double>(value_ + kPlaceAt);
    if constexpr (kIsBall) {
      skew_ = make_vec3<double>(path.arm->skew_m);
      to_tool_ = to_tool_ + skew_;
      reach_m_ = path.arm->reach_m;
    }
  }

  /// lambda |q| - share mu(d + beyond) d [m] (B3) and its slope by s. With the blended normal B and
  /// w from c + skew to the tool, q = w - t B, t = w.B / B.B, and q.B = 0.
  Dual excess(double s, double creep_depth_m, double share) const noexcept {
    double at[kSlipRow];
    for (int i = kNormalAt; i < kSlipRow; ++i) at[i] = value_[i] + s * rate_[i];
    const Vec3d to_tool_rate = make_vec3<double>(rate_ + kPlaceAt) * -1.0,
                w = to_tool_ + to_tool_rate * s, field = make_vec3<double>(at + kNormalAt),
                field_rate = make_vec3<double>(rate_ + kNormalAt);
    const double inverse = 1 / std::sqrt(dot(field, field)), inverse_squared = inverse * inverse;
    const double across = dot(w, field), half = dot(field, field_rate) * inverse_squared;
    const double dacross = dot(to_tool_rate, field) + dot(w, field_rate);
    const double t = across * inverse_squared, dt = dacross * inverse_squared - 2 * (t * half);
    const Vec3d q = w - field * t, moved = to_tool_rate - field_rate * t;  // dq = moved - dt B
    double height = across, dheight = dacross;
    if constexpr (kIsBall) {
      height = height - dot(skew_, field);
      dheight = dheight - dot(skew_, field_rate);
    }
    dheight = (dheight - height * half) * inverse;
    height = height * inverse + reach_m_;
    const double *limit = at + kNumbersAt, *dlimit = rate_ + kNumbersAt;
    const Vec3d curved = curvature_times(limit + 3, q);
    const double depth = height - 0.5 * dot(q, curved);
    const double ddepth = dheight - (dot(curved, moved) - dt * dot(curved, field)) -
                          0.5 * dot(q, curvature_times(dlimit + 3, q));
    const double squared = dot(q, q);
    const bool is_aside = squared > kLateralZero_m * kLateralZero_m;
    const double size = is_aside ? std::sqrt(squared) : 0;
    const double dsize = is_aside ? dot(q, moved) / size : 0;
    Dual out(limit[0] * size, dlimit[0] * size + limit[0] * dsize);
    const double mu = limit[1] + limit[2] * (depth + creep_depth_m);
    if (!(depth > 0 && mu > 0)) return out;
    out.a -= share * mu * depth;
    out.v -=
        share * ((dlimit[1] + dlimit[2] * (depth + creep_depth_m) + limit[2] * ddepth) * depth +
                 mu * ddepth);
    return out;
  }

 private:
  static constexpr int kSlipRow = kSpreadAt + 1;  // even
  const double* value_;                           ///< the corners', until they blend another
  double rate_[kSlipRow];
  Vec3d to_tool_, skew_{0, 0, 0};
  double reach_m_ = 0;
};
template <bool kIsBall>
MeshSlipPath<kIsBall> ring_slip_path(const MeshPath<double, kIsBall>& path,
                                     const Vec3d& x) noexcept {
  return {path, x};
}
template <bool kIsBall>
Dual ring_excess_along(const MeshSlipPath<kIsBall>& path, const Vec3d&, double s,
                       double creep_depth_m, double share) noexcept {
  return path.excess(s, creep_depth_m, share);
}

}  // namespace palpate::runtime
