// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// What a contact point that stands still need not compute again: where it is, its three corners'
// curves blended into one, its other numbers, the bed of rings under it. Nothing here is a result
// of its own; every number is the one that mesh_surface.hpp would bring, bit for bit, so the cache
// may be dropped at any time.

#include "mesh_surface.hpp"

namespace palpate {
namespace runtime {

constexpr int kMaxCachedNumbers = 16;

/// Of one contact point on one asset. It is good as long as that is where the contact stands.
struct SpotCache {
  const float* of = nullptr;  ///< controls of the asset; null: nothing is cached
  int triangle = -1;
  bool is_ball = false, is_frictionless = false;
  double weight[3] = {0, 0, 0};
  Vec3d point{0, 0, 0}, normal{0, 0, 0};
  double length = 1;                      ///< of the blended normal
  CurvePiece<double> curve[kCurves];      ///< around the depth of the last tick
  double number[kMaxCachedNumbers] = {};  ///< of the parts that are no curves, blended
  int number_offset = 0;                  ///< of the first of them in a vertex's controls
  RingBed<double, kRings> bed = {};       ///< of a body of rings
};

inline void clear(SpotCache& cache) noexcept { cache.of = nullptr; }

inline bool is_good(const SpotCache& cache, const AssetView& asset, int triangle,
                    const double weight[3], bool is_ball) noexcept {
  return cache.of == asset.control && cache.triangle == triangle && cache.is_ball == is_ball &&
         cache.weight[0] == weight[0] && cache.weight[1] == weight[1] &&
         cache.weight[2] == weight[2];
}

/// A Spot of slide.hpp: the standing one, out of a good SpotCache.
struct CachedSpot {
  Vec3d point, normal;
  SpotCache* cache;
  const AssetView* asset;

  MeshSpot<double> mesh_spot() const noexcept {
    MeshSpot<double> spot;
    spot.point = point;
    spot.normal = normal;
    spot.length = cache->length;
    for (int k = 0; k < 3; ++k) {
      const std::ptrdiff_t v = asset->corner(cache->triangle, k);
      spot.n[k] = cache->weight[k];
      spot.node[k] = asset->control + v * asset->controls_per_vertex;
    }
    spot.offset = asset->control_offset;
    return spot;
  }
  double control(int part, int j) const noexcept {
    return asset->curves.view[part].pieces > 0
               ? mesh_spot().control(part, j)
               : cache->number[asset->control_offset[part] - cache->number_offset + j];
  }
};

inline const CurvePiece<double>& piece_under(const CurveViews& views, const CachedSpot& spot,
                                             int curve, double x, bool with_area) noexcept {
  CurvePiece<double>& cached = spot.cache->curve[curve];
  const SplineView& view = views.view[curve];
  const bool is_right = cached.piece >= 0 && cached.has_area >= with_area && x >= cached.knot &&
                        (cached.piece == view.pieces || x < view.knots[cached.piece + 1]);
  if (!is_right) cached = piece_under(views, spot.mesh_spot(), curve, x, with_area);
  return cached;
}

inline bool lacks_lateral(const CurveViews&, const CachedSpot& spot) noexcept {
  return spot.cache->is_frictionless;
}
template <class T>
const RingBed<double, kRings>& bed_under(const CurveViews&, const CachedSpot& spot) noexcept {
  return spot.cache->bed;
}

/// Fills the cache for a contact point.
template <class F>
void fill(SpotCache& cache, const AssetView& asset, int triangle, const double weight[3],
          bool is_ball, const MeshSpot<double>& spot) noexcept {
  cache.of = asset.control;
  cache.triangle = triangle;
  cache.is_ball = is_ball;
  cache.is_frictionless = F::is_frictionless(asset.curves, spot);
  for (int k = 0; k < 3; ++k) cache.weight[k] = weight[k];
  cache.point = spot.point;
  cache.normal = spot.normal;
  cache.length = spot.length;
  for (CurvePiece<double>& piece : cache.curve) piece.piece = -1;
  if constexpr (F::kNumbers > 0) {
    static_assert(F::kNumbers <= kMaxCachedNumbers, "room for them");
    cache.number_offset = asset.control_offset[F::kCurves];
    copy_controls(spot, F::kCurves, 0, F::kNumbers, cache.number);
  }
  if constexpr (std::is_same_v<F, Rings>) make_ring_bed(asset.curves.rings, spot, cache.bed);
}

}  // namespace runtime
}  // namespace palpate
