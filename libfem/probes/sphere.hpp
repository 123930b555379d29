#pragma once

#include <algorithm>
#include <cmath>

#include "libfem/probes/probe_frame.hpp"

namespace palpate::fem {

/// Ball of radius R whose lowest point along the axis u is the reference point: centre = x - R u.
struct SphereShape {
  static constexpr ProbeParameter kParameters[] = {
      {"radius", "of the ball", "5 mm", Dimension::length, false}};

  static double radius_m(const ProbeGeometry& probe) { return probe.number[0]; }

  static std::string complete(ProbeGeometry& probe) {
    if (std::isnan(probe.number[0])) probe.number[0] = kDefaultBallRadius_m;
    return {};
  }

  static SignedDistance about_centre(double radius, const Vec3& from_centre) {
    const double r = from_centre.norm();
    SignedDistance out;
    out.distance_m = r - radius;
    if (r < 1e-9 * radius) return out;  // the centre: no direction, and no contact can act there
    out.gradient = from_centre / r;
    out.hessian = (Mat3::Identity() - out.gradient * out.gradient.transpose()) / r;
    return out;
  }

  static SignedDistance signed_distance(const ProbeGeometry& probe, const Vec3& axis,
                                        const Vec3& offset) {
    return about_centre(radius_m(probe), offset + radius_m(probe) * axis);
  }

  static BoundingBall bounding_ball(const ProbeGeometry& probe) {
    return {-radius_m(probe), radius_m(probe)};
  }

  /// Hertz: sqrt(R d), and R from d = R on.
  static double contact_radius_m(const ProbeGeometry& probe, double depth_m) {
    return std::sqrt(radius_m(probe) * std::min(depth_m, radius_m(probe)));
  }
  static double tip_radius_m(const ProbeGeometry& probe) { return radius_m(probe); }
  static double half_width_m(const ProbeGeometry& probe) { return radius_m(probe); }
};

}  // namespace palpate::fem
