#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "libfem/probes/probes.hpp"

namespace palpate::fem {

/// A frame about an axis: columns are the part of `first` across the axis, the direction across
/// both, and the axis.
inline Mat3 frame_about(const Vec3& axis, const Vec3& first) {
  const Vec3 across = (first - first.dot(axis) * axis).normalized();
  Mat3 frame;
  frame << across, axis.cross(across), axis;
  return frame;
}

/// The probe's frame: its first column is the first direction of drags, the part across the axis of
/// the coordinate axis least along it.
inline Mat3 probe_frame(const Vec3& axis) {
  Eigen::Index least = 0;
  axis.cwiseAbs().minCoeff(&least);
  return frame_about(axis, Vec3::Unit(least));
}

/// Rotation from own axes to the probe's frame that takes `inward` (own axes, any length) to u and
/// own z, or own x where inward is along z, to the first column.
inline Mat3 turn_inward(const Vec3& inward) {
  const Vec3 u = inward.normalized();
  const bool is_along_z = std::hypot(u.x(), u.y()) < 1e-6;
  return frame_about(u, is_along_z ? Vec3::UnitX() : Vec3::UnitZ()).transpose();
}

/// Evaluates a shape described in own axes at an offset from the reference point in the body's
/// axes.
template <class OwnDistance>
SignedDistance in_own_axes(const ProbeGeometry& probe, const Vec3& axis, const Vec3& offset,
                           const OwnDistance& own_distance) {
  const Mat3 turn = probe_frame(axis) * probe.turn;
  SignedDistance out = own_distance(Vec3(probe.touch + turn.transpose() * offset));
  out.gradient = turn * out.gradient;
  out.hessian = turn * out.hessian * turn.transpose();
  return out;
}

/// Position of an offset about the axis: height above the tip's plane, against u, distance from the
/// axis and the unit vector away from it (zero on the axis).
struct AxialPlace {
  double height_m, away_m;
  Vec3 outward;
};

inline AxialPlace axial_place(const Vec3& axis, const Vec3& offset) {
  const double along = offset.dot(axis);
  const Vec3 lateral = offset - along * axis;
  const double away = lateral.norm();
  return {-along, away, away > 0 ? Vec3(lateral / away) : Vec3(Vec3::Zero())};
}

/// Ball about own origin that holds a probe: the lateral part of the centre is
/// added to the radius.
inline BoundingBall ball_about_origin(const ProbeGeometry& probe, double radius_m) {
  const Vec3 centre = -(probe.turn * probe.touch);
  return {centre.z(), radius_m + centre.head<2>().norm()};
}

/// Lengths and bounds that most shapes have in common: `number` begins with a radius, contact is
/// about one point, and a shaft has no end.
template <class Shape>
struct ProbeShape {
  static double radius_m(const ProbeGeometry& probe) { return probe.number[0]; }
  static double tip_radius_m(const ProbeGeometry& probe) { return probe.number[0]; }
  static double half_width_m(const ProbeGeometry& probe) { return probe.number[0]; }
  static BoundingBall bounding_ball(const ProbeGeometry&) { return {}; }
  static ContactLine contact_line_m(const ProbeGeometry&, double) { return {}; }
  static double edge_ring_m(const ProbeGeometry&) { return 0; }
  static double mesh_length_m(const ProbeGeometry& probe, double depth_m) {
    return Shape::contact_radius_m(probe, depth_m);
  }
  static double contact_reach_m(const ProbeGeometry& probe, double depth_m) {
    return Shape::mesh_length_m(probe, depth_m);
  }
};

/// Ball of radius R whose lowest point along the axis u is the reference point: centre = x - R u.
struct SphereShape : ProbeShape<SphereShape> {
  static constexpr ProbeParameter kParameters[] = {
      {"radius", "of the ball", "5 mm", Dimension::length, false}};

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
};

/// Flat-ended rod of radius R with an edge rounded by e and no end behind: all points within e of
/// the half-open cylinder of radius R - e whose end lies e above the tip's plane. The reference
/// point is the middle of the flat. With e = R it is a rod with a round end. Pieces: flat, fillet,
/// wall; C1 from one to the next. The medial axis is a cone below the rim of the core, e below the
/// surface at least.
struct FlatShape : ProbeShape<FlatShape> {
  static constexpr ProbeParameter kParameters[] = {
      {"radius", "of the rod", "5 mm"},
      {"edge_radius", "of the rounded edge; 1/10 of radius when left out", "0.5 mm",
       Dimension::length, false}};
  /// An edge sharper than this is within the penetration that is tolerated.
  static constexpr double kMinEdge = 0.02;  // of the radius

  static double edge_m(const ProbeGeometry& probe) { return probe.number[1]; }

  static std::string complete(ProbeGeometry& probe) {
    if (std::isnan(probe.number[1])) probe.number[1] = 0.1 * probe.number[0];
    if (edge_m(probe) < kMinEdge * radius_m(probe) || edge_m(probe) > radius_m(probe))
      return "edge_radius must be from 0.02 to 1 times radius";
    return {};
  }

  static SignedDistance signed_distance(const ProbeGeometry& probe, const Vec3& axis,
                                        const Vec3& offset) {
    const AxialPlace at = axial_place(axis, offset);
    const double e = edge_m(probe);
    const double beside = at.away_m - (radius_m(probe) - e), below = e - at.height_m;
    SignedDistance out;
    const auto around = [&](double outward_share) {
      const Vec3 round = axis.cross(at.outward);
      out.hessian += (outward_share / at.away_m) * round * round.transpose();
    };
    if (e == radius_m(probe) && at.away_m == 0 && below > 0) {  // pole of a round end
      out.distance_m = below - e;
      out.gradient = axis;
      out.hessian = (Mat3::Identity() - axis * axis.transpose()) / below;
    } else if (beside > 0 && below > 0) {  // fillet
      const double r = std::hypot(beside, below);
      out.distance_m = r - e;
      out.gradient = (beside * at.outward + below * axis) / r;
      const Vec3 along = (below * at.outward - beside * axis) / r;
      out.hessian = along * along.transpose() / r;
      around(beside / r);
    } else if (below >= beside) {  // flat
      out.distance_m = below - e;
      out.gradient = axis;
    } else {  // wall
      out.distance_m = beside - e;
      out.gradient = at.outward;
      if (at.away_m > 0) around(1);
    }
    return out;
  }

  /// The flat and what of the fillet a ball of its radius would bring into contact.
  static double contact_radius_m(const ProbeGeometry& probe, double depth_m) {
    const double e = edge_m(probe);
    return radius_m(probe) - e + std::sqrt(e * std::min(depth_m, e));
  }
  /// Along drags; a press is meshed from the edge.
  static double mesh_length_m(const ProbeGeometry& probe, double) { return 0.55 * radius_m(probe); }
  static double contact_reach_m(const ProbeGeometry& probe, double) {
    return 1.1 * radius_m(probe);
  }
  static double edge_ring_m(const ProbeGeometry& probe) { return radius_m(probe); }
};

/// Capsule: all points within R of a segment along own z, `length` from end to end. Upright (own z
/// into the body) it presses with one end and its reference point is that end's pole; lying (own x
/// into the body) with its side, at the middle of it.
struct CapsuleShape : ProbeShape<CapsuleShape> {
  static constexpr ProbeParameter kParameters[] = {{"radius", "of the ends and the side", "5 mm"},
                                                   {"length", "from end to end", "40 mm"}};

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
    return SphereShape::contact_radius_m(probe, depth_m);
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
  static double half_width_m(const ProbeGeometry& probe) {
    return radius_m(probe) + half_segment_m(probe) * inward(probe).head<2>().norm();
  }
};

/// Cone of half angle alpha (axis to flank) without end, its tip a ball of radius t that meets the
/// flank smoothly. The reference point is the ball's pole. Pieces: ball, flank; C1 where they join,
/// t cos(alpha) from the axis. The medial axis is the axis above the ball's centre.
struct ConeShape : ProbeShape<ConeShape> {
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
