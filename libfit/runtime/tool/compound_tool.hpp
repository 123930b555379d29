// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// A rigid tool of several balls that turns (docs/method.md, section 29): a lying capsule, a finger,
// a rod. Each ball has a contact of its own on a body whose contacts feel each other (M62); force
// and torque are the sums over the balls,
//
//     F = sum_i f_i        T = sum_i (p_i - O + R u_i) x f_i                               (M70)
//
// with p_i the balls' centres, O the tool's origin and u_i the inward normals at the contacts.
// What a turn dA of the tool drags along under a ball, dA x R u_i, moves the place that its contact
// is fed, so T dA works on what is stored as F dp does, and one ledger (section 18) books the rest.

#include "several_tools.hpp"

namespace palpate {
namespace runtime {

/// The tool's balls, all of the radius that the asset was measured with. Of `limits` the ramp and
/// the cap of the whole force count.
struct CompoundShape {
  int balls = 0;                       ///< 1 to kMaxTools
  double centre_m[kMaxTools][3] = {};  ///< in the tool's frame
  double radius_m = 0;
  ToolShape limits;
};

/// One such tool on one body: what is remembered between ticks. Plain data.
struct CompoundTool {
  CompoundShape shape;
  Contact contact[kMaxTools];
  Joint joint;
  bool has_pose = false;
  double row[3][3] = {};             ///< of the turn from the tool's axes to the body's
  double roll_m[kMaxTools][3] = {};  ///< how far each ball's surface has dragged its contact
  double normal[kMaxTools][3] = {};  ///< of each contact at the last tick
  double since_start_s = 0;
};

/// In the body's frame, or in world coordinates as it comes from touch_compound_tool().
struct CompoundOutput {
  double force_on_tool_N[3] = {0, 0, 0};
  double torque_on_tool_Nm[3] = {0, 0, 0};  ///< about the tool's origin
  double contact_m[3] = {0, 0, 0};  ///< mean of the contact points, each by the force it bears
  double acts_at_m[3] = {0, 0, 0};  ///< the same of the balls' lowest points
  double normal[3] = {0, 0, 0};     ///< the same of the inward normals, unit
  int touching = 0;                 ///< balls in contact
  unsigned flags = 0;               ///< of all balls
  double stored_J = 0, dissipated_J = 0, refused_J = 0;
  std::int64_t refused_ticks = 0;
  bool has_touched = false, has_released = false;  ///< the tool as a whole, at this tick
  Output ball[kMaxTools];                          ///< of each, in the body's frame
};

/// Contacts end, and where the tool was is forgotten.
inline void forget(CompoundTool& state) noexcept {
  for (int i = 0; i < kMaxTools; ++i) {
    forget(state.contact[i]);
    for (int k = 0; k < 3; ++k) state.roll_m[i][k] = 0;
  }
  state.has_pose = false;
}

/// Whether the asset can answer to such a tool: of rings that a ball of its radius was measured
/// with, on a body without channels, which know nothing of turns; and, for more than one ball, of
/// contacts that feel each other.
inline Status check_compound(const AssetView& asset, const CompoundShape& shape) noexcept {
  const bool is_ours = asset.curves.family == int(Family::rings) && shape.radius_m > 0 &&
                       shape.radius_m == asset.probe_radius_m && asset.channels == nullptr;
  const bool is_known = shape.balls == 1 || asset.coupling != nullptr;
  return is_ours && is_known && shape.balls >= 1 && shape.balls <= kMaxTools ? Status::ok
                                                                             : Status::tool_wrong;
}

/// One tick of the tool whose frame is `tool`, as the body sees it. As touch_together(); where one
/// ball is refused the whole tool is out of contact.
inline Status touch_compound(const AssetView& asset, CompoundTool& state, const Frame& tool,
                             CompoundOutput& out, double dt_s = 0) noexcept {
  const CompoundShape& shape = state.shape;
  const double radius = shape.radius_m;
  out = CompoundOutput();
  JointTool at[kMaxTools];
  Vec3d centre[kMaxTools];
  const Vec3d turned = state.has_pose ? turn_since(state.row, tool) : Vec3d{0, 0, 0};
  bool was_touching = false;
  for (int i = 0; i < shape.balls; ++i) {
    Vec3d roll = make_vec3<double>(state.roll_m[i]);
    if (state.contact[i].triangle >= 0) {
      was_touching = true;
      roll = roll + cross(turned, make_vec3<double>(state.normal[i])) * radius;
      put(roll, state.roll_m[i]);
    }
    centre[i] = tool.place(make_vec3<double>(shape.centre_m[i]));
    at[i].contact = &state.contact[i];
    at[i].radius_m = radius;
    put(centre[i] + roll, at[i].place_m);
  }
  for (int k = 0; k < 3; ++k) put(tool.row[k], state.row[k]);
  state.has_pose = true;
  touch_together(asset, state.joint, at, shape.balls, dt_s);
  Vec3d force{0, 0, 0}, torque{0, 0, 0}, contact{0, 0, 0}, acts{0, 0, 0}, normal{0, 0, 0};
  double borne = 0;
  for (int i = 0; i < shape.balls; ++i) {
    if (at[i].status != Status::ok) {
      const Status status = at[i].status;
      forget(state);
      out = CompoundOutput();
      out.has_released = was_touching;
      return status;
    }
    Output& ball = out.ball[i] = at[i].out;
    ball.flags &= ~kFlagCrowded;  // of one tool
    out.flags |= ball.flags;
    out.stored_J += ball.stored_J;
    out.dissipated_J = ball.dissipated_J;
    out.refused_J = ball.refused_J;
    out.refused_ticks = ball.refused_ticks;
    if (ball.state == ContactState::air) {  // what dragged it aside is over; it begins anew
      const Vec3d roll = make_vec3<double>(state.roll_m[i]);
      if (dot(roll, roll) > 0) forget(state.contact[i]);
      for (double& r : state.roll_m[i]) r = 0;
      continue;
    }
    ++out.touching;
    const Vec3d u = make_vec3<double>(ball.normal), f = make_vec3<double>(ball.force_on_tool_N);
    put(u, state.normal[i]);
    const Vec3d lowest = centre[i] + u * radius;
    put(lowest, ball.acts_at_m);
    force = force + f;
    torque = torque + cross(lowest - tool.origin, f);
    const double size = std::sqrt(dot(f, f)) + kSwayZero_N;
    borne += size;
    contact = contact + make_vec3<double>(ball.contact_m) * size;
    acts = acts + lowest * size;
    normal = normal + u * size;
  }
  out.has_touched = out.touching > 0 && !was_touching;
  out.has_released = was_touching && out.touching == 0;
  if (out.touching == 0) return Status::ok;
  const double length = std::sqrt(dot(normal, normal));
  put(force, out.force_on_tool_N);
  put(torque, out.torque_on_tool_Nm);
  put(contact * (1 / borne), out.contact_m);
  put(acts * (1 / borne), out.acts_at_m);
  put(length > 0 ? normal * (1 / length) : make_vec3<double>(state.normal[0]), out.normal);
  return Status::ok;
}

/// touch_compound() of a tool at `tool` on a body at `body`, both in world coordinates. Ramp and
/// cap lower force and torque alike. Refuses bad poses and time steps, and what check_compound()
/// does: zero force and a status.
inline Status touch_compound_tool(const AssetView& asset, CompoundTool& state, const Pose& tool,
                                  const Pose& body, double dt_s, CompoundOutput& out) noexcept {
  out = CompoundOutput();
  const ToolShape& limits = state.shape.limits;
  const bool has_time = dt_s >= kMinTimeStep_s && dt_s <= kMaxTimeStep_s;
  const bool is_timed = has_time || !(limits.ramp_s > 0);
  const Status ours = check_compound(asset, state.shape);
  Frame tool_frame, body_frame;
  if (!is_timed || ours != Status::ok || !make_frame(tool, tool_frame) ||
      !make_frame(body, body_frame)) {
    forget(state);
    return ours != Status::ok ? ours : is_timed ? Status::pose_wrong : Status::time_step_wrong;
  }
  if (has_time) state.since_start_s += dt_s;
  const Status status = touch_compound(asset, state, seen_from(body_frame, tool_frame), out, dt_s);
  if (out.touching == 0) return status;
  const Vec3d whole = make_vec3<double>(out.force_on_tool_N);
  const Vec3d borne = limited(limits, state.since_start_s, whole, out.flags);
  const double squared = dot(whole, whole),
               share = squared > 0 ? std::sqrt(dot(borne, borne) / squared) : 1;
  put(body_frame.turn(borne), out.force_on_tool_N);
  put(body_frame.turn(make_vec3<double>(out.torque_on_tool_Nm)) * share, out.torque_on_tool_Nm);
  put(body_frame.place(make_vec3<double>(out.contact_m)), out.contact_m);
  put(body_frame.place(make_vec3<double>(out.acts_at_m)), out.acts_at_m);
  put(body_frame.turn(make_vec3<double>(out.normal)), out.normal);
  return status;
}

}  // namespace runtime
}  // namespace palpate
