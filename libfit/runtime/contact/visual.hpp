// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// A mesh of the user's own, for the eye, whose vertices hang on the triangles of the surface.

#include <cmath>

#include "../asset/view.hpp"

namespace palpate::runtime {

/// Unit axes of a triangle: along its first edge, across that within the triangle, and outward; all
/// zero where the triangle has no area.
struct TriangleAxes {
  Vec3d axis[3] = {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}};

  TriangleAxes(const Vec3d& a, const Vec3d& b, const Vec3d& c) noexcept {
    const Vec3d edge = b - a, area = cross(edge, c - a);
    const double length = std::sqrt(dot(edge, edge)), twice_area = std::sqrt(dot(area, area));
    if (!(length > 0 && twice_area > 0)) return;
    axis[0] = edge * (1 / length);
    axis[2] = area * (1 / twice_area);
    axis[1] = cross(axis[2], axis[0]);
  }
};

/// Place [m] of vertex i of the visual mesh in the body's frame: the place of its triangle that it
/// hangs on, and its offset, which turns with the triangle. displacement_m: of all vertices of the
/// surface, three each, as deform() fills it; null: at rest. Safe on checked assets.
inline Vec3d visual_place(const AssetView& asset, int i, const float* displacement_m) noexcept {
  const VisualVertex& hung = asset.visual.vertex[i];
  Vec3d corner[3] = {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
  for (int k = 0; k < 3; ++k) {
    const int v = asset.corner(hung.triangle, k);
    corner[k] = asset.vertex_at(v);
    if (displacement_m == nullptr) continue;
    const float* moved = displacement_m + 3 * std::ptrdiff_t{v};
    corner[k] = corner[k] + Vec3d{double(moved[0]), double(moved[1]), double(moved[2])};
  }
  const TriangleAxes axes(corner[0], corner[1], corner[2]);
  const double b = double(hung.weight[0]), c = double(hung.weight[1]);
  Vec3d place = Vec3d{asset.origin_m[0], asset.origin_m[1], asset.origin_m[2]} +
                corner[0] * (1 - b - c) + corner[1] * b + corner[2] * c;
  for (int k = 0; k < 3; ++k) place = place + axes.axis[k] * double(hung.offset_m[k]);
  return place;
}

}  // namespace palpate::runtime
