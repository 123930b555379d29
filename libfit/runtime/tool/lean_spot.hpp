// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// The curves of a contact point at a lean (docs/method.md, section 27): one contact on one surface,
// and what the nodes of the lean say there, blended before the law is evaluated (M67). Everything
// that leans (normal curve, rings' stiffness, side force) is linear in a node's numbers, so a row
// of these for each node is all that is blended, first over the triangle, then over the lean.

#include "../asset/view.hpp"
#include "../families/ring_bed.hpp"

namespace palpate {
namespace runtime {

/// A row of a node: c_i (B0), g_2 and g_3, the normal curve on one interval and the area below it.
constexpr int kLeanSideAt = kRings, kLeanPieceAt = kLeanSideAt + 6,
              kLeanAreaAt = kLeanPieceAt + kMaxDegree + 1, kLeanRow = kLeanAreaAt + 1;

/// A node of the lean at a vertex, as a Spot of response.hpp.
struct LeanNode {
  const float* curve;  ///< the normal one, then g_2 and g_3
  int size;            ///< of it
  double control(int part, int j) const noexcept {
    return double(curve[part == kNormal ? j : size + (part == kSide2 ? j : 3 + j)]);
  }
};
inline LeanNode lean_node(const AssetView& asset, int vertex, int node) noexcept {
  const int size = asset.curves.view[kNormal].size();
  const std::ptrdiff_t row = std::ptrdiff_t{asset.record[vertex]} * asset.leans.nodes.size() + node;
  return {asset.leans.control + row * (size + kLeanSideNumbers), size};
}

/// What all nodes say at a vertex.
struct LeanCorner {
  int vertex = -1, piece = -1;
  double row[kMaxTiltNodes][kLeanRow] = {};
};

/// Of one contact whose tool leans: what it says at its contact point, and the weights of its lean.
struct LeanSpot {
  Vec3d shaft{0, 0, 1};  ///< of the tool, in the body's axes
  bool is_weighed = false;
  Vec3d normal{0, 0, 0};  ///< that the lean is about
  TiltFrame frame{{0, 0, 0}, {0, 0, 0}};
  TiltLean lean{0, 0};
  TiltWeights at;
  LeanCorner corner[3];
  int slot[3] = {0, 1, 2};  ///< where corner k is among them
  const float* of = nullptr;
  int triangle = -1, piece = -1;
  double weight[3] = {0, 0, 0};
  double row[kMaxTiltNodes][kLeanRow] = {};

  void turn(const Vec3d& to) noexcept {
    shaft = to;
    is_weighed = false;
  }
  void weigh(const AssetView& asset, const Vec3d& about) noexcept {
    if (is_weighed && normal.x == about.x && normal.y == about.y && normal.z == about.z) return;
    is_weighed = true;
    normal = about;
    frame = tilt_frame(about);
    lean = lean_of(frame, shaft);
    at = tilt_weights(asset.leans.nodes, lean);
  }
  void stand(const AssetView& asset, int t, const double n[3]) noexcept {
    if (of == asset.leans.control && triangle == t && weight[0] == n[0] && weight[1] == n[1] &&
        weight[2] == n[2])
      return;
    if (of != asset.leans.control || triangle != t) take(asset, t);
    for (int k = 0; k < 3; ++k) weight[k] = n[k];
    blend_corners<0, kLeanPieceAt>(asset);
    piece = -1;
  }
  /// The normal curves' interval.
  void reach(const AssetView& asset, int interval) noexcept {
    if (piece == interval) return;
    const SplineView& view = asset.curves.view[kNormal];
    for (LeanCorner& own : corner) {
      if (own.piece == interval) continue;
      own.piece = interval;
      for (int i = 0; i < asset.leans.nodes.size(); ++i) {
        const CurvePiece<double> curve = piece_under(asset.curves, lean_node(asset, own.vertex, i),
                                                     kNormal, view.knots[interval], true);
        for (int m = 0; m <= kMaxDegree; ++m) own.row[i][kLeanPieceAt + m] = curve.c[m];
        own.row[i][kLeanAreaAt] = curve.area_J;
      }
    }
    piece = interval;
    blend_corners<kLeanPieceAt, kLeanRow>(asset);
  }
  /// Numbers from kFrom to below kTo at the lean; with these known the compiler takes several.
  template <int kFrom, int kTo>
  void blend(const AssetView& asset, double* __restrict out) const noexcept {
    for (int j = kFrom; j < kTo; ++j) out[j] = 0;
    for (int i = 0; i < asset.leans.nodes.size(); ++i) {
      const double w = at.w[i];
      if (w == 0) continue;
      const double* __restrict own = row[i];
      for (int j = kFrom; j < kTo; ++j) out[j] += w * own[j];
    }
  }
  void put_bed(const AssetView& asset, const RingLimit<double>& limit,
               RingBed<double, kRings>& bed) const noexcept {
    double at_lean[kLeanPieceAt];
    blend<0, kLeanPieceAt>(asset, at_lean);
    make_ring_bed(at_lean, limit, at_lean + kLeanSideAt, normal, bed);
  }
  void put_piece(const AssetView& asset, int interval, CurvePiece<double>& out) noexcept {
    reach(asset, interval);
    double at_lean[kLeanRow];
    blend<kLeanPieceAt, kLeanRow>(asset, at_lean);
    const SplineView& view = asset.curves.view[kNormal];
    out.piece = interval;
    out.order = view.degree + 1;
    out.knot = view.knots[interval];
    for (int m = 0; m <= kMaxDegree; ++m) out.c[m] = at_lean[kLeanPieceAt + m];
    out.area_J = at_lean[kLeanAreaAt];
  }
  /// A control value of what leans.
  double control(const AssetView& asset, int part, int j) const noexcept {
    double sum = 0;
    for (int i = 0; i < asset.leans.nodes.size(); ++i)
      for (int k = 0; k < 3; ++k)
        sum += at.w[i] * weight[k] * lean_node(asset, corner[slot[k]].vertex, i).control(part, j);
    return sum;
  }

 private:
  template <int kFrom, int kTo>
  void blend_corners(const AssetView& asset) noexcept {
    const double a = weight[0], b = weight[1], c = weight[2];
    for (int i = 0; i < asset.leans.nodes.size(); ++i) {
      const double *p = corner[slot[0]].row[i], *q = corner[slot[1]].row[i],
                   *r = corner[slot[2]].row[i];
      double* __restrict out = row[i];
      for (int j = kFrom; j < kTo; ++j) out[j] = a * p[j] + b * q[j] + c * r[j];
    }
  }
  // Corners that the triangle before had stay.
  void take(const AssetView& asset, int t) noexcept {
    if (of != asset.leans.control)
      for (LeanCorner& own : corner) own.vertex = -1;
    of = asset.leans.control;
    triangle = t;
    bool is_taken[3] = {false, false, false};
    for (int k = 0; k < 3; ++k) {
      slot[k] = -1;
      for (int j = 0; j < 3; ++j)
        if (corner[j].vertex == asset.corner(t, k)) is_taken[slot[k] = j] = true;
    }
    for (int k = 0, j = 0; k < 3; ++k) {
      if (slot[k] >= 0) continue;
      while (is_taken[j]) ++j;
      read(asset, asset.corner(t, k), corner[slot[k] = j++]);
    }
  }
  static void read(const AssetView& asset, int v, LeanCorner& out) noexcept {
    out.vertex = v;
    out.piece = -1;
    for (int i = 0; i < asset.leans.nodes.size(); ++i) {
      const LeanNode node = lean_node(asset, v, i);
      ring_stiffness(asset.curves.rings, node, out.row[i]);
      copy_controls(node, kSide2, 0, 3, out.row[i] + kLeanSideAt);
      copy_controls(node, kSide3, 0, 3, out.row[i] + kLeanSideAt + 3);
    }
  }
};

}  // namespace runtime
}  // namespace palpate
