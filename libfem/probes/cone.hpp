#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "libfem/probes/sphere.hpp"

namespace palpate::fem {

/// Cone of half angle alpha (axis to flank) without end, its tip a ball of radius t that meets the
/// flank smoothly. The reference point is the ball's pole. Pieces: ball, flank; C1 where they join,
/// t cos(alpha) from the axis. The medial axis is the axis above the ball's centre.
struct ConeShape {
  static constexpr ProbeParameter kParameters[] = {
      {"half_angle", "between the axis and the flank", "30 deg", Dimension::angle},
      {"tip_radius", "of the rounded tip", "0.5 mm"}};
  static constexpr double kMin_rad = std::numbers::pi / 180, kMax_rad = 89 * kMin_rad;

  static double half_angle_rad(const ProbeGeometry& probe) { return probe.number[0]; }
  static double tip_radius_m(const ProbeGeometry& probe) { return probe.number[1]; }

  static std::string complete(ProbeGeometry& probe) {
    if (half_angle_rad(probe) < kMin_rad - 1e-12 || half_angle_rad(probe) > kMax_rad + 1e-12)
      return "half_angle must be from 1 to 89 degrees";
    return {};
  }

  static SignedDistance signed_distance(const ProbeGeometry& probe, const Vec3& axis,
                                        const Vec3& offset) {
    const double t = tip_radius_m(probe);
    const double sine = std::sin(half_angle_rad(probe)), cosine = std::cos(half_angle_rad(probe));
    const AxialPlace at = axial_place(axis, offset);
    const double above = at.height_m - t;  // of the ball's centre
    if (at.away_m * sine + above * cosine <= 0)
      return SphereShape::about_centre(t, offset + t * axis);
    SignedDistance out;
    out.distance_m = at.away_m * cosine - above * sine - t;
    out.gradient = cosine * at.outward + sine * axis;
    if (at.away_m > 0) {
      const Vec3 round = axis.cross(at.outward);
      out.hessian = cosine / at.away_m * round * round.transpose();
    }
    return out;
  }

  static BoundingBall bounding_ball(const ProbeGeometry&) { return {}; }

  /// Depth at which the contact is `a` wide (Sneddon 1965, eq. 4.2):
  /// d = a int_0^a f'(r) / sqrt(a^2 - r^2) dr over the profile f.
  static double depth_of(const ProbeGeometry& probe, double a) {
    const double t = tip_radius_m(probe);
    const double sine = std::sin(half_angle_rad(probe)), cosine = std::cos(half_angle_rad(probe));
    const double joint = t * cosine;
    if (a <= joint) return a * std::atanh(a / t);
    return a * (std::log((a + t) / (std::sqrt(a * a - joint * joint) + t * sine)) +
                cosine / sine * std::acos(joint / a));
  }

  static double contact_radius_m(const ProbeGeometry& probe, double depth_m) {
    double low = 0, high = tip_radius_m(probe);
    while (depth_of(probe, high) < depth_m) {
      low = high;
      high *= 2;
    }
    for (int halving = 0; halving < 60; ++halving) {
      const double middle = (low + high) / 2;
      (depth_of(probe, middle) < depth_m ? low : high) = middle;
    }
    return high;
  }
  static double half_width_m(const ProbeGeometry&) {
    return std::numeric_limits<double>::infinity();
  }
};

}  // namespace palpate::fem
