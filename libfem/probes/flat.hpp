#pragma once

#include <algorithm>
#include <cmath>

#include "libfem/probes/probe_frame.hpp"

namespace palpate::fem {

/// Flat-ended rod of radius R with an edge rounded by e and no end behind: all points within e of
/// the half-open cylinder of radius R - e whose end lies e above the tip's plane. The reference
/// point is the middle of the flat. With e = R it is a rod with a round end. Pieces: flat, fillet,
/// wall; C1 from one to the next. The medial axis is a cone below the rim of the core, e below the
/// surface at least.
struct FlatShape {
  static constexpr ProbeParameter kParameters[] = {
      {"radius", "of the rod", "5 mm"},
      {"edge_radius", "of the rounded edge; 1/10 of radius when left out", "0.5 mm",
       Dimension::length, false}};
  /// An edge sharper than this is within the penetration that is tolerated.
  static constexpr double kMinEdge = 0.02, kDefaultEdge = 0.1;  // of the radius

  static double radius_m(const ProbeGeometry& probe) { return probe.number[0]; }
  static double edge_m(const ProbeGeometry& probe) { return probe.number[1]; }

  static std::string complete(ProbeGeometry& probe) {
    if (std::isnan(probe.number[1])) probe.number[1] = kDefaultEdge * probe.number[0];
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

  static BoundingBall bounding_ball(const ProbeGeometry&) { return {}; }

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
  static double tip_radius_m(const ProbeGeometry& probe) { return radius_m(probe); }
  static double half_width_m(const ProbeGeometry& probe) { return radius_m(probe); }
};

}  // namespace palpate::fem
