// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// What a contact point that stands still need not compute again: where it is, its three corners'
// curves blended into one, its other numbers, the bed of rings under it. Nothing here is a result
// of its own; every number is the one that mesh_surface.hpp would bring, bit for bit, so a Hold may
// be dropped at any time.

#include "mesh_surface.hpp"

namespace palpate {
namespace runtime {

constexpr int kMaxHeldNumbers = 16;

/// Of one contact point on one asset. It is good as long as that is where the contact stands.
struct Hold {
  const float* of = nullptr;  ///< controls of the asset; null: nothing is held
  int triangle = -1;
  bool is_ball = false, is_frictionless = false;
  double weight[3] = {0, 0, 0};
  Vec3d point{0, 0, 0}, normal{0, 0, 0};
  double length = 1;                    ///< of the blended normal
  CurvePiece<double> curve[kCurves];    ///< around the depth of the last tick
  double number[kMaxHeldNumbers] = {};  ///< of the parts that are no curves, blended
  int number_offset = 0;                ///< of the first of them in a vertex's controls
  RingBed<double, kRings> bed = {};     ///< of a body of rings
};

inline void drop(Hold& hold) noexcept { hold.of = nullptr; }

inline bool is_good(const Hold& hold, const AssetView& asset, int triangle, const double weight[3],
                    bool is_ball) noexcept {
  return hold.of == asset.control && hold.triangle == triangle && hold.is_ball == is_ball &&
         hold.weight[0] == weight[0] && hold.weight[1] == weight[1] && hold.weight[2] == weight[2];
}

/// A Spot of slide.hpp: the standing one, out of a good Hold.
struct HeldSpot {
  Vec3d point, normal;
  Hold* hold;
  const AssetView* asset;

  MeshSpot<double> mesh_spot() const noexcept {
    MeshSpot<double> spot;
    spot.point = point;
    spot.normal = normal;
    spot.length = hold->length;
    for (int k = 0; k < 3; ++k) {
      const std::ptrdiff_t v = asset->corner(hold->triangle, k);
      spot.n[k] = hold->weight[k];
      spot.node[k] = asset->control + v * asset->controls_per_vertex;
    }
    spot.offset = asset->control_offset;
    return spot;
  }
  double control(int part, int j) const noexcept {
    return asset->curves.view[part].pieces > 0
               ? mesh_spot().control(part, j)
               : hold->number[asset->control_offset[part] - hold->number_offset + j];
  }
};

inline const CurvePiece<double>& piece_under(const CurveViews& views, const HeldSpot& spot,
                                             int curve, double x, bool with_area) noexcept {
  CurvePiece<double>& held = spot.hold->curve[curve];
  const SplineView& view = views.view[curve];
  const bool is_right = held.piece >= 0 && held.has_area >= with_area && x >= held.knot &&
                        (held.piece == view.pieces || x < view.knots[held.piece + 1]);
  if (!is_right) held = piece_under(views, spot.mesh_spot(), curve, x, with_area);
  return held;
}

inline bool lacks_lateral(const CurveViews&, const HeldSpot& spot) noexcept {
  return spot.hold->is_frictionless;
}
template <class T>
const RingBed<double, kRings>& bed_under(const CurveViews&, const HeldSpot& spot) noexcept {
  return spot.hold->bed;
}

/// Makes the hold that of a contact point.
template <class F>
void keep(Hold& hold, const AssetView& asset, int triangle, const double weight[3], bool is_ball,
          const MeshSpot<double>& spot) noexcept {
  hold.of = asset.control;
  hold.triangle = triangle;
  hold.is_ball = is_ball;
  hold.is_frictionless = F::is_frictionless(asset.curves, spot);
  for (int k = 0; k < 3; ++k) hold.weight[k] = weight[k];
  hold.point = spot.point;
  hold.normal = spot.normal;
  hold.length = spot.length;
  for (CurvePiece<double>& piece : hold.curve) piece.piece = -1;
  if constexpr (F::kNumbers > 0) {
    static_assert(F::kNumbers <= kMaxHeldNumbers, "room for them");
    hold.number_offset = asset.control_offset[F::kCurves];
    copy_controls(spot, F::kCurves, 0, F::kNumbers, hold.number);
  }
  if constexpr (std::is_same_v<F, Rings>) make_ring_bed(asset.curves.rings, spot, hold.bed);
}

}  // namespace runtime
}  // namespace palpate
