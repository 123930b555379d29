#pragma once

// The usual haptic baseline: a god-object on the same mesh, a spring to it, a friction cone.
// Source: Zilles and Salisbury (1995), doi:10.1109/IROS.1995.525876; Ruspini, Kolarov and Khatib
// (1997), doi:10.1145/258734.258878. For benchmarks only.

#include "libfit/runtime/engine.hpp"

namespace palpate::tools {

/// A point that stays on the surface while the tip goes below it; the force is a spring between
/// them.
class FingerProxy {
 public:
  FingerProxy(const runtime::AssetView& asset, double stiffness_N_m, double friction) noexcept
      : asset_(asset), stiffness_N_m_(stiffness_N_m), friction_(friction) {}

  /// Force on the body at a tip [m]; zero in the air.
  runtime::Vec3d tick(const double tip_m[3]) noexcept { return deflection(tip_m) * stiffness_N_m_; }

  /// Where the proxy is [m], of the latest tick in contact.
  runtime::Vec3d place() const noexcept {
    return proxy_ + runtime::make_vec3<double>(asset_.origin_m);
  }

  /// From the proxy to the tip [m]; zero in the air.
  runtime::Vec3d deflection(const double tip_m[3]) noexcept {
    using namespace runtime;
    const Vec3d x = make_vec3<double>(tip_m) - make_vec3<double>(asset_.origin_m);
    const Vec3d before = has_tip_ ? before_ : x;
    has_tip_ = true;
    before_ = x;
    if (triangle_ < 0) {
      const Entry entry = first_entry(asset_, before, x);
      triangle_ = entry.triangle;
      if (triangle_ < 0) return {0, 0, 0};
      proxy_ = before + (x - before) * entry.along;
    }
    for (int step = 0; step < kMaxSteps && follow(x); ++step) {
    }
    const Vec3d inward = normalized(asset_.area_vector(triangle_)) * -1.0;
    if (dot(x - proxy_, inward) <= 0) {
      triangle_ = -1;
      return {0, 0, 0};
    }
    return x - proxy_;
  }

 private:
  static constexpr int kMaxSteps = 16;

  // Moves the proxy towards the tip's foot within its triangle, as far as friction lets it. True
  // when it crossed into a neighbour and has to go on.
  bool follow(const runtime::Vec3d& x) noexcept {
    using namespace runtime;
    const Vec3d area = asset_.area_vector(triangle_), inward = normalized(area) * -1.0;
    const Vec3d delta = x - proxy_;
    const double depth = dot(delta, inward);
    const Vec3d aside = delta - inward * depth;
    const double length = std::sqrt(dot(aside, aside)), cone = friction_ * (depth > 0 ? depth : 0);
    if (!(length > cone)) return false;
    const Vec3d goal = proxy_ + aside * ((length - cone) / length);
    const double scale = 1 / dot(area, area);
    double share = 1;
    int exit = -1;
    for (int k = 0; k < 3; ++k) {
      const Vec3d a = asset_.vertex_at(asset_.corner(triangle_, (k + 1) % 3));
      const Vec3d e = asset_.vertex_at(asset_.corner(triangle_, (k + 2) % 3)) - a;
      const Vec3d in = cross(area, e);
      const double from = dot(proxy_ - a, in) * scale, to = dot(goal - a, in) * scale;
      if (to < 0 && to < from) {
        const double until = from > 0 ? from / (from - to) : 0;
        if (until < share) {
          share = until;
          exit = k;
        }
      }
    }
    proxy_ = proxy_ + (goal - proxy_) * share;
    if (exit < 0) return false;
    const int next = asset_.neighbour[3 * triangle_ + (exit + 1) % 3];
    if (next < 0) return false;
    triangle_ = next;
    return true;
  }

  const runtime::AssetView& asset_;
  double stiffness_N_m_, friction_;
  bool has_tip_ = false;
  runtime::Vec3d before_{0, 0, 0}, proxy_{0, 0, 0};
  int triangle_ = -1;
};

}  // namespace palpate::tools
