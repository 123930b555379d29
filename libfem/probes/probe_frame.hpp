#pragma once

#include <Eigen/Geometry>

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

}  // namespace palpate::fem
