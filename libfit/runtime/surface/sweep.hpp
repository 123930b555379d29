// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// Where a straight way first enters the body: no speed tunnels through.

#include "../asset/view.hpp"

namespace palpate {
namespace runtime {

constexpr double kAimed = 1e-15;  ///< of an area coordinate: a tip aimed at a vertex, to rounding

/// The first entry; triangle is -1 when there is none.
struct Entry {
  int triangle = -1;
  double along = 2;  ///< share of the way, 0 to 1
  double n[3] = {0, 0, 0};
};

/// Whether the segment from p to q may meet the box grown by pad [m]. Never misses; no division.
/// Source: Ericson, Real-Time Collision Detection (2005), 5.3.3.
inline bool may_meet(const TreeNode& box, const Vec3d& p, const Vec3d& q, double pad) noexcept {
  const double from[3] = {p.x, p.y, p.z}, to[3] = {q.x, q.y, q.z};
  double half[3], middle[3], reach[3];
  for (int k = 0; k < 3; ++k) {
    const double lo = double(box.lo[k]), hi = double(box.hi[k]);
    half[k] = 0.5 * (hi - lo) + pad;
    reach[k] = 0.5 * (to[k] - from[k]);
    middle[k] = 0.5 * (from[k] + to[k]) - 0.5 * (lo + hi);
    if (std::fabs(middle[k]) > half[k] + std::fabs(reach[k])) return false;
  }
  for (int k = 0; k < 3; ++k) {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    const double radius =
        half[i] * (std::fabs(reach[j]) + pad) + half[j] * (std::fabs(reach[i]) + pad);
    if (std::fabs(middle[i] * reach[j] - middle[j] * reach[i]) > radius) return false;
  }
  return true;
}

/// Lets `best` be the entry through triangle t if it comes first (ties: the smaller index).
/// p counts as outside down to skin_m below the plane: a tip resting on the surface is not lost.
/// Edges are watertight: neighbours compute the same products with opposite signs.
inline void try_entry(const AssetView& asset, int t, const Vec3d& p, const Vec3d& q,
                      Entry& best) noexcept {
  const Vec3d a = asset.vertex_at(asset.corner(t, 0)) - p;
  const Vec3d b = asset.vertex_at(asset.corner(t, 1)) - p;
  const Vec3d c = asset.vertex_at(asset.corner(t, 2)) - p;
  const Vec3d way = q - p, outward = normalized(asset.area_vector(t));
  const double from = -dot(a, outward), to = from + dot(way, outward);
  if (!(from >= -asset.skin_m && to < 0 && to < from)) return;
  const double n[3] = {dot(way, cross(c, b)), dot(way, cross(a, c)), dot(way, cross(b, a))};
  const double sum = n[0] + n[1] + n[2], least = -kAimed * sum;
  if (!(n[0] >= least && n[1] >= least && n[2] >= least && sum > 0)) return;
  const double along = from > 0 ? from / (from - to) : 0;
  if (along > best.along || (along == best.along && t > best.triangle)) return;
  best.triangle = t;
  best.along = along;
  for (int k = 0; k < 3; ++k) best.n[k] = n[k] > 0 ? n[k] / sum : 0;
}

/// Calls act(t) for the triangles of the tree's leaves, left ones first, below nodes that
/// meets(node) takes.
template <class Meets, class Act>
void visit(const AssetView& asset, const Meets& meets, const Act& act) noexcept {
  int stack[kMaxTreeDepth + 2];
  int size = 0;
  stack[size++] = 0;
  while (size > 0) {
    const int at = stack[--size];
    const TreeNode& node = asset.tree[at];
    if (!meets(node)) continue;
    if (node.items == 0) {
      stack[size++] = node.at;
      stack[size++] = at + 1;
    }
    for (int i = 0; i < node.items; ++i) act(asset.tree_item[node.at + i]);
  }
}

/// First entry through a solid triangle, from outside to inside, on the way from p to q [m],
/// relative to the origin. Work: the tree nodes that the way may meet.
inline Entry first_entry(const AssetView& asset, const Vec3d& p, const Vec3d& q) noexcept {
  Entry best;
  const auto meets = [&](const TreeNode& node) noexcept {
    const Vec3d until = best.triangle < 0 ? q : p + (q - p) * best.along;  // later entries lose
    return may_meet(node, p, until, asset.skin_m);
  };
  visit(asset, meets, [&](int t) noexcept { try_entry(asset, t, p, q, best); });
  return best;
}

/// Whether x [m], relative to the origin, is under the surface: the shortest way out of the box
/// around it leaves through more solid triangles than it enters. Work: as first_entry().
inline bool is_under(const AssetView& asset, const Vec3d& x) noexcept {
  const TreeNode& root = asset.tree[0];
  const double at[3] = {x.x, x.y, x.z};
  double out[3] = {x.x, x.y, x.z}, least = 1e300;
  int axis = 0;
  bool is_up = false;
  for (int k = 0; k < 3; ++k) {
    const double below = at[k] - double(root.lo[k]), above = double(root.hi[k]) - at[k];
    if (!(below > -asset.skin_m && above > -asset.skin_m)) return false;
    const double way = below < above ? below : above;
    if (!(way < least)) continue;
    least = way;
    axis = k;
    is_up = above < below;
  }
  const double beyond = 1e3 * asset.skin_m;
  out[axis] = is_up ? double(root.hi[axis]) + beyond : double(root.lo[axis]) - beyond;
  const Vec3d outside = make_vec3<double>(out);
  int left = 0;
  const auto meets = [&](const TreeNode& node) noexcept {
    return may_meet(node, x, outside, asset.skin_m);
  };
  visit(asset, meets, [&](int t) noexcept {
    Entry leaves, enters;
    try_entry(asset, t, outside, x, leaves);
    try_entry(asset, t, x, outside, enters);
    left += (leaves.triangle >= 0) - (enters.triangle >= 0);
  });
  return left > 0;
}

}  // namespace runtime
}  // namespace palpate
