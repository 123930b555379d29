// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// A tool with a round end that turns (docs/method.md, section 27): pose in, force and torque out.
// Where the asset has curves over the lean, the contact's curves are those of its lean
// (lean_spot.hpp):
//
//     U = W(d, s) + ...     force = dU/dx     torque about the end's centre
//                                             = R u x f + dU/ds ds/d(turn) + spin       (M61)
//
// A turn works on U by that torque: what the end's surface drags along moves the tool aside. What
// another normal changes of the lean is a slip's, and the contact's ledger books it.

#include "spin.hpp"
#include "tool.hpp"

namespace palpate {
namespace runtime {

/// Whether touch_turning() takes the asset: of rings that a ball was measured with, and no body
/// that tools puncture, because a channel knows no lean.
inline bool is_turnable(const AssetView& asset) noexcept {
  return asset.curves.family == int(Family::rings) && asset.probe_radius_m > 0 &&
         asset.channels == nullptr;
}

/// One such tool on one body: what is remembered between ticks. Plain data.
struct TurningContact {
  Contact contact;
  LeanSpot lean;
  Spin spin;
  double spin_lost_J = 0;
  bool has_pose = false;
  double row[3][3] = {};         ///< of the turn from the tool's axes to the body's
  double roll_m[3] = {0, 0, 0};  ///< how far the end's surface has dragged the contact
  double normal[3] = {0, 0, 0};  ///< of the contact at the last tick
};

/// In body coordinates.
struct TurningOutput {
  double force_on_tool_N[3] = {0, 0, 0};
  double torque_on_tool_Nm[3] = {0, 0, 0};  ///< about the end's centre
  double tilt_torque_Nm[3] = {0, 0, 0};     ///< its part by the lean
  double spin_torque_Nm = 0;                ///< its part about the inward normal
  double contact_m[3] = {0, 0, 0};
  double normal[3] = {0, 0, 0};
  double normal_m = 0, lateral_m = 0;
  TiltLean lean{0, 0};
  ContactState state = ContactState::air;
  unsigned flags = 0;
  double stored_J = 0, dissipated_J = 0;
  Output tick;  ///< of the contact itself
};

/// What dragged the contact aside and twisted it is over.
inline void unwind(TurningContact& state) noexcept {
  state.spin = Spin();
  for (int k = 0; k < 3; ++k) state.roll_m[k] = 0;
}
/// Contact ends, and where the tool was is forgotten.
inline void forget(TurningContact& state) noexcept {
  forget(state.contact);
  unwind(state);
  state.has_pose = false;
}

/// How a contact stands at the place where its tool was last.
inline RingDeflection<double> standing_rings(const AssetView& asset, Contact& contact) noexcept {
  Vec3d y = make_vec3<double>(contact.tip_m);
  const Compliance give = compliance_at(asset, contact.triangle, contact.weight);
  if (give.is_any())
    y = y - give.times(slow_force(asset.curves.relaxation, contact.sway, contact.sway.force()));
  const CachedSpot spot = cached_spot<Rings, true>(asset, contact);
  return ring_deflection(spot, contact.cache.numbers.curvature, y);
}
/// What the law stores there.
inline double law_energy(const AssetView& asset, Contact& contact,
                         const RingDeflection<double>& at) noexcept {
  const CurveViews& views = asset.curves;
  const auto memory = Rings::load<double>(contact.memory, views.relaxation);
  const CachedSpot spot = cached_spot<Rings, true>(asset, contact);
  const RingKinematics<double, CachedSpot> kinematics{
      spot, {at.depth_m, 0}, at, contact.cache.numbers.limit, at.q - memory.at(0), 0, 0, 1};
  return Rings::stored_J(views, Rings::under(views, kinematics), kinematics, memory);
}

/// dE/dc_i of the rings' energy [m^2], for c_i before any is cut (ring_share()). anchors: x, y, z.
inline void ring_energy_slopes(const RingTable<kRings>& table, const RingBed<double, kRings>& bed,
                               const RingDeflection<double>& at, const double* anchors,
                               double* out) noexcept {
  const double lambda = bed.limit.lambda;
  double half[kRings], stored = 0, kept = 0, cut = 0;
  for (int i = 0; i < kRings; ++i) {
    const double x = at.q.x - anchors[i], y = at.q.y - anchors[kRings + i],
                 z = at.q.z - anchors[2 * kRings + i];
    half[i] = 0.5 * (x * x + y * y + z * z);
    out[i] = lambda * half[i];
  }
  if (!bed.is_cut) return;
  for (int i = 0; i < kRings; ++i) {
    const double reach = at.depth_m - table.threshold_m[i];
    stored += bed.stiffness_N_m[i] * half[i];
    if (!(reach > 0)) continue;
    kept += bed.stiffness_N_m[i] * reach;
    cut += bed.excess_N_m[i] * reach;
  }
  const bool is_shared = kept > cut;
  const double share = is_shared ? 1 - cut / kept : kept > 0 ? 0 : 1;
  for (int i = 0; i < kRings; ++i) {
    const double reach = at.depth_m - table.threshold_m[i];
    const bool is_cut = bed.excess_N_m[i] > 0;
    double slope = is_cut ? 0 : share * half[i];
    if (is_shared && reach > 0) slope += stored * (is_cut ? 1 : cut / kept) * (reach / kept);
    out[i] = lambda * slope;
  }
}

/// dE/ds of the law's energy at a contact that stays (M67). Exact; of a body that relaxes by
/// central differences, whose dashpots do not see the lean in one row.
inline TiltLean lean_slope(const AssetView& asset, Contact& contact,
                           const RingDeflection<double>& at) noexcept {
  LeanSpot& lean = *contact.cache.lean;
  const double d = at.depth_m;
  TiltLean out{0, 0};
  if (asset.curves.relaxation.branches > 0) {
    constexpr double kStep = 1e-5;
    const Vec3d shaft = lean.shaft;
    const TiltFrame frame = lean.frame;
    for (int axis = 0; axis < 2; ++axis) {
      const Vec3d& along = axis == 0 ? frame.first : frame.second;
      turn(contact.cache, asset, shaft + along * kStep);
      const double up_J = law_energy(asset, contact, at);
      turn(contact.cache, asset, shaft - along * kStep);
      (axis == 0 ? out.first : out.second) = (up_J - law_energy(asset, contact, at)) / (2 * kStep);
    }
    turn(contact.cache, asset, shaft);
    return out;
  }
  double by[kLeanRow] = {};
  lean.stand(asset, contact.triangle, contact.weight);
  ring_energy_slopes(asset.curves.rings, contact.cache.bed, at, contact.memory, by);
  if (d > 0) {
    const SplineView& view = asset.curves.view[kNormal];
    const int interval = find_piece(
        view, d,
        contact.cache.curve[kNormal].piece >= 0 ? contact.cache.curve[kNormal].piece : view.pieces);
    lean.reach(asset, interval);
    constexpr double kShare[kMaxDegree + 1] = {1.0, 1.0 / 2, 1.0 / 3, 1.0 / 4, 1.0 / 5};
    const double t = d - view.knots[interval];
    const Vec3d q1 =
        at.q - Vec3d{contact.memory[0], contact.memory[kRings], contact.memory[2 * kRings]};
    double power = t;
    for (int m = 0; m <= kMaxDegree; ++m, power *= t) by[kLeanPieceAt + m] = power * kShare[m];
    by[kLeanAreaAt] = 1;
    put(q1 * (d * d), by + kLeanSideAt);
    put(q1 * (d * d * d), by + kLeanSideAt + 3);
  }
  static_assert(kLeanRow % 4 == 0, "four sums at a time: one chain would wait for each");
  for (int i = 0; i < asset.leans.nodes.size(); ++i) {
    if (lean.at.w[i] == 0) continue;  // flat where it is 0: w >= 0 is C1
    const double* own = lean.row[i];
    double a = 0, b = 0, c = 0, e = 0;
    for (int j = 0; j < kLeanRow; j += 4) {
      a += by[j] * own[j];
      b += by[j + 1] * own[j + 1];
      c += by[j + 2] * own[j + 2];
      e += by[j + 3] * own[j + 3];
    }
    const double stored_J = (a + b) + (c + e);
    out.first += lean.at.d_first[i] * stored_J;
    out.second += lean.at.d_second[i] * stored_J;
  }
  return out;
}

/// The share of the law's force that a contact bears: dU/dE of its debt (M20) and its damage.
inline double borne_share(const Contact& contact, double stored_J) noexcept {
  const Ledger& ledger = contact.ledger;
  if (!(ledger.debt_J > 0)) return contact.damage_share;
  const double half = 0.5 * stored_J;
  return contact.damage_share *
         ledger.share(half + std::sqrt(half * half + ledger.debt_J * stored_J));
}

inline Status turning_tick(const AssetView& asset, TurningContact& state, const double centre_m[3],
                           const Frame& tool, TurningOutput& out, double dt_s) noexcept {
  Contact& contact = state.contact;
  const double radius = asset.probe_radius_m;
  const Vec3d shaft{tool.row[0].z, tool.row[1].z, tool.row[2].z};
  const bool leans = asset.leans.nodes.tilts > 0;
  const bool was_touching = contact.triangle >= 0 && state.has_pose;
  Vec3d turned{0, 0, 0}, roll = make_vec3<double>(state.roll_m);
  if (was_touching) {
    turned = turn_since(state.row, tool);
    roll = roll + cross(turned, make_vec3<double>(state.normal)) * radius;
  }
  if (leans) {  // what the turn changes is work of the tool
    turn(contact.cache, asset, shaft);
    if (was_touching && contact.triangle < asset.triangles && asset.curves.relaxation.branches > 0)
      contact.law_J = law_energy(asset, contact, standing_rings(asset, contact));
  }
  for (int i = 0; i < 3; ++i) put(tool.row[i], state.row[i]);
  put(roll, state.roll_m);
  state.has_pose = true;
  const double fed_m[3] = {centre_m[0] + roll.x, centre_m[1] + roll.y, centre_m[2] + roll.z};
  const Status status = touch_ball(asset, contact, fed_m, radius, out.tick, nullptr, dt_s);
  if (status != Status::ok || out.tick.state == ContactState::air) {
    // What dragged the contact aside is over; it begins anew from where the tool is.
    if (dot(roll, roll) > 0) forget(contact);
    for (int i = 0; i < kRings; ++i)
      state.spin_lost_J +=
          0.5 * state.spin.stiffness_Nm[i] * state.spin.angle[i] * state.spin.angle[i];
    unwind(state);
    const Output tick = out.tick;
    out = TurningOutput();
    out.tick = tick;
    out.dissipated_J = tick.dissipated_J + state.spin_lost_J;
    return status;
  }
  out.state = out.tick.state;
  out.lean = {0, 0};
  const Vec3d u = make_vec3<double>(out.tick.normal);
  put(u, state.normal);
  const RingDeflection<double> at = standing_rings(asset, contact);
  Vec3d tilting{0, 0, 0};
  if (leans) {
    const TiltLean slope = lean_slope(asset, contact, at);
    const double share = borne_share(contact, out.tick.stored_J);
    out.lean = state.lean.lean;
    tilting =
        tilt_torque(state.lean.frame, shaft, {slope.first * share, slope.second * share}) * -1.0;
  }
  const SpinAnswer spin =
      spin_by(asset.curves.rings, contact.cache.bed, at, contact.memory,
              spin_gap_m(radius, contact.cache.numbers.curvature), dot(turned, u), state.spin);
  state.spin_lost_J += spin.lost_J;
  const Vec3d force = make_vec3<double>(out.tick.force_on_tool_N);
  put(force, out.force_on_tool_N);
  put(tilting, out.tilt_torque_Nm);
  out.spin_torque_Nm = -spin.torque_Nm;
  put(cross(u, force) * radius + tilting + u * out.spin_torque_Nm, out.torque_on_tool_Nm);
  put(make_vec3<double>(out.tick.contact_m), out.contact_m);
  put(u, out.normal);
  out.normal_m = out.tick.normal_m;
  out.lateral_m = out.tick.lateral_m;
  out.flags = out.tick.flags;
  out.stored_J = out.tick.stored_J + spin.stored_J;
  out.dissipated_J = out.tick.dissipated_J + state.spin_lost_J;
  return status;
}

/// One tick of the tool whose end has its centre at centre_m [m] and whose frame is `tool`, both as
/// the body sees them; the tool's own z is its shaft, away from the end. The end is the ball that
/// the asset was measured with. Otherwise as touch_ball(); refuses assets that are not
/// is_turnable().
inline Status touch_turning(const AssetView& asset, TurningContact& state, const double centre_m[3],
                            const Frame& tool, TurningOutput& out, double dt_s = 0) noexcept {
  if (!is_turnable(asset)) {
    out = TurningOutput();
    forget(state);
    return Status::tool_wrong;
  }
  state.contact.cache.lean = asset.leans.nodes.tilts > 0 ? &state.lean : nullptr;
  const Status status = turning_tick(asset, state, centre_m, tool, out, dt_s);
  state.contact.cache.lean = nullptr;
  if (status != Status::ok) forget(state);
  return status;
}

/// Such a tool with its shape: offset_m is the end's centre, radius_m that of the asset's ball. It
/// has no damper.
struct TurningTool {
  ToolShape shape;
  TurningContact turning;
  double since_start_s = 0;
};

/// In world coordinates; `body` is the tick in body coordinates.
struct TurningToolOutput {
  TurningOutput body;
  double force_on_tool_N[3] = {0, 0, 0};
  double torque_on_tool_Nm[3] = {0, 0, 0};  ///< about the tool pose's position
  double contact_m[3] = {0, 0, 0};
  double acts_at_m[3] = {0, 0, 0};
  double normal[3] = {0, 0, 0};
  bool has_touched = false, has_released = false;
};

/// touch_turning() of a tool at `tool` on a body at `body`, both in world coordinates. Ramp and cap
/// of the force lower the torque alike. Refuses bad poses and time steps, and a radius that is not
/// the asset's: zero force and a status.
inline Status touch_turning_tool(const AssetView& asset, TurningTool& state, const Pose& tool,
                                 const Pose& body, double dt_s, TurningToolOutput& out) noexcept {
  out = TurningToolOutput();
  const ToolShape& shape = state.shape;
  const bool has_time = dt_s >= kMinTimeStep_s && dt_s <= kMaxTimeStep_s;
  const bool is_timed = has_time || !(shape.ramp_s > 0);
  const bool is_ours = !shape.has_damper() && shape.radius_m == asset.probe_radius_m;
  Frame tool_frame, body_frame;
  if (!is_timed || !is_ours || !make_frame(tool, tool_frame) || !make_frame(body, body_frame)) {
    forget(state.turning);
    return !is_ours ? Status::tool_wrong : is_timed ? Status::pose_wrong : Status::time_step_wrong;
  }
  const Vec3d centre = tool_frame.place(make_vec3<double>(shape.offset_m));
  double centre_m[3];
  put(body_frame.place_back(centre), centre_m);
  const Frame seen = seen_from(body_frame, tool_frame);
  if (has_time) state.since_start_s += dt_s;
  const bool was_touching = state.turning.contact.triangle >= 0;
  const Status status = touch_turning(asset, state.turning, centre_m, seen, out.body, dt_s);
  const bool touches = out.body.state != ContactState::air;
  out.has_touched = touches && !was_touching;
  out.has_released = was_touching && !touches;
  if (!touches) return status;
  const Vec3d whole = make_vec3<double>(out.body.force_on_tool_N);
  const Vec3d borne = limited(shape, state.since_start_s, whole, out.body.flags);
  const double squared = dot(whole, whole),
               share = squared > 0 ? std::sqrt(dot(borne, borne) / squared) : 1;
  const Vec3d force = body_frame.turn(borne),
              torque = body_frame.turn(make_vec3<double>(out.body.torque_on_tool_Nm)) * share;
  const Vec3d u = body_frame.turn(make_vec3<double>(out.body.normal));
  put(force, out.force_on_tool_N);
  put(cross(centre - tool_frame.origin, force) + torque, out.torque_on_tool_Nm);
  put(body_frame.place(make_vec3<double>(out.body.contact_m)), out.contact_m);
  put(centre + u * asset.probe_radius_m, out.acts_at_m);
  put(u, out.normal);
  return status;
}

}  // namespace runtime
}  // namespace palpate
