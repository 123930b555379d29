// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// A tool with a round end that turns (docs/method.md, section 27): pose in, force and torque out.
// The body has curves at several leans (TiltNodes), an asset each. A contact is as many contacts as
// there are nodes, all with the same tool; node i counts by the weight w_i of the tool's lean:
//
//     U = sum w_i U_i        force = sum w_i f_i        torque about the end's centre
//                            = R u x f + sum U_i dw_i/d(turn)                           (M61)
//
// A turn works on U by that torque: what the end's surface drags along moves the tool of all
// contacts aside. Weights also change where the contact point slides to another normal; what that
// would add to U is paid by what slips have dissipated, or the old normal stays.

#include "tilt.hpp"
#include "tool.hpp"

namespace palpate {
namespace runtime {

/// Opened assets of one body, one for each node, and the radius of the tool's end.
struct TiltedBody {
  TiltNodes nodes;
  const AssetView* node[kMaxTiltNodes] = {};
  double end_radius_m = 0;
};

/// Whether the assets are of one surface, the leans rise within (0, 1) and there is a radius.
inline bool is_tilted_body(const TiltedBody& body) noexcept {
  if (body.nodes.tilts < 1 || body.nodes.tilts > kMaxTilts) return false;
  for (int j = 1; j <= body.nodes.tilts; ++j)
    if (!(body.nodes.sine[j] > body.nodes.sine[j - 1] && body.nodes.sine[j] < 1)) return false;
  if (body.nodes.sine[0] != 0 || !(body.end_radius_m > 0 && body.end_radius_m <= 1e3)) return false;
  for (int i = 0; i < body.nodes.size(); ++i) {
    const AssetView* view = body.node[i];
    if (view == nullptr || view->vertices != body.node[0]->vertices ||
        view->triangles != body.node[0]->triangles)
      return false;
    for (int k = 0; k < 3; ++k)
      if (view->origin_m[k] != body.node[0]->origin_m[k]) return false;
  }
  return true;
}

/// One such tool on one body: what is remembered between ticks. Plain data.
struct TurningContact {
  Contact contact[kMaxTiltNodes];
  bool has_pose = false, touches = false;
  double row[3][3] = {};         ///< of the turn from the tool's axes to the body's
  double roll_m[3] = {0, 0, 0};  ///< how far the end's surface has dragged the contacts
  double normal[3] = {0, 0, 0};  ///< that leans are about
  double weight[kMaxTiltNodes] = {};
  double stored_J[kMaxTiltNodes] = {};
  double bank_J = 0;  ///< dissipated, that may pay for another normal
};

/// In body coordinates.
struct TurningOutput {
  double force_on_tool_N[3] = {0, 0, 0};
  double torque_on_tool_Nm[3] = {0, 0, 0};  ///< about the end's centre
  double tilt_torque_Nm[3] = {0, 0, 0};     ///< its part that is not friction's
  double contact_m[3] = {0, 0, 0};          ///< of the node that weighs most
  double normal[3] = {0, 0, 0};
  double normal_m = 0;
  TiltLean lean{0, 0};
  ContactState state = ContactState::air;
  unsigned flags = 0;
  double stored_J = 0;
};

/// Contact ends, and where the tool was is forgotten.
inline void forget(TurningContact& state) noexcept {
  for (Contact& contact : state.contact) forget(contact);
  state.has_pose = state.touches = false;
  state.bank_J = 0;
  for (int k = 0; k < 3; ++k) state.roll_m[k] = 0;
  for (double& weight : state.weight) weight = 0;
}

/// Weights of a lean take the place of the contact's. A tank laid by at a smaller weight counts by
/// that.
inline void take_weights(TurningContact& state, int nodes, const TiltWeights& at) noexcept {
  for (int i = 0; i < nodes; ++i) {
    double& tank_J = state.contact[i].ledger.tank_J;
    if (at.w[i] > state.weight[i]) tank_J *= state.weight[i] / at.w[i];
    state.weight[i] = at.w[i];
  }
}

/// The turn since the last tick: its axis times the sine of its angle.
inline Vec3d turn_since(const double before[3][3], const Frame& now) noexcept {
  double turned[3][3];  // now before^T
  const double* p[3] = {before[0], before[1], before[2]};
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) turned[i][k] = dot(now.row[i], make_vec3<double>(p[k]));
  return Vec3d{turned[2][1] - turned[1][2], turned[0][2] - turned[2][0],
               turned[1][0] - turned[0][1]} *
         0.5;
}

/// Leans are about the normal of the node that weighs most from now on, if what that adds to U can
/// be paid.
inline void follow_normal(const TiltedBody& body, TurningContact& state, const Vec3d& shaft,
                          const Vec3d& normal) noexcept {
  const TiltWeights at = tilt_weights(body.nodes, lean_of(tilt_frame(normal), shaft));
  double added_J = 0;
  for (int i = 0; i < body.nodes.size(); ++i)
    added_J += (at.w[i] - state.weight[i]) * state.stored_J[i];
  if (added_J > state.bank_J) return;
  const double left_J = state.bank_J - added_J;
  state.bank_J = left_J < kTank_J ? left_J : kTank_J;
  take_weights(state, body.nodes.size(), at);
  put(normal, state.normal);
}

/// One tick of the tool whose end has its centre at centre_m [m] and whose frame is `tool`, both as
/// the body sees them; the tool's own z is its shaft, away from the end. Otherwise as touch_ball().
/// The body is a tilted one (is_tilted_body). Work: a tick of touch_ball() for each node.
inline Status touch_turning(const TiltedBody& body, TurningContact& state, const double centre_m[3],
                            const Frame& tool, TurningOutput& out, double dt_s = 0) noexcept {
  out = TurningOutput();
  const int nodes = body.nodes.size();
  const double radius = body.end_radius_m;
  const Vec3d shaft{tool.row[0].z, tool.row[1].z, tool.row[2].z};
  Vec3d roll = make_vec3<double>(state.roll_m);
  if (state.touches && state.has_pose) {
    const Vec3d u = make_vec3<double>(state.normal);
    roll = roll + cross(turn_since(state.row, tool), u) * radius;
    // What the turn changes of the weights is work of the tool.
    take_weights(state, nodes, tilt_weights(body.nodes, lean_of(tilt_frame(u), shaft)));
  }
  for (int i = 0; i < 3; ++i) put(tool.row[i], state.row[i]);
  put(roll, state.roll_m);
  state.has_pose = true;
  const double fed_m[3] = {centre_m[0] + roll.x, centre_m[1] + roll.y, centre_m[2] + roll.z};
  Output answer[kMaxTiltNodes];
  int heaviest = -1;
  for (int i = 0; i < nodes; ++i) {
    Contact& contact = state.contact[i];
    const double spent_J = contact.ledger.dissipated_J - contact.ledger.tank_J;
    const Status status =
        touch_ball(*body.node[i], contact, fed_m, radius, answer[i], nullptr, dt_s);
    if (status != Status::ok) {
      forget(state);
      return status;
    }
    const double lost_J = contact.ledger.dissipated_J - contact.ledger.tank_J - spent_J;
    if (lost_J > 0) state.bank_J += state.weight[i] * lost_J;
    state.stored_J[i] = answer[i].stored_J;
    if (answer[i].state == ContactState::air) continue;
    if (heaviest < 0 || state.weight[i] > state.weight[heaviest]) heaviest = i;
  }
  if (state.bank_J > kTank_J) state.bank_J = kTank_J;
  if (heaviest < 0) {
    // What dragged the contacts aside is over; they begin anew from where the tool is.
    const bool is_aside = dot(roll, roll) > 0;
    state.touches = false;
    state.bank_J = 0;
    for (int k = 0; k < 3; ++k) state.roll_m[k] = 0;
    for (int i = 0; i < nodes && is_aside; ++i) forget(state.contact[i]);
    return Status::ok;
  }
  if (!state.touches) {
    state.touches = true;
    put(make_vec3<double>(answer[heaviest].normal), state.normal);
    for (int i = 0; i < nodes; ++i) state.weight[i] = 0;
    const Vec3d u = make_vec3<double>(state.normal);
    take_weights(state, nodes, tilt_weights(body.nodes, lean_of(tilt_frame(u), shaft)));
    for (int i = 0; i < nodes; ++i)
      if (state.weight[i] > state.weight[heaviest] && answer[i].state != ContactState::air)
        heaviest = i;
  } else {
    follow_normal(body, state, shaft, make_vec3<double>(answer[heaviest].normal));
  }
  const Vec3d u = make_vec3<double>(state.normal);
  const TiltFrame frame = tilt_frame(u);
  out.lean = lean_of(frame, shaft);
  const TiltWeights at = tilt_weights(body.nodes, out.lean);
  Vec3d force{0, 0, 0};
  TiltLean slope_J{0, 0};
  for (int i = 0; i < nodes; ++i) {
    force = force + make_vec3<double>(answer[i].force_on_tool_N) * state.weight[i];
    out.stored_J += state.weight[i] * state.stored_J[i];
    slope_J.first += at.d_first[i] * state.stored_J[i];
    slope_J.second += at.d_second[i] * state.stored_J[i];
  }
  const Vec3d tilting = tilt_torque(frame, shaft, slope_J) * -1.0;
  put(force, out.force_on_tool_N);
  put(tilting, out.tilt_torque_Nm);
  put(cross(u, force) * radius + tilting, out.torque_on_tool_Nm);
  put(make_vec3<double>(answer[heaviest].contact_m), out.contact_m);
  put(u, out.normal);
  out.normal_m = answer[heaviest].normal_m;
  out.state = answer[heaviest].state;
  out.flags = answer[heaviest].flags;
  return Status::ok;
}

}  // namespace runtime
}  // namespace palpate
