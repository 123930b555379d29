#pragma once

#include <algorithm>
#include <cmath>

#include "libfem/probes/probe_frame.hpp"

namespace palpate::fem {

/// Cuboid with edges and corners rounded by e: all points within e of the cuboid of half-lengths
/// h - e. Pieces: faces, a quarter of a cylinder at each edge, an eighth of a ball at each corner;
/// C1 from one to the next. The reference point is the middle of the face, edge or corner that
/// points into the body.
struct BoxShape {
  static constexpr ProbeParameter kParameters[] = {
      {"size", "along the heading, across it and along the press",
       "[\"6 mm\", \"8 mm\", \"10 mm\"]", Dimension::length, 3},
      {"rounding", "of the rounded edges", "1 mm"}};

  static double edge_m(const ProbeGeometry& probe) { return probe.number[3]; }
  /// Half-lengths of the cuboid that is rounded.
  static Vec3 core_m(const ProbeGeometry& probe) {
    return Vec3(probe.number[0], probe.number[1], probe.number[2]) / 2 -
           Vec3::Constant(edge_m(probe));
  }

  static std::string complete(ProbeGeometry& probe) {
    const Vec3 core = core_m(probe), inward = probe.turn.row(2);
    if (core.minCoeff() < 0) return "rounding must be at most half of the shortest side";
    probe.touch = edge_m(probe) * inward;
    for (int i = 0; i < 3; ++i)
      if (std::abs(inward[i]) > 1e-9) probe.touch[i] += std::copysign(core[i], inward[i]);
    return {};
  }

  static SignedDistance signed_distance(const ProbeGeometry& probe, const Vec3& axis,
                                        const Vec3& offset) {
    const Vec3 core = core_m(probe);
    return in_own_axes(probe, axis, offset, [&](const Vec3& x) {
      const Vec3 over = x.cwiseAbs() - core, beyond = over.cwiseMax(0);
      const double r = beyond.norm();
      SignedDistance out;
      if (!(r > 0)) {  // inside the core: the nearest face
        Eigen::Index face = 0;
        out.distance_m = over.maxCoeff(&face) - edge_m(probe);
        out.gradient[face] = std::copysign(1, x[face]);
        return out;
      }
      out.distance_m = r - edge_m(probe);
      Vec3 free = Vec3::Zero();
      for (int i = 0; i < 3; ++i)
        if (beyond[i] > 0) {
          out.gradient[i] = std::copysign(beyond[i] / r, x[i]);
          free[i] = 1;
        }
      out.hessian = (Mat3(free.asDiagonal()) - out.gradient * out.gradient.transpose()) / r;
      return out;
    });
  }

  static BoundingBall bounding_ball(const ProbeGeometry& probe) {
    return ball_about_origin(probe, core_m(probe).norm() + edge_m(probe));
  }

  /// Half-lengths across the axis, the smaller first.
  static Eigen::Vector2d half_widths_m(const ProbeGeometry& probe) {
    const Vec3 core = core_m(probe);
    Eigen::Vector2d out;
    for (int i = 0; i < 2; ++i) out[i] = edge_m(probe) + probe.turn.row(i).cwiseAbs().dot(core);
    return {out.minCoeff(), out.maxCoeff()};
  }
  static double contact_radius_m(const ProbeGeometry& probe, double) {
    return half_widths_m(probe)[0];
  }
  static double mesh_length_m(const ProbeGeometry& probe, double) {
    return 0.55 * half_widths_m(probe)[0];
  }
  static double contact_reach_m(const ProbeGeometry& probe, double) {
    return 1.1 * half_widths_m(probe).norm();
  }
  static double tip_radius_m(const ProbeGeometry& probe) { return half_widths_m(probe)[0]; }
  static double half_width_m(const ProbeGeometry& probe) { return half_widths_m(probe)[1]; }
};

}  // namespace palpate::fem
