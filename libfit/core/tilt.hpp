#pragma once

#include <Eigen/Geometry>
#include <cmath>

#include "libfit/core/geometry.hpp"

namespace palpate {

/// Lean of a tool: sin(tilt) times the direction that its shaft leans to, in tilt_frame(). Zero
/// is upright, its axis along the normal; shorter than 1.
using Lean = Eigen::Vector2d;

inline Lean lean_of(double tilt_rad, double direction_rad) {
  return std::sin(tilt_rad) * Lean(std::cos(direction_rad), std::sin(direction_rad));
}

/// Columns: the two tangents that leans are given in (M58b), and the inward unit normal u. The
/// tangents are where the least turn from z to the outward normal takes x and y; they change
/// smoothly over a body but where that normal is -z.
inline Mat3 tilt_frame(const Vec3& inward) {
  constexpr double kPole = 1e-9;  // 1 + n_z below which a place has the pole's frame
  const Vec3 outward = -inward, middle = outward + Vec3::UnitZ();
  Vec3 first = Vec3::UnitX();
  if (middle.z() > kPole) first -= middle * (outward.x() / middle.z());
  Mat3 frame;
  frame << first, outward.cross(first), inward;
  return frame;
}

/// The turn, in the body's axes, of a tool that stands upright to one that leans (M58c).
inline Mat3 tilt_turn(const Vec3& inward, const Lean& lean) {
  const double sine = lean.norm();
  if (!(sine > 0)) return Mat3::Identity();
  const Vec3 towards = tilt_frame(inward).leftCols<2>() * (lean / sine);
  return Eigen::AngleAxisd(std::asin(std::min(sine, 1.0)), Vec3((-inward).cross(towards)))
      .toRotationMatrix();
}

/// Pose of a tool: its own axes in the body's, as columns, and in them its reference point,
/// which a path moves [m].
struct Stance {
  Mat3 axes = Mat3::Identity();
  Vec3 touch_m = Vec3::Zero();
};

}  // namespace palpate
