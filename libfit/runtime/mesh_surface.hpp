// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// The contact point on the asset's triangles, as a Surface of slide.hpp: it walks from triangle to
// triangle, keeps to borders, and holds back slips that would create energy.

#include "view.hpp"

namespace palpate {
namespace runtime {

constexpr double kAlongEdge = 1e-12;    ///< share of a direction below which it follows the edge
constexpr double kEnergyNoise = 1e-13;  ///< rounding of a stored energy, relative; measured 2e-15
constexpr int kMaxGuardSteps = 12;  ///< bisections for the harmless part of a slip: 1/4096 of it

// What happened at a tick besides the state, or-ed together.
constexpr unsigned kFlagUnfinished = 1;  ///< the slip goes on at the next tick
constexpr unsigned kFlagBorder = 2;      ///< the contact point was at a border that held it
constexpr unsigned kFlagHeldBack = 4;    ///< the guard refused part of a slip
constexpr unsigned kFlagTooDeep = 8;     ///< dz is beyond the triangle's max_depth_m
constexpr unsigned kFlagFrictionless =
    16;  ///< no lateral stiffness here: slides as if frictionless

/// A spot of the mesh: everything blended by area coordinates n [1].
template <class S>
struct MeshSpot {
  Vec3<S> point, normal;
  S n[3];
  const float* node[3];  ///< controls of the corners
  const int* offset;     ///< of each curve and of the lean within them
  S control(int curve, int j) const noexcept {
    const int at = offset[curve] + j;
    return n[0] * double(node[0][at]) + n[1] * double(node[1][at]) + n[2] * double(node[2][at]);
  }
  Vec3<S> lean(int j) const noexcept {
    return {control(kLean, 3 * j), control(kLean, 3 * j + 1), control(kLean, 3 * j + 2)};
  }
};

/// A straight way within one triangle: area coordinates n(s) = n + s rate.
struct MeshPath {
  const AssetView* asset;
  int triangle;
  double n[3], rate[3];  ///< [1], [1/m]
  double end_m;          ///< where a coordinate reaches zero
  int exit;              ///< which one
  bool blocked;          ///< a border leaves no way to go

  double end() const noexcept { return end_m; }
  bool is_blocked() const noexcept { return blocked; }
  const MeshPath& plain() const noexcept { return *this; }

  template <class S>
  MeshSpot<S> at(const S& s) const noexcept {
    MeshSpot<S> spot;
    Vec3<S> field{S(0), S(0), S(0)};
    spot.point = field;
    for (int k = 0; k < 3; ++k) {
      const int v = asset->corner(triangle, k);
      spot.n[k] = s * rate[k] + n[k];
      spot.point = spot.point + widened<S>(asset->vertex_at(v)) * spot.n[k];
      field = field + widened<S>(asset->normal_at(v)) * spot.n[k];
      spot.node[k] = asset->control + static_cast<std::ptrdiff_t>(v) * asset->controls_per_vertex;
    }
    spot.normal = normalized(field);
    spot.offset = asset->control_offset;
    return spot;
  }
};

/// Stored energy of a spot [J]: the corners' curve energies blended, exact polynomials.
inline double stored_energy_J(const CurveViews& views, const MeshSpot<double>& spot,
                              const Vec3d& x) noexcept {
  const auto d = deflection(views, spot, x);
  double sum = 0;
  for (int k = 0; k < 3; ++k)
    sum += spot.n[k] *
           (curve_energy(views.view[kNormal], spot.node[k] + spot.offset[kNormal], d.normal_m) +
            curve_energy(views.view[kLateral], spot.node[k] + spot.offset[kLateral], d.lateral_m));
  return sum;
}

class MeshSurface {
 public:
  MeshSurface(const AssetView& asset, int triangle, const double n[3]) noexcept
      : asset_(asset), triangle_(triangle), n_{n[0], n[1], n[2]} {}

  int triangle() const noexcept { return triangle_; }
  const double* weights() const noexcept { return n_; }
  unsigned flags() const noexcept { return flags_; }
  double dissipated_J() const noexcept { return dissipated_J_; }
  double refused_J() const noexcept { return refused_J_; }

  MeshSpot<double> standing() const noexcept {
    const MeshPath here{&asset_, triangle_, {n_[0], n_[1], n_[2]}, {0, 0, 0}, 0, 0, false};
    return here.at(0.0);
  }

  /// The way along a lateral unit vector, projected onto the triangle along the spot's normal, so
  /// that s metres shorten the lateral deflection by s. At a border only its part along the edge.
  MeshPath aim(const Vec3d& lateral) noexcept {
    MeshPath path{&asset_, triangle_, {n_[0], n_[1], n_[2]}, {0, 0, 0}, 1e300, 0, false};
    const Vec3d area = asset_.area_vector(triangle_), normal = standing().normal;
    set_rates(path, lateral - normal * (dot(lateral, area) / dot(normal, area)), area);
    for (int k = 0; k < 3; ++k)
      if (leaves(path, k) && is_wall(k)) {
        flags_ |= kFlagBorder;
        follow_edge(path, k, lateral, normal);
        break;
      }
    for (int k = 0; k < 3; ++k)
      if (leaves(path, k) && is_wall(k)) path.blocked = true;
    find_end(path);
    return path;
  }

  /// Goes to path(s), s <= end, and over the edge when s reaches it.
  Move move(const MeshPath& path, double s, const Vec3d& x) noexcept {
    const double before_J = stored_energy_J(asset_.curves, path.at(0.0), x);
    double after_J = stored_energy_J(asset_.curves, path.at(s), x);
    const double allowed_J = before_J * (1 + kEnergyNoise);
    const bool is_held_back = asset_.has_guard && after_J > allowed_J;
    if (is_held_back) {
      const double wanted_J = after_J;
      s = harmless_part(path, s, x, allowed_J, &after_J);
      if (!(s > 0)) after_J = before_J;
      refused_J_ += wanted_J - after_J;
      flags_ |= kFlagHeldBack;
    }
    dissipated_J_ += before_J - after_J;
    go(path, s);
    return is_held_back ? Move::stopped : Move::whole;
  }

 private:
  int across(int k) const noexcept {  // the triangle beyond the edge opposite corner k
    return asset_.neighbour[3 * triangle_ + (k + 1) % 3];
  }
  bool is_wall(int k) const noexcept { return across(k) < 0 || !asset_.is_solid(across(k)); }

  static double smallest_rate(const MeshPath& path) noexcept {
    double largest = 0;
    for (double rate : path.rate) largest = std::fabs(rate) > largest ? std::fabs(rate) : largest;
    return kAlongEdge * largest;
  }
  static bool leaves(const MeshPath& path, int k) noexcept {
    return !(path.n[k] > 0) && path.rate[k] < -smallest_rate(path);
  }

  // d n_k / ds for a motion d in the plane: d . (area x e_k) / |area|^2, e_k the edge opposite k.
  void set_rates(MeshPath& path, const Vec3d& d, const Vec3d& area) const noexcept {
    const double scale = 1 / dot(area, area);
    for (int k = 1; k < 3; ++k) path.rate[k] = dot(d, cross(area, edge(k))) * scale;
    path.rate[0] = -path.rate[1] - path.rate[2];
  }
  Vec3d edge(int k) const noexcept {
    return asset_.vertex_at(asset_.corner(triangle_, (k + 2) % 3)) -
           asset_.vertex_at(asset_.corner(triangle_, (k + 1) % 3));
  }
  void follow_edge(MeshPath& path, int k, const Vec3d& lateral,
                   const Vec3d& normal) const noexcept {
    const Vec3d e = edge(k), shadow = e - normal * dot(e, normal);
    const double squared = dot(shadow, shadow);
    const double rate = squared > 0 ? dot(lateral, shadow) / squared : 0;
    // Across the edge nothing shortens dr any more: a share below a millionth counts as none.
    const bool is_across = !(rate * rate * squared > 1e-12);
    path.blocked = is_across;
    path.rate[k] = 0;
    path.rate[(k + 1) % 3] = is_across ? 0 : -rate;
    path.rate[(k + 2) % 3] = is_across ? 0 : rate;
  }
  static void find_end(MeshPath& path) noexcept {
    const double smallest = smallest_rate(path);
    for (int k = 0; k < 3; ++k) {
      if (!(path.rate[k] < -smallest)) continue;
      const double end = path.n[k] > 0 ? path.n[k] / -path.rate[k] : 0;
      if (end < path.end_m) {
        path.end_m = end;
        path.exit = k;
      }
    }
  }

  double harmless_part(const MeshPath& path, double s, const Vec3d& x, double allowed_J,
                       double* energy_J) const noexcept {
    double lo = 0, hi = s;
    for (int i = 0; i < kMaxGuardSteps; ++i) {
      const double middle = 0.5 * (lo + hi);
      const double middle_J = stored_energy_J(asset_.curves, path.at(middle), x);
      if (middle_J > allowed_J) {
        hi = middle;
      } else {
        lo = middle;
        *energy_J = middle_J;
      }
    }
    return lo;
  }

  void go(const MeshPath& path, double s) noexcept {
    const bool reaches_edge = s >= path.end_m;
    double sum = 0;
    for (int k = 0; k < 3; ++k) {
      const double n = path.n[k] + s * path.rate[k];
      n_[k] = n > 0 && !(reaches_edge && k == path.exit) ? n : 0;
      sum += n_[k];
    }
    for (double& n : n_) n = n / sum;
    if (reaches_edge && !is_wall(path.exit)) cross_edge(path.exit);
  }
  void cross_edge(int k) noexcept {
    const int next = across(k);
    const double old[3] = {n_[0], n_[1], n_[2]};
    for (int j = 0; j < 3; ++j) {
      n_[j] = 0;
      for (int i = 1; i < 3; ++i)
        if (asset_.corner(next, j) == asset_.corner(triangle_, (k + i) % 3))
          n_[j] = old[(k + i) % 3];
    }
    triangle_ = next;
  }

  const AssetView& asset_;
  int triangle_;
  double n_[3];
  unsigned flags_ = 0;
  double dissipated_J_ = 0, refused_J_ = 0;
};

}  // namespace runtime
}  // namespace palpate
