// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// The contact point on the asset's triangles, as a Surface of slide.hpp: it walks from triangle to
// triangle, keeps to borders, and goes no farther in a tick than its budget.

#include "../palpate.h"
#include "mesh_spot.hpp"

namespace palpate::runtime {

/// T: double, or a scalar with derivatives for the tangent; decisions read values only.
template <class T, bool kIsBall>
class MeshSurface {
 public:
  using Path = MeshPath<T, kIsBall>;
  using Spot = MeshSpot<T>;

  /// corners: become those of the triangle that the contact point is on. budget_m: how far it may
  /// go.
  MeshSurface(Corners& corners, const AssetView& asset, int triangle, const double n[3],
              const Arm& arm, const T& budget_m = T(1e300)) noexcept
      : corners_(corners),
        asset_(asset),
        arm_(arm),
        triangle_(triangle),
        n_{T(n[0]), T(n[1]), T(n[2])},
        budget_m_(budget_m) {
    corners_.take(asset, triangle);
  }

  int triangle() const noexcept { return triangle_; }
  double weight(int k) const noexcept { return value_of(n_[k]); }
  unsigned flags() const noexcept { return flags_; }
  bool is_spent() const noexcept { return !(value_of(budget_m_) > 0); }
  double budget_m() const noexcept { return value_of(budget_m_); }

  Spot standing() const noexcept {
    if constexpr (std::is_same<T, double>::value)
      return resting().at_row(corners_.row_at(n_));
    else
      return resting().at(T(0));
  }

  /// The path along a lateral unit vector, projected onto the triangle (a ball: onto the triangle
  /// of its rest positions) along the spot's normal (M9), so that s metres shorten the lateral
  /// deflection by s. At a border only its part along the edge. Blocked where a ball is too large
  /// for the hollow.
  Path aim(const Spot& spot, const Vec3<T>& lateral) noexcept {
    Path path = resting();
    path.end_m = budget_m_;
    path.exit = -1;
    if (is_spent()) {
      path.blocked = true;
      return path;
    }
    const Plane plane = plane_at(spot);
    const T facing = dot(spot.normal, plane.area);
    if (kIsBall && is_turned(plane, value_of(facing))) {
      path.blocked = true;
      return path;
    }
    set_rates(path, cross(spot.normal, lateral) * (1.0 / facing), plane);
    const bool is_at_edge = !(value_of(n_[0]) > 0 && value_of(n_[1]) > 0 && value_of(n_[2]) > 0);
    if (is_at_edge) keep_to_borders(path, lateral, spot.normal, plane);
    find_end(path);
    return path;
  }

  /// Goes to path(s), s <= end, and over the edge when s reaches it.
  void move(const Path& path, const T& s) noexcept {
    budget_m_ = budget_m_ - s;
    const bool reaches_edge = path.exit >= 0 && value_of(s) >= value_of(path.end_m);
    T sum = T(0);
    for (int k = 0; k < 3; ++k) {
      const T n = path.n[k] + s * path.rate[k];
      n_[k] = value_of(n) > 0 && !(reaches_edge && k == path.exit) ? n : T(0);
      sum = sum + n_[k];
    }
    for (T& n : n_) n = n / sum;
    if (reaches_edge && !is_wall(path.exit)) cross_edge(path.exit);
  }

 private:
  using G = std::conditional_t<kIsBall, T, double>;  // a ball's rest positions move with n
  struct Plane {
    Vec3<G> corner[3];  ///< of the rest positions, to first order along the path
    Vec3<G> area;       ///< twice the area times the outward normal
  };

  Path resting() const noexcept {
    return {&corners_,
            asset_.control_offset,
            &arm_,
            {n_[0], n_[1], n_[2]},
            {T(0), T(0), T(0)},
            T(0),
            0,
            false,
            false};
  }
  // The unit normal's change has no lateral part but that of the blend: d(u) = (I - u u^T) d(blend)
  // / length. So a ball's rest positions move like the triangle of x_k - (reach / length) u_k.
  Plane plane_at(const Spot& spot) const noexcept {
    Plane plane;
    for (int k = 0; k < 3; ++k) {
      plane.corner[k] = widened<G>(corners_[k].place());
      if constexpr (kIsBall)
        plane.corner[k] = plane.corner[k] - corners_[k].normal() * (arm_.reach_m / spot.length);
    }
    plane.area = cross(plane.corner[1] - plane.corner[0], plane.corner[2] - plane.corner[0]);
    return plane;
  }
  bool is_turned(const Plane& plane, double facing) const noexcept {
    const Vec3d area = values_of(plane.area), facet = asset_.area_vector(triangle_);
    const double squared = dot(area, area);
    return !(-facing > kMinOpen * std::sqrt(squared) &&
             squared > kMinOpen * kMinOpen * dot(facet, facet));
  }

  int across(int k) const noexcept {  // the triangle beyond the edge opposite corner k
    return asset_.neighbour[3 * triangle_ + (k + 1) % 3];
  }
  bool is_wall(int k) const noexcept { return across(k) < 0 || !asset_.is_solid(across(k)); }

  static double smallest_rate(const Path& path) noexcept {
    double largest = 0;
    for (const T& rate : path.rate) {
      const double size = std::fabs(value_of(rate));
      largest = size > largest ? size : largest;
    }
    return kAlongEdge * largest;
  }
  static bool leaves(const Path& path, int k) noexcept {
    return !(value_of(path.n[k]) > 0) && value_of(path.rate[k]) < -smallest_rate(path);
  }

  void keep_to_borders(Path& path, const Vec3<T>& lateral, const Vec3<T>& normal,
                       const Plane& plane) noexcept {
    for (int k = 0; k < 3; ++k)
      if (leaves(path, k) && is_wall(k)) {
        flags_ |= PALPATE_FLAG_BORDER;
        follow_edge(path, k, lateral, normal, plane);
        break;
      }
    for (int k = 0; k < 3; ++k)
      if (leaves(path, k) && is_wall(k)) path.blocked = true;
  }

  // The motion in the plane whose part across u is `lateral`, by Cramer's rule: n_1 grows by
  // det(lateral, e_2, u) / det(e_1, e_2, u), and turned is u x lateral over the latter.
  static void set_rates(Path& path, const Vec3<T>& turned, const Plane& plane) noexcept {
    path.rate[1] = dot(turned, plane.corner[2] - plane.corner[0]);
    path.rate[2] = -dot(turned, plane.corner[1] - plane.corner[0]);
    path.rate[0] = -path.rate[1] - path.rate[2];
  }
  static Vec3<G> edge(const Plane& plane, int k) noexcept {
    return plane.corner[(k + 2) % 3] - plane.corner[(k + 1) % 3];
  }
  static void follow_edge(Path& path, int k, const Vec3<T>& lateral, const Vec3<T>& normal,
                          const Plane& plane) noexcept {
    const Vec3<T> e = widened_all(edge(plane, k)), shadow = e - normal * dot(e, normal);
    const T squared = dot(shadow, shadow);
    const T rate = value_of(squared) > 0 ? dot(lateral, shadow) / squared : T(0);
    // Across the edge nothing shortens dr any more: a share below a millionth counts as none.
    const double share = value_of(rate);
    const bool is_across = !(share * share * value_of(squared) > 1e-12);
    path.blocked = is_across;
    path.is_bent = true;
    path.rate[k] = T(0);
    path.rate[(k + 1) % 3] = is_across ? T(0) : -rate;
    path.rate[(k + 2) % 3] = is_across ? T(0) : rate;
  }
  static Vec3<T> widened_all(const Vec3<G>& p) noexcept { return {T(p.x), T(p.y), T(p.z)}; }
  static void find_end(Path& path) noexcept {
    const double smallest = smallest_rate(path);
    for (int k = 0; k < 3; ++k) {
      if (!(value_of(path.rate[k]) < -smallest)) continue;
      const T end = value_of(path.n[k]) > 0 ? path.n[k] / -path.rate[k] : T(0);
      if (value_of(end) < value_of(path.end_m)) {
        path.end_m = end;
        path.exit = k;
      }
    }
  }

  void cross_edge(int k) noexcept {
    const int next = across(k);
    const T old[3] = {n_[0], n_[1], n_[2]};
    for (int j = 0; j < 3; ++j) {
      n_[j] = T(0);
      for (int i = 1; i < 3; ++i)
        if (asset_.corner(next, j) == asset_.corner(triangle_, (k + i) % 3))
          n_[j] = old[(k + i) % 3];
    }
    triangle_ = next;
    corners_.take(asset_, next);
  }

  Corners& corners_;
  const AssetView& asset_;
  const Arm& arm_;
  int triangle_;
  T n_[3];
  T budget_m_;
  unsigned flags_ = 0;
};

}  // namespace palpate::runtime
