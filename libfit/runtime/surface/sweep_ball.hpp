// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// First touch of a ball on a straight path: facets, edges and vertices, each by its
// own quadratic, so no speed tunnels through and nothing is stepped.

#include "sweep.hpp"

namespace palpate::runtime {

/// The first touch; triangle is -1 when there is none.
struct BallEntry {
  int triangle = -1;
  double along = 2;         ///< share of the path, 0 to 1
  double n[3] = {0, 0, 0};  ///< area coordinates of the contact point
  Vec3d arm{0, 0, 0};       ///< from the centre there to the contact point
  bool is_inside = false;   ///< the ball began deeper than it may lie: nothing counts
  bool is_clear = true;     ///< nothing that faces the ball was within its radius at the beginning
};

/// u at a place of a triangle (M1).
inline Vec3d blended_normal(const SurfaceView& surface, int t, const double n[3]) noexcept {
  Vec3d field{0, 0, 0};
  for (int k = 0; k < 3; ++k) field = field + surface.normal_at(surface.corner(t, k)) * n[k];
  return normalized(field);
}

/// Area coordinates of the point of triangle a, b, c that is closest to the origin.
/// Source: Ericson, Real-Time Collision Detection (2005), 5.1.5.
inline void closest_to_origin(const Vec3d& a, const Vec3d& b, const Vec3d& c,
                              double n[3]) noexcept {
  const auto set = [&](double n0, double n1, double n2) {
    n[0] = n0;
    n[1] = n1;
    n[2] = n2;
  };
  const Vec3d ab = b - a, ac = c - a;
  const double d1 = -dot(ab, a), d2 = -dot(ac, a);
  if (d1 <= 0 && d2 <= 0) return set(1, 0, 0);
  const double d3 = -dot(ab, b), d4 = -dot(ac, b);
  if (d3 >= 0 && d4 <= d3) return set(0, 1, 0);
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return set(1 - d1 / (d1 - d3), d1 / (d1 - d3), 0);
  const double d5 = -dot(ab, c), d6 = -dot(ac, c);
  if (d6 >= 0 && d5 <= d6) return set(0, 0, 1);
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return set(1 - d2 / (d2 - d6), 0, d2 / (d2 - d6));
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    const double w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return set(0, 1 - w, w);
  }
  const double sum = va + vb + vc;
  set(va / sum, vb / sum, vc / sum);
}

/// A triangle seen from the centre at the path's beginning, and the ball that comes.
struct BallSweep {
  Vec3d corner[3];  ///< relative to the centre [m]
  Vec3d path;
  double radius_m;
};

/// First t in [0, 1] at which a t^2 + 2 b t + c falls to zero from c >= 0, else 2. No cancellation.
inline double falling_root(double a, double b, double c) noexcept {
  const double discriminant = b * b - a * c;
  if (!(b < 0 && c >= 0 && discriminant >= 0)) return 2;
  const double t = c / (-b + std::sqrt(discriminant));
  return t <= 1 ? t : 2;
}

/// When the ball's lowest point may_hit the facet's inside, and where.
inline double facet_touch(const BallSweep& s, double n[3]) noexcept {
  const Vec3d area = cross(s.corner[1] - s.corner[0], s.corner[2] - s.corner[0]);
  const Vec3d outward = normalized(area);
  const double above = -dot(s.corner[0], outward), sinking = -dot(s.path, outward);
  if (!(above >= s.radius_m && sinking > 0 && above - s.radius_m <= sinking)) return 2;
  const double t = (above - s.radius_m) / sinking;
  const Vec3d c = s.path * t - outward * s.radius_m;
  double sum = 0;
  for (int k = 0; k < 3; ++k) {
    const Vec3d p = s.corner[(k + 1) % 3] - c, q = s.corner[(k + 2) % 3] - c;
    n[k] = dot(cross(p, q), outward);
    if (!(n[k] >= 0)) return 2;
    sum += n[k];
  }
  if (!(sum > 0)) return 2;
  for (int k = 0; k < 3; ++k) n[k] = n[k] / sum;
  return t;
}

/// When the ball may_hit the edge from corner k to the next, and where.
inline double edge_touch(const BallSweep& s, int k, double n[3]) noexcept {
  const int next = (k + 1) % 3;
  const Vec3d a = s.corner[k], e = s.corner[next] - a;
  const double ee = dot(e, e);
  const Vec3d from = cross(a, e), go = cross(s.path, e);  // of the line, as the centre sees it
  const double t =
      falling_root(dot(go, go), -dot(from, go), dot(from, from) - s.radius_m * s.radius_m * ee);
  if (t > 1) return 2;
  const double share = dot(s.path * t - a, e) / ee;
  if (!(share >= 0 && share <= 1)) return 2;
  n[k] = 1 - share;
  n[next] = share;
  n[3 - k - next] = 0;
  return t;
}

inline double vertex_touch(const BallSweep& s, int k, double n[3]) noexcept {
  const Vec3d a = s.corner[k];
  const double t =
      falling_root(dot(s.path, s.path), -dot(a, s.path), dot(a, a) - s.radius_m * s.radius_m);
  for (int j = 0; j < 3; ++j) n[j] = j == k ? 1 : 0;
  return t;
}

inline Vec3d at_weights(const BallSweep& s, const double n[3]) noexcept {
  return s.corner[0] * n[0] + s.corner[1] * n[1] + s.corner[2] * n[2];
}

/// Lets `best` be the touch at share t if the normal there faces the ball and it comes first (ties:
/// the nearer, then the smaller triangle).
inline void try_ball_touch(const SurfaceView& surface, int triangle, const BallSweep& s, double t,
                           const double n[3], BallEntry& best) noexcept {
  if (t > best.along) return;
  const Vec3d arm = at_weights(s, n) - s.path * t;
  if (t == best.along) {
    const double nearer = t == 0 ? dot(arm, arm) - dot(best.arm, best.arm) : 0;
    if (nearer > 0 || (nearer == 0 && triangle > best.triangle)) return;
  }
  const double facing = dot(arm, blended_normal(surface, triangle, n));
  if (!(facing > kMinFacing * s.radius_m)) return;
  best.triangle = triangle;
  best.along = t;
  best.arm = arm;
  for (int k = 0; k < 3; ++k) best.n[k] = n[k];
}

/// length: of the path [m].
inline void try_ball_entry(const SurfaceView& surface, int t, const Vec3d& p, const Vec3d& path,
                           double length, double radius_m, BallEntry& best) noexcept {
  BallSweep s{{}, path, radius_m};
  for (int k = 0; k < 3; ++k) s.corner[k] = surface.vertex_at(surface.corner(t, k)) - p;
  double n[3];
  closest_to_origin(s.corner[0], s.corner[1], s.corner[2], n);
  const Vec3d closest = at_weights(s, n);
  const double squared = dot(closest, closest), reach = (radius_m + length) * (1 + 1e-12);
  if (squared > reach * reach) return;  // too far away for this path
  if (squared < radius_m * radius_m) {  // it lies in this triangle already
    const double least = radius_m * (1 - kRestShare);
    const double facing = dot(closest, blended_normal(surface, t, n));
    if (!(facing > kMinFacing * std::sqrt(squared))) return;  // from behind
    best.is_clear = false;
    if (squared < least * least)
      best.is_inside = true;
    else if (dot(closest, path) > 0)
      try_ball_touch(surface, t, s, 0, n, best);
    return;
  }
  const double facet = facet_touch(s, n);
  if (facet <= 1) return try_ball_touch(surface, t, s, facet, n, best);
  for (int k = 0; k < 3; ++k) {
    const double edge = edge_touch(s, k, n);
    if (edge <= 1) try_ball_touch(surface, t, s, edge, n, best);
    const double vertex = vertex_touch(s, k, n);
    if (vertex <= 1) try_ball_touch(surface, t, s, vertex, n, best);
  }
}

/// From a box to the point [m^2].
inline double squared_distance(const TreeNode& box, const Vec3d& p) noexcept {
  const double at[3] = {p.x, p.y, p.z};
  double squared = 0;
  for (int k = 0; k < 3; ++k) {
    const double below = double(box.lo[k]) - at[k], above = at[k] - double(box.hi[k]);
    const double off = below > 0 ? below : (above > 0 ? above : 0);
    squared += off * off;
  }
  return squared;
}

/// First touch of a ball whose centre goes from p to q [m], relative to the origin, with solid
/// triangles that face it. Exact: the roots' rounding is its only error. Work: the tree nodes
/// within the radius of the path, each triangle there at most one facet, three edges and three
/// vertices.
inline BallEntry first_ball_entry(const SurfaceView& surface, const Vec3d& p, const Vec3d& q,
                                  double radius_m) noexcept {
  BallEntry best;
  const Vec3d path = q - p;
  const double pad = radius_m + surface.skin_m, length = std::sqrt(dot(path, path));
  int stack[kMaxTreeDepth + 2];
  int size = 0;
  stack[size++] = 0;
  while (size > 0 && !best.is_inside) {
    const int at = stack[--size];
    const TreeNode& node = surface.tree[at];
    const Vec3d half = best.triangle < 0 ? path * 0.5 : path * (0.5 * best.along);
    const double half_m = std::sqrt(dot(half, half));
    const double reach = (pad + half_m) * (1 + 1e-12);
    if (!(squared_distance(node, p + half) <= reach * reach)) continue;
    if (!may_meet(node, p, p + half + half, pad)) continue;
    if (node.items == 0) {  // the nearer one first: a touch there spares the rest of the path
      const bool is_behind =
          squared_distance(surface.tree[at + 1], p) > squared_distance(surface.tree[node.at], p);
      stack[size++] = is_behind ? at + 1 : node.at;
      stack[size++] = is_behind ? node.at : at + 1;
    }
    for (int i = 0; i < node.items; ++i)
      try_ball_entry(surface, surface.tree_item[node.at + i], p, path, length, radius_m, best);
  }
  return best;
}

}  // namespace palpate::runtime
