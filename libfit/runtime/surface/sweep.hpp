// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// First entry of a straight path into the body: no speed tunnels through.

#include "../asset/view.hpp"

namespace palpate::runtime {

/// The first entry; triangle is -1 when there is none.
struct Entry {
  int triangle = -1;
  double along = 2;  ///< share of the path, 0 to 1
  double n[3] = {0, 0, 0};
};

/// Returns true if the segment from p to q may meet the box grown by pad [m]. Never misses; no
/// division. Source: Ericson, Real-Time Collision Detection (2005), 5.3.3.
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
inline void try_entry(const SurfaceView& surface, int t, const Vec3d& p, const Vec3d& q,
                      Entry& best) noexcept {
  const Vec3d a = surface.vertex_at(surface.corner(t, 0)) - p;
  const Vec3d b = surface.vertex_at(surface.corner(t, 1)) - p;
  const Vec3d c = surface.vertex_at(surface.corner(t, 2)) - p;
  const Vec3d path = q - p, outward = normalized(surface.area_vector(t));
  const double from = -dot(a, outward), to = from + dot(path, outward);
  if (!(from >= -surface.skin_m && to < 0 && to < from)) return;
  const double n[3] = {dot(path, cross(c, b)), dot(path, cross(a, c)), dot(path, cross(b, a))};
  const double sum = n[0] + n[1] + n[2], least = -kVertexTolerance * sum;
  if (!(n[0] >= least && n[1] >= least && n[2] >= least && sum > 0)) return;
  const double along = from > 0 ? from / (from - to) : 0;
  if (along > best.along || (along == best.along && t > best.triangle)) return;
  best.triangle = t;
  best.along = along;
  for (int k = 0; k < 3; ++k) best.n[k] = n[k] > 0 ? n[k] / sum : 0;
}

/// Calls act(t) for the triangles of the tree's leaves, left ones first, below nodes that
/// may_hit(node) takes.
template <class Meets, class Act>
void visit(const SurfaceView& surface, const Meets& may_hit, const Act& act) noexcept {
  int stack[kMaxTreeDepth + 2];
  int size = 0;
  stack[size++] = 0;
  while (size > 0) {
    const int at = stack[--size];
    const TreeNode& node = surface.tree[at];
    if (!may_hit(node)) continue;
    if (node.items == 0) {
      stack[size++] = node.at;
      stack[size++] = at + 1;
    }
    for (int i = 0; i < node.items; ++i) act(surface.tree_item[node.at + i]);
  }
}

/// First entry through a solid triangle, from outside to inside, on the path from p to q [m],
/// relative to the origin. Work: the tree nodes that the path may meet.
inline Entry first_entry(const SurfaceView& surface, const Vec3d& p, const Vec3d& q) noexcept {
  Entry best;
  const auto may_hit = [&](const TreeNode& node) noexcept {
    const Vec3d until = best.triangle < 0 ? q : p + (q - p) * best.along;  // later entries lose
    return may_meet(node, p, until, surface.skin_m);
  };
  visit(surface, may_hit, [&](int t) noexcept { try_entry(surface, t, p, q, best); });
  return best;
}

/// Returns true if x [m], relative to the origin, is under the surface: the shortest path out of
/// the box around it leaves through more solid triangles than it enters. Work: as first_entry().
inline bool is_under(const SurfaceView& surface, const Vec3d& x) noexcept {
  const TreeNode& root = surface.tree[0];
  const double at[3] = {x.x, x.y, x.z};
  double out[3] = {x.x, x.y, x.z}, least = 1e300;
  int axis = 0;
  bool is_up = false;
  for (int k = 0; k < 3; ++k) {
    const double below = at[k] - double(root.lo[k]), above = double(root.hi[k]) - at[k];
    if (!(below > -surface.skin_m && above > -surface.skin_m)) return false;
    const double distance = below < above ? below : above;
    if (!(distance < least)) continue;
    least = distance;
    axis = k;
    is_up = above < below;
  }
  const double beyond = 1e3 * surface.skin_m;
  out[axis] = is_up ? double(root.hi[axis]) + beyond : double(root.lo[axis]) - beyond;
  const Vec3d outside = make_vec3<double>(out);
  int left = 0;
  const auto may_hit = [&](const TreeNode& node) noexcept {
    return may_meet(node, x, outside, surface.skin_m);
  };
  visit(surface, may_hit, [&](int t) noexcept {
    Entry leaves, enters;
    try_entry(surface, t, outside, x, leaves);
    try_entry(surface, t, x, outside, enters);
    left += (leaves.triangle >= 0) - (enters.triangle >= 0);
  });
  return left > 0;
}

}  // namespace palpate::runtime
