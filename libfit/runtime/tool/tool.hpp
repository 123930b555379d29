// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// A rigid tool against a rigid motion of the body: poses in, wrench out, with an optional damper.
// palpate.h is this file's face for C and every other language.

#include "../asset/check.hpp"
#include "../tick.hpp"

namespace palpate {
namespace runtime {

constexpr double kQuaternionTolerance = 1e-3;  ///< of its length: floats drift, angles must not

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

/// A tool's frame as a body sees it: body^T tool.
inline Frame seen_from(const Frame& body, const Frame& tool) noexcept {
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

constexpr double kMaxDamping_Ns_m = 1e4;

/// What touches: a point or a ball fixed to the tool, and a damper parallel to the curves,
/// b(dz) = b min(1, dz / damper_depth_m) [N s/m] against the motion along u and across it, each
/// with its own b. It fades to nothing at the surface, so contact begins and ends without a pop; it
/// never pulls the tool in. Last of all the force is brought up over ramp_s from the first tick on,
/// and down to max_force_N; energies are those of the whole force.
struct ToolShape {
  double offset_m[3] = {0, 0, 0};  ///< of the tip or the ball's centre, in the tool's frame
  double radius_m = 0;             ///< 0: a tip
  double damping_Ns_m = 0;
  double damper_depth_m = 0;  ///< > 0 where there is damping
  double lateral_damping_Ns_m = 0;
  double max_force_N = 0;  ///< 0: no cap
  double ramp_s = 0;       ///< 0: none

  bool has_damper() const noexcept { return damping_Ns_m > 0 || lateral_damping_Ns_m > 0; }
};

inline Status check_tool(const ToolShape& shape) noexcept {
  for (double x : shape.offset_m)
    if (!is_within(x, 1e3)) return Status::tool_wrong;
  const auto is_size = [](double x, double most) noexcept { return x >= 0 && x <= most; };
  const bool is_good =
      is_size(shape.radius_m, 1e3) && is_size(shape.damping_Ns_m, kMaxDamping_Ns_m) &&
      is_size(shape.lateral_damping_Ns_m, kMaxDamping_Ns_m) && is_size(shape.damper_depth_m, 1e3) &&
      is_size(shape.max_force_N, 1e6) && is_size(shape.ramp_s, 1e3) &&
      (!shape.has_damper() || shape.damper_depth_m > 0);
  return is_good ? Status::ok : Status::tool_wrong;
}

/// One tool on one body: what is remembered between ticks. Plain data.
struct ToolContact {
  ToolShape shape;
  Contact contact;
  double damped_J = 0;  ///< taken by the damper since the start, never falling
  double since_start_s = 0;
};

/// A tick in world coordinates; `body` is the tick of the tip or ball in body coordinates.
struct ToolOutput {
  Output body;
  double force_on_tool_N[3] = {0, 0, 0};
  double torque_on_tool_Nm[3] = {0, 0, 0};  ///< about the tool pose's position
  double contact_m[3] = {0, 0, 0};
  double normal[3] = {0, 0, 0};        ///< inward at the contact point
  double deflection_m[3] = {0, 0, 0};  ///< from contact_m to the tip or the ball's lowest point
  double acts_at_m[3] = {0, 0, 0};     ///< where the force acts
  double damper_N = 0;                 ///< part of the force on the body along u
  double damped_J = 0;
  bool has_touched = false, has_released = false;  ///< at this tick
  double approach_m_s = 0;                         ///< along u, of the tick of a touch
};

/// The damper's force on the body [N] for a motion `step` [m] in dt_s. Its work on the body, force
/// times step, is never negative.
struct DamperForce {
  double along_N;  ///< u
  Vec3d lateral_N;
};
inline DamperForce damper_force(const ToolShape& shape, const Output& out, const Vec3d& step,
                                double dt_s) noexcept {
  if (!shape.has_damper()) return {0, {0, 0, 0}};
  const Vec3d u = make_vec3<double>(out.normal);
  const double depth = out.normal_m > 0 ? out.normal_m : 0;
  const double rate = (depth < shape.damper_depth_m ? depth / shape.damper_depth_m : 1) / dt_s;
  const double wanted = shape.damping_Ns_m * rate * dot(step, u);
  const double elastic = -dot(make_vec3<double>(out.force_on_tool_N), u);
  const double least = elastic > 0 ? -elastic : 0;
  return {wanted > least ? wanted : least,
          tangential(step, u) * (shape.lateral_damping_Ns_m * rate)};
}

/// Brings a force up over the ramp and down to the cap.
inline Vec3d limited(const ToolShape& shape, double since_start_s, const Vec3d& force,
                     unsigned& flags) noexcept {
  double share = 1;
  if (since_start_s < shape.ramp_s) {
    share = since_start_s / shape.ramp_s;
    flags |= kFlagRamp;
  }
  const double size = share * std::sqrt(dot(force, force));
  if (shape.max_force_N > 0 && size > shape.max_force_N) {
    share *= shape.max_force_N / size;
    flags |= kFlagCapped;
  }
  return force * share;
}

/// A tick of a tool before its contact answers: the frames, and where the tip is in the body's.
struct ToolPlace {
  Frame tool, body;
  double tip_m[3];
  Vec3d before;  ///< the tip at the tick before
  bool was_touching;
};

/// Refuses a bad pose or time step, and forgets the contact then.
inline Status place_tool(const AssetView& asset, ToolContact& state, const Pose& tool,
                         const Pose& body, double dt_s, ToolPlace& out) noexcept {
  Contact& contact = state.contact;
  const bool needs_time =
      state.shape.has_damper() || state.shape.ramp_s > 0 || asset.curves.relaxation.branches > 0;
  const bool has_time = dt_s >= kMinTimeStep_s && dt_s <= kMaxTimeStep_s;
  const bool is_timed = !needs_time || has_time;
  if (!is_timed || !make_frame(tool, out.tool) || !make_frame(body, out.body)) {
    forget(contact);
    return is_timed ? Status::pose_wrong : Status::time_step_wrong;
  }
  put(out.body.place_back(out.tool.place(make_vec3<double>(state.shape.offset_m))), out.tip_m);
  if (has_time) state.since_start_s += dt_s;
  out.before = make_vec3<double>(contact.tip_m);
  out.was_touching = contact.triangle >= 0;
  return Status::ok;
}

/// What out.body says, in world coordinates, with the damper, the ramp and the cap.
inline void tell_tool(ToolContact& state, const ToolPlace& place, double dt_s,
                      ToolOutput& out) noexcept {
  const Contact& contact = state.contact;
  const bool has_time = dt_s >= kMinTimeStep_s && dt_s <= kMaxTimeStep_s;
  out.damped_J = state.damped_J;
  out.has_released = place.was_touching && out.body.state == ContactState::air;
  if (out.body.state == ContactState::air) return;
  const Vec3d step = make_vec3<double>(contact.tip_m) - place.before;
  const Vec3d u = make_vec3<double>(out.body.normal);
  out.has_touched = !place.was_touching;
  if (out.has_touched && has_time) out.approach_m_s = dot(step, u) / dt_s;
  const DamperForce damper = damper_force(state.shape, out.body, step, dt_s);
  out.damper_N = damper.along_N;
  state.damped_J += damper.along_N * dot(step, u) + dot(damper.lateral_N, step);
  out.damped_J = state.damped_J;
  const Vec3d elastic = make_vec3<double>(out.body.force_on_tool_N);
  const Vec3d whole = elastic - u * damper.along_N - damper.lateral_N;
  const Vec3d force =
      place.body.turn(limited(state.shape, state.since_start_s, whole, out.body.flags));
  const Vec3d at = place.body.place(make_vec3<double>(out.body.acts_at_m));
  put(force, out.force_on_tool_N);
  put(cross(at - place.tool.origin, force), out.torque_on_tool_Nm);
  put(place.body.place(make_vec3<double>(out.body.contact_m)), out.contact_m);
  put(place.body.turn(u), out.normal);
  put(at, out.acts_at_m);
  put(at - make_vec3<double>(out.contact_m), out.deflection_m);
}

/// One tick of a tool at `tool` against a body at `body`, both in world coordinates. dt_s [s] is
/// read by damper, ramp, approach_m_s and a body that relaxes. Between ticks the tip moves straight
/// as the body sees it; a body that turns by an angle a in a tick is off by at most a^2/8 of the
/// tip's distance from its axis. tangent_N_m: as touch(), in world coordinates, without the damper
/// and for tools that do not turn. Refuses as touch_ball(), and bad poses and time steps: zero
/// force and a status.
inline Status touch_tool(const AssetView& asset, ToolContact& state, const Pose& tool,
                         const Pose& body, double dt_s, ToolOutput& out,
                         TangentOut tangent_N_m = nullptr) noexcept {
  out = ToolOutput();
  out.damped_J = state.damped_J;
  if (tangent_N_m != nullptr)
    for (int k = 0; k < 9; ++k) tangent_N_m[k] = 0;
  ToolPlace place;
  const Status placed = place_tool(asset, state, tool, body, dt_s, place);
  if (placed != Status::ok) {
    tell_sums(state.contact, out.body);
    return placed;
  }
  double local[9];
  const Status status = touch_ball(asset, state.contact, place.tip_m, state.shape.radius_m,
                                   out.body, tangent_N_m != nullptr ? local : nullptr, dt_s);
  tell_tool(state, place, dt_s, out);
  if (out.body.state == ContactState::air) return status;
  if (tangent_N_m == nullptr) return status;
  Vec3d turned[3];  // columns of R K
  for (int k = 0; k < 3; ++k) turned[k] = place.body.turn({local[k], local[3 + k], local[6 + k]});
  for (int i = 0; i < 3; ++i) {
    const Vec3d& r = place.body.row[i];
    const Vec3d column = turned[0] * r.x + turned[1] * r.y + turned[2] * r.z;  // of R K R^T
    tangent_N_m[i] = column.x;
    tangent_N_m[3 + i] = column.y;
    tangent_N_m[6 + i] = column.z;
  }
  return status;
}

}  // namespace runtime
}  // namespace palpate
