#pragma once

#include <algorithm>
#include <cmath>

#include "libfem/probes/sphere.hpp"

namespace palpate::fem {

/// Capsule: all points within R of a segment along own z, `length` from end to end. Upright (own z
/// into the body) it presses with one end and its reference point is that end's pole; lying (own x
/// into the body) with its side, at the middle of it.
struct CapsuleShape {
  static constexpr ProbeParameter kParameters[] = {{"radius", "of the ends and the side", "5 mm"},
                                                   {"length", "from end to end", "40 mm"}};

  static double radius_m(const ProbeGeometry& probe) { return probe.number[0]; }
  static double half_segment_m(const ProbeGeometry& probe) {
    return std::max(0.0, probe.number[1] / 2 - probe.number[0]);
  }
  /// Direction into the body, in own axes.
  static Vec3 inward(const ProbeGeometry& probe) { return probe.turn.row(2); }
  static bool is_lying(const ProbeGeometry& probe) { return std::abs(inward(probe).z()) < 1e-9; }

  static std::string complete(ProbeGeometry& probe) {
    if (probe.number[1] < 2 * probe.number[0])
      return "length must be at least two radii: it is measured from end to end";
    const double end =
        is_lying(probe) ? 0 : std::copysign(half_segment_m(probe), inward(probe).z());
    probe.touch = end * Vec3::UnitZ() + radius_m(probe) * inward(probe);
    return {};
  }

  static SignedDistance signed_distance(const ProbeGeometry& probe, const Vec3& axis,
                                        const Vec3& offset) {
    const double R = radius_m(probe), half = half_segment_m(probe);
    return in_own_axes(probe, axis, offset, [&](const Vec3& x) {
      if (std::abs(x.z()) >= half) {
        const Vec3 end(0, 0, std::copysign(half, x.z()));
        return SphereShape::about_centre(R, x - end);
      }
      SignedDistance out;
      const double r = std::hypot(x.x(), x.y());
      out.distance_m = r - R;
      if (r < 1e-9 * R) return out;
      out.gradient = Vec3(x.x() / r, x.y() / r, 0);
      const Vec3 around(-out.gradient.y(), out.gradient.x(), 0);
      out.hessian = around * around.transpose() / r;
      return out;
    });
  }

  static BoundingBall bounding_ball(const ProbeGeometry& probe) {
    return ball_about_origin(probe, half_segment_m(probe) + radius_m(probe));
  }

  /// Across the axis a lying capsule is as wide as a ball's contact.
  static double contact_radius_m(const ProbeGeometry& probe, double depth_m) {
    return std::sqrt(radius_m(probe) * std::min(depth_m, radius_m(probe)));
  }
  /// Along a line: up to twice, for elements as fine as across it would be wanted along all of it.
  static double mesh_length_m(const ProbeGeometry& probe, double depth_m) {
    const double radius = contact_radius_m(probe, depth_m);
    const ContactLine line = contact_line_m(probe, depth_m);
    return radius + std::min(radius, 0.5 * (line.to - line.from).norm());
  }
  /// Lying it touches along its whole segment at once, tilted from one end on.
  static ContactLine contact_line_m(const ProbeGeometry& probe, double depth_m) {
    const Vec3 along = half_segment_m(probe) * probe.turn.col(2);
    if (is_lying(probe)) return {-along, along};
    const Vec3 across(along.x(), along.y(), 0);
    const double share = std::min(2.0, depth_m / std::max(std::abs(along.z()), 1e-12));
    return {Vec3::Zero(), std::copysign(share, -along.z()) * across};
  }
  static double tip_radius_m(const ProbeGeometry& probe) { return radius_m(probe); }
  static double half_width_m(const ProbeGeometry& probe) {
    return radius_m(probe) + half_segment_m(probe) * inward(probe).head<2>().norm();
  }
};

}  // namespace palpate::fem
