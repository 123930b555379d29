// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// Rigid motions: poses as callers give them, frames as the engine computes with them.

#include <limits>

#include "constants.hpp"
#include "scalar.hpp"

namespace palpate::runtime {

/// Rotation, then translation: world = R(orientation) local + position_m.
struct Pose {
  double position_m[3] = {0, 0, 0};
  double orientation[4] = {1, 0, 0, 0};  ///< unit quaternion w, x, y, z; either sign
};

/// A frame as the engine computes with it. rows: of the rotation matrix.
struct Frame {
  Vec3d row[3], origin;
  Vec3d turn(const Vec3d& p) const noexcept {
    return {dot(row[0], p), dot(row[1], p), dot(row[2], p)};
  }
  Vec3d turn_back(const Vec3d& p) const noexcept {
    return row[0] * p.x + row[1] * p.y + row[2] * p.z;
  }
  Vec3d place(const Vec3d& p) const noexcept { return turn(p) + origin; }
  Vec3d place_back(const Vec3d& p) const noexcept { return turn_back(p - origin); }
};

/// False when a number is not finite or the quaternion's length is off by kQuaternionTolerance;
/// what is within is made exactly unit.
inline bool make_frame(const Pose& pose, Frame& out) noexcept {
  out.origin = make_vec3<double>(pose.position_m);
  const double* q = pose.orientation;
  const double squared = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
  if (!is_finite(out.origin) || !(std::fabs(squared - 1) <= 2 * kQuaternionTolerance)) return false;
  const double s = 2 / squared;
  const double w = q[0], x = q[1], y = q[2], z = q[3];
  out.row[0] = {1 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y)};
  out.row[1] = {s * (x * y + w * z), 1 - s * (x * x + z * z), s * (y * z - w * x)};
  out.row[2] = {s * (x * z - w * y), s * (y * z + w * x), 1 - s * (x * x + y * y)};
  return true;
}

/// A tool's frame relative to a body: body^T tool.
inline Frame relative_to(const Frame& body, const Frame& tool) noexcept {
  Frame out;
  out.origin = body.place_back(tool.origin);
  const Vec3d a = body.turn_back({tool.row[0].x, tool.row[1].x, tool.row[2].x}),
              b = body.turn_back({tool.row[0].y, tool.row[1].y, tool.row[2].y}),
              c = body.turn_back({tool.row[0].z, tool.row[1].z, tool.row[2].z});
  out.row[0] = {a.x, b.x, c.x};
  out.row[1] = {a.y, b.y, c.y};
  out.row[2] = {a.z, b.z, c.z};
  return out;
}

/// The turn of a tool since the tick before, whose rows were `before`: its axis times the sine of
/// its angle.
inline Vec3d turn_since(const double before[3][3], const Frame& now) noexcept {
  const Vec3d p[3] = {make_vec3<double>(before[0]), make_vec3<double>(before[1]),
                      make_vec3<double>(before[2])};  // now before^T is the turn
  return Vec3d{dot(now.row[2], p[1]) - dot(now.row[1], p[2]),
               dot(now.row[0], p[2]) - dot(now.row[2], p[0]),
               dot(now.row[1], p[0]) - dot(now.row[0], p[1])} *
         0.5;
}

}  // namespace palpate::runtime
