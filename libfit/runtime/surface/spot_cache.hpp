// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// Cache of a contact point that stands still: its place, its three corners'
// curves blended into one, its other numbers, the bed of rings under it. Nothing here is a result
// of its own; every number is the one that mesh_surface.hpp would bring, bit for bit, so the cache
// may be dropped at any time.

#include "mesh_surface.hpp"

namespace palpate::runtime {

/// Cache of one contact point on one asset. It is good as long as the contact stands there.
struct SpotCache {
  const double* basis = nullptr;  ///< basis_of() the asset; null: nothing is cached
  int triangle = -1;
  bool is_ball = false, is_frictionless = false;
  double weight[3] = {0, 0, 0};
  Vec3d point{0, 0, 0}, normal{0, 0, 0};
  double length = 1;                  ///< of the blended normal
  CurvePiece<double> curve[kCurves];  ///< around the depth of the last tick
  RingNumbers<double> numbers = {};   ///< of a body of rings
  RingBed<double> bed = {};           ///< likewise
  Corners corners;
};

inline void clear(SpotCache& cache) noexcept { cache.basis = cache.corners.basis = nullptr; }

inline bool is_good(const SpotCache& cache, const AssetView& asset, int triangle,
                    const double weight[3], bool is_ball) noexcept {
  return cache.basis == basis_of(asset) && cache.triangle == triangle && cache.is_ball == is_ball &&
         cache.weight[0] == weight[0] && cache.weight[1] == weight[1] &&
         cache.weight[2] == weight[2];
}

/// A Spot of slide.hpp: the standing one, out of a good SpotCache.
struct CachedSpot {
  Vec3d point, normal;
  SpotCache* cache;
  const AssetView* asset;

  MeshSpot<double> mesh_spot() const noexcept {
    const double* n = cache->weight;
    const Corners& at = cache->corners;
    return {point,
            normal,
            cache->length,
            {n[0], n[1], n[2]},
            {&at[0], &at[1], &at[2]},
            asset->control_offset};
  }
  double control(int part, int j) const noexcept { return mesh_spot().control(part, j); }
};

inline bool covers(const CurvePiece<double>& piece, const SplineView& view, double x) noexcept {
  return piece.piece >= 0 && x >= piece.knot &&
         (piece.piece == view.pieces || x < view.knots[piece.piece + 1]);
}

/// The corners' polynomials, blended, with the area below.
inline const CurvePiece<double>& piece_at(const CurveViews& views, const CachedSpot& spot,
                                          int curve, double x, bool) noexcept {
  const SplineView& view = views.view[curve];
  CurvePiece<double>& out = spot.cache->curve[curve];
  if (covers(out, view, x)) return out;
  const CurvePiece<double>* corner[3];
  for (int k = 0; k < 3; ++k) {
    Corner& at = spot.cache->corners[k];
    CurvePiece<double>& own = at.curve[curve];
    if (!covers(own, view, x))
      own = piece_at(views, CornerSpot{at.node, spot.asset->control_offset}, curve, x, true);
    corner[k] = &own;
  }
  out.piece = corner[0]->piece;
  out.order = corner[0]->order;
  out.knot = corner[0]->knot;
  const double* n = spot.cache->weight;
  for (int m = 0; m <= kMaxDegree; ++m)
    out.c[m] = n[0] * corner[0]->c[m] + n[1] * corner[1]->c[m] + n[2] * corner[2]->c[m];
  out.area_J = n[0] * corner[0]->area_J + n[1] * corner[1]->area_J + n[2] * corner[2]->area_J;
  return out;
}

inline bool lacks_lateral(const CurveViews&, const CachedSpot& spot) noexcept {
  return spot.cache->is_frictionless;
}
template <class T>
const RingNumbers<double>& ring_numbers(const CachedSpot& spot) noexcept {
  return spot.cache->numbers;
}
template <class T>
const RingBed<double>& bed_at(const CurveViews&, const CachedSpot& spot) noexcept {
  return spot.cache->bed;
}

/// Fills the cache for a contact point whose corners it has.
template <class F>
void fill(SpotCache& cache, const AssetView& asset, int triangle, const double weight[3],
          bool is_ball, const MeshSpot<double>& spot) noexcept {
  cache.basis = basis_of(asset);
  cache.triangle = triangle;
  cache.is_ball = is_ball;
  cache.is_frictionless = F::is_frictionless(asset.curves, spot);
  for (int k = 0; k < 3; ++k) cache.weight[k] = weight[k];
  cache.point = spot.point;
  cache.normal = spot.normal;
  cache.length = spot.length;
  for (CurvePiece<double>& piece : cache.curve) piece.piece = -1;
  if constexpr (std::is_same_v<F, Rings>) {
    const double* row = cache.corners.row_at(weight);
    const double* number = row + kNumbersAt;
    cache.numbers.limit = {number[0], number[1], number[2]};
    for (int i = 0; i < 6; ++i) cache.numbers.curvature[i] = number[3 + i];
    make_ring_bed(row + kStiffnessAt, cache.numbers.limit, row[kSpreadAt], row + kSideAt,
                  spot.normal, cache.bed);
  }
}

}  // namespace palpate::runtime
