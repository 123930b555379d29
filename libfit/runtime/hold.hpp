// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// What a contact point that stands still need not compute again: where it is and its three corners'
// curves blended into one. Nothing here is a result of its own; every number is the one that
// mesh_surface.hpp would bring, bit for bit, so a Hold may be dropped at any time.

#include "mesh_surface.hpp"

namespace palpate {
namespace runtime {

/// A blended curve around the depth of the last tick.
struct HeldCurve {
  int piece = 0;                  ///< interval of that depth
  int first = -1;                 ///< control value that b[0] is; -1: none yet
  int area_piece = -1;            ///< interval that area_J belongs to; -1: none yet
  double b[kMaxDegree + 1] = {};  ///< [N], as many as are alive on an interval
  double area_J = 0;              ///< area_before() of that interval
};

constexpr int kMaxHeldNumbers = 16;

/// Of one contact point on one asset. It is good as long as that is where the contact stands.
struct Hold {
  const float* of = nullptr;  ///< controls of the asset; null: nothing is held
  int triangle = -1;
  bool is_ball = false, is_frictionless = false;
  double weight[3] = {0, 0, 0};
  Vec3d point{0, 0, 0}, normal{0, 0, 0};
  HeldCurve curve[kCurves];
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

template <class F, class Foot>
void keep(Hold& hold, const AssetView& asset, int triangle, const double weight[3], bool is_ball,
          const Foot& foot) noexcept {
  const MeshSpot<double>& spot = foot.spot;
  hold = Hold();
  hold.of = asset.control;
  hold.triangle = triangle;
  hold.is_ball = is_ball;
  hold.is_frictionless = F::is_frictionless(asset.curves, spot);
  for (int k = 0; k < 3; ++k) hold.weight[k] = weight[k];
  hold.point = spot.point;
  hold.normal = spot.normal;
  if constexpr (F::kNumbers > 0) {
    static_assert(F::kNumbers <= kMaxHeldNumbers, "room for them");
    hold.number_offset = asset.control_offset[F::kCurves];
    for (int j = 0; j < F::kNumbers; ++j) hold.number[j] = spot.control(F::kCurves, j);
  }
  if constexpr (std::is_same_v<F, Rings>) hold.bed = foot.bed;
}

/// A Spot of slide.hpp: the standing one, out of a good Hold.
struct HeldSpot {
  Vec3d point, normal;
  Hold* hold;
  const AssetView* asset;

  MeshSpot<double> mesh_spot() const noexcept {  // for control values that are not at hand
    MeshSpot<double> spot;
    for (int k = 0; k < 3; ++k) {
      const std::ptrdiff_t v = asset->corner(hold->triangle, k);
      spot.n[k] = hold->weight[k];
      spot.node[k] = asset->control + v * asset->controls_per_vertex;
    }
    spot.offset = asset->control_offset;
    spot.piece = nullptr;  // no interval is looked for
    return spot;
  }
  double control(int part, int j) const noexcept {
    return asset->curves.view[part].pieces > 0
               ? mesh_spot().control(part, j)
               : hold->number[asset->control_offset[part] - hold->number_offset + j];
  }
};

inline int piece_at(const SplineView& view, const HeldSpot& spot, int curve, double x) noexcept {
  if (curve >= kCurves) return find_piece(view, x);
  int& piece = spot.hold->curve[curve].piece;
  return piece = find_piece(view, x, piece);
}

template <int kOrder>
const HeldCurve& held_curve(const HeldSpot& spot, int curve, int first) noexcept {
  HeldCurve& held = spot.hold->curve[curve];
  if (held.first != first) {
    const auto live = live_controls<kOrder>(spot.mesh_spot(), curve, first);
    for (int k = 0; k < kOrder; ++k) held.b[k] = live.b[k];
    held.first = first;
  }
  return held;
}

template <int kOrder>
LiveControls<kOrder, double> live_controls(const HeldSpot& spot, int curve, int first) noexcept {
  if (curve >= kCurves) return live_controls<kOrder>(spot.mesh_spot(), curve, first);
  const HeldCurve& held = held_curve<kOrder>(spot, curve, first);
  LiveControls<kOrder, double> out;
  for (int k = 0; k < kOrder; ++k) out.b[k] = held.b[k];
  return out;
}

inline double area_before(const SplineView& view, const HeldSpot& spot, int curve, int piece,
                          int first) noexcept {
  if (curve >= kCurves) return area_before(view, spot.mesh_spot(), curve, piece, first);
  HeldCurve& held = spot.hold->curve[curve];
  if (held.area_piece != piece) {
    held.area_J = area_before(view, spot.mesh_spot(), curve, piece, first);
    held.area_piece = piece;
  }
  return held.area_J;
}

template <class T>
const RingBed<double, kRings>& bed_under(const CurveViews&, const HeldSpot& spot) noexcept {
  return spot.hold->bed;
}

/// The footing of the standing spot; of a body of rings on the bed that is_held says is at hand.
template <class F>
auto footing_of(const AssetView& asset, const Hold& hold, bool is_held,
                const MeshSpot<double>& spot, const Vec3d& x) noexcept {
  if constexpr (std::is_same_v<F, Rings>)
    if (is_held) return F::footing_on(hold.bed, spot, x);
  return F::footing(asset.curves, spot, x);
}

inline bool is_frictionless(const CurveViews&, const HeldSpot& spot) noexcept {
  return spot.hold->is_frictionless;
}

}  // namespace runtime
}  // namespace palpate
