#pragma once

// How deep a tool stands in an asset, by geometry alone: what a walk holds the engine's contacts
// against.

#include "libfit/runtime/engine.hpp"

namespace palpate::test {

/// How deep p [m], relative to the asset's origin, lies below the surface on which a tip (radius 0)
/// or a ball's centre rests, c - R u(c), with its facets between those of its vertices; of
/// triangles that are measured. Below 0 outside and beside a border; -within_m where it is farther
/// away than that.
inline double depth_in_surface_m(const runtime::AssetView& asset, const runtime::Vec3d& p,
                                 double radius_m, double within_m = 0.02) {
  double nearest_m = within_m;
  bool is_below = false;
  int stack[runtime::kMaxTreeDepth + 2], size = 0;
  stack[size++] = 0;
  while (size > 0) {
    const int at = stack[--size];
    const runtime::TreeNode& node = asset.tree[at];
    const double reach_m = nearest_m + radius_m;
    if (runtime::squared_distance(node, p) > reach_m * reach_m) continue;
    if (node.items == 0) {
      stack[size++] = node.at;
      stack[size++] = at + 1;
    }
    for (int i = 0; i < node.items; ++i) {
      const int t = asset.tree_item[node.at + i];
      runtime::Vec3d corner[3], way{0, 0, 0};
      bool is_measured = true;
      for (int k = 0; k < 3; ++k)
        is_measured &= asset.covered[asset.corner(t, k)] == runtime::kMeasured;
      if (!is_measured) continue;
      for (int k = 0; k < 3; ++k)
        corner[k] = asset.vertex_at(asset.corner(t, k)) -
                    asset.normal_at(asset.corner(t, k)) * radius_m - p;
      double n[3];
      runtime::closest_to_origin(corner[0], corner[1], corner[2], n);
      for (int k = 0; k < 3; ++k) way = way + corner[k] * n[k];
      const double distance_m = std::sqrt(dot(way, way));
      if (!(distance_m < nearest_m)) continue;
      nearest_m = distance_m;
      is_below = dot(way, runtime::blended_normal(asset, t, n)) < -0.5 * distance_m;
    }
  }
  return is_below ? nearest_m : -nearest_m;
}

}  // namespace palpate::test
