// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// Several tools that feel each other on one body (docs/method.md, section 28). What a contact bears
// moves the surface under the others by the coupling C (M62), so with R_i the law's answer
//
//     f_i = R_i(x_i - sum_j C_ij f_j)                                                   (M63)
//
// and together they store
//
//     E = sum_i E_i + 1/2 sum_ij f_i . C_ij f_j                                         (M64)
//
// whose gradient by the places of the tools are the forces; coupling is weak enough for E to be
// convex (M64a). One ledger (section 18) books what slips of any of them do to E.

#include <limits>

#include "joint_root.hpp"
#include "tool.hpp"

namespace palpate {
namespace runtime {

constexpr double kNowhere_m = std::numeric_limits<double>::infinity();
constexpr unsigned kFlagCrowded = 8192;  ///< the tool stands in another: see palpate.h

/// What tools on one body remember together between ticks, beside a Contact each; of a contact in
/// it the ledger is not used. A fresh one knows of no tools. Plain data.
struct Joint {
  std::uint64_t asset_checksum = 0;
  int tools = 0;
  Ledger ledger;
  double force_N[kMaxTools][3] = {};        ///< of the laws, on the body
  double stiffness_N_m[kMaxTools][9] = {};  ///< of the laws around there; saves steps
};

/// One of the tools at a tick. status: what its touch() would have returned.
struct JointTool {
  Contact* contact = nullptr;
  double place_m[3] = {0, 0, 0};  ///< of the tip or the ball's centre, in body coordinates
  double radius_m = 0;            ///< 0: a tip
  Output out;
  Status status = Status::ok;
};

/// Room for copies of contacts, which are made where they are needed alone.
union ContactRoom {
  Contact contact;
  ContactRoom() noexcept {}
};

/// Where a contact stands, for coupling: its point, the inward normal and the sway there.
inline void stand(const AssetView& asset, const Contact& contact, Vec3d& point, Vec3d& normal,
                  Compliance& sway) noexcept {
  point = {0, 0, 0};
  for (int k = 0; k < 3; ++k)
    point = point + asset.vertex_at(asset.corner(contact.triangle, k)) * contact.weight[k];
  normal = blended_normal(asset, contact.triangle, contact.weight);
  sway = compliance_at(asset, contact.triangle, contact.weight);
}

/// A contact of rings that slips, and one that holds.
inline Status answer_slipping(const AssetView& asset, Contact& contact, bool is_ball,
                              const Vec3d& place, const Vec3d& step, Output& out) noexcept {
  return is_ball ? answer<Rings, true>(asset, contact, place, step, false, nullptr, out)
                 : answer<Rings, false>(asset, contact, place, step, false, nullptr, out);
}
inline Answer<double> answer_holding(const AssetView& asset, Contact& contact, bool is_ball,
                                     const Vec3d& place) noexcept {
  return is_ball ? hold<Rings, true>(asset, contact, place)
                 : hold<Rings, false>(asset, contact, place);
}

/// Whether two tools stand in each other: where their coupling is only bounded, not known.
inline bool are_crowded(const AssetView& asset, const JointTool& a, const JointTool& b) noexcept {
  const Vec3d way = make_vec3<double>(a.place_m) - make_vec3<double>(b.place_m);
  const auto radius = [&](const JointTool& t) noexcept {
    return t.radius_m > 0 ? t.radius_m : asset.probe_radius_m;
  };
  const double reach = radius(a) + radius(b);
  return dot(way, way) < reach * reach;
}

/// The tools meet the surface where the others have brought it at the tick before: guards of
/// inputs and first touch, as of touch_ball(). before: of each, where its law saw it.
inline void approach_together(const AssetView& asset, const Joint& joint, JointTool* tool, int n,
                              Vec3d* x, Vec3d* before) noexcept {
  JointContacts last;
  Compliance sway[kMaxTools];
  for (int i = 0; i < n; ++i) {
    x[i] = make_vec3<double>(tool[i].place_m) - make_vec3<double>(asset.origin_m);
    before[i] = tool[i].contact->has_tip ? make_vec3<double>(tool[i].contact->tip_m) : x[i];
    const Contact& contact = *tool[i].contact;
    if (contact.triangle < 0 || contact.asset_checksum != asset.checksum ||
        contact.triangle >= asset.triangles)
      continue;
    const int k = last.count++;
    last.tool[k] = i;
    last.force[k] = make_vec3<double>(joint.force_N[i]);
    stand(asset, contact, last.point[k], last.normal[k], sway[k]);
  }
  last.couple(asset, sway);
  for (int i = 0, own = 0; i < n; ++i) {
    Contact& contact = *tool[i].contact;
    Vec3d sunk{0, 0, 0};
    if (own < last.count && last.tool[own] == i) {
      sunk = last.sunk(own++, last.force);
    } else {
      sunk = last.sunk_beside(asset, x[i], tool[i].radius_m);
    }
    Vec3d step{0, 0, 0};
    const double radius = tool[i].radius_m;
    tool[i].status = radius >= 0 && radius <= 1e3
                         ? approach(asset, contact, x[i] - sunk, radius, 0, step)
                         : Status::radius_wrong;
    if (tool[i].status == Status::radius_wrong) forget(contact);
  }
}

/// One tick of n tools, 1 to kMaxTools, always the same ones in the same order. Where the asset's
/// tools do not feel each other this is touch_ball() of each, bit for bit. Otherwise stored_J of
/// the outputs add up to what all store together, and sums are those of all together; a tool whose
/// status is not ok is out of contact, and the others go on. No tangents. Work: answers of each
/// law, 3 to 5 as a rule where all stick, three times that where one slides, at most 3
/// (kMaxJointSteps + 2).
inline void touch_together(const AssetView& asset, Joint& joint, JointTool* tool, int n,
                           double dt_s = 0) noexcept {
  if (asset.coupling == nullptr) {
    for (int i = 0; i < n; ++i)
      tool[i].status = touch_ball(asset, *tool[i].contact, tool[i].place_m, tool[i].radius_m,
                                  tool[i].out, nullptr, dt_s);
    return;
  }
  if (joint.tools != n || joint.asset_checksum != asset.checksum) {
    joint = Joint();
    joint.tools = n;
    joint.asset_checksum = asset.checksum;
    for (int i = 0; i < n; ++i) forget(*tool[i].contact);
  }
  Vec3d x[kMaxTools], before[kMaxTools];
  approach_together(asset, joint, tool, n, x, before);
  JointContacts all;
  Compliance sway[kMaxTools];
  ContactRoom start[kMaxTools];
  bool is_ball[kMaxTools];
  for (int i = 0; i < n; ++i) {
    Contact& contact = *tool[i].contact;
    tool[i].out = Output();
    contact.ledger = Ledger();
    if (contact.triangle < 0) {
      for (double& f : joint.force_N[i]) f = 0;
      for (double& k : joint.stiffness_N_m[i]) k = 0;
      continue;
    }
    const int k = all.count++;
    all.tool[k] = i;
    all.x[k] = x[i];
    all.force[k] = make_vec3<double>(joint.force_N[i]);
    all.stiffness_N_m[k] = joint.stiffness_N_m[i];
    stand(asset, contact, all.point[k], all.normal[k], sway[k]);
    start[k].contact = contact;
    is_ball[k] = tool[i].radius_m > 0 || asset.probe_radius_m > 0;
  }
  all.couple(asset, sway);
  const auto contact_of = [&](int k) noexcept -> Contact& { return *tool[all.tool[k]].contact; };
  const auto output_of = [&](int k) noexcept -> Output& { return tool[all.tool[k]].out; };

  double stored_J[kMaxTools] = {};
  bool is_settled = settle_jointly(all, [&](int k, const Vec3d& y) noexcept {
    Contact& contact = contact_of(k);
    contact = start[k].contact;
    Output& out = output_of(k);
    out = Output();
    const Vec3d from = before[all.tool[k]];
    tool[all.tool[k]].status = answer_slipping(
        asset, contact, is_ball[k], y - make_vec3<double>(contact.arm.pole_m), y - from, out);
    stored_J[k] = out.stored_J;
    put(y, contact.tip_m);
    return make_vec3<double>(out.force_on_tool_N) * -1.0;
  });
  bool has_slipped = false, has_moved = false;
  for (int k = 0; k < all.count; ++k) {
    const bool is_gone = contact_of(k).triangle < 0;
    has_moved = has_moved || is_gone || output_of(k).state == ContactState::slip;
    has_slipped = has_slipped || has_moved || contact_of(k).ledger.dissipated_J != 0;
  }
  double before_J = 0;
  if (has_slipped) {
    JointContacts sticking = all;
    double spare[kMaxTools][9], stuck_J[kMaxTools] = {};
    for (int k = 0; k < all.count; ++k) {
      for (int c = 0; c < 9; ++c) spare[k][c] = all.stiffness_N_m[k][c];
      sticking.stiffness_N_m[k] = spare[k];
    }
    is_settled = settle_jointly(sticking,
                                [&](int k, const Vec3d& y) noexcept {
                                  const Answer<double> law = answer_holding(
                                      asset, start[k].contact, is_ball[k],
                                      y - make_vec3<double>(start[k].contact.arm.pole_m));
                                  stuck_J[k] = law.stored_J;
                                  return law.force_N;
                                }) &&
                 is_settled;
    for (int k = 0; k < all.count; ++k) before_J += stuck_J[k];
    before_J += sticking.coupling_J();
  }
  if (has_moved) {  // contacts that have let go or stand elsewhere couple otherwise
    JointContacts now;
    for (int k = 0; k < all.count; ++k) {
      const int i = all.tool[k];
      Contact& contact = contact_of(k);
      if (contact.triangle < 0) {
        for (double& f : joint.force_N[i]) f = 0;
        for (double& c : joint.stiffness_N_m[i]) c = 0;
        continue;
      }
      const int m = now.count++;
      now.tool[m] = i;
      now.x[m] = all.x[k];
      now.force[m] = all.force[k];
      now.stiffness_N_m[m] = all.stiffness_N_m[k];
      is_ball[m] = is_ball[k];
      stand(asset, contact, now.point[m], now.normal[m], sway[m]);
    }
    now.couple(asset, sway);
    all = now;
    is_settled = settle_jointly(all,
                                [&](int k, const Vec3d& y) noexcept {
                                  Contact& contact = contact_of(k);
                                  const Answer<double> law =
                                      answer_holding(asset, contact, is_ball[k],
                                                     y - make_vec3<double>(contact.arm.pole_m));
                                  stored_J[k] = law.stored_J;
                                  put(law.force_N * -1.0, output_of(k).force_on_tool_N);
                                  put(y, contact.tip_m);
                                  return law.force_N;
                                }) &&
                 is_settled;
  }
  double after_J = all.coupling_J();
  for (int k = 0; k < all.count; ++k) after_J += stored_J[k];
  if (has_slipped) joint.ledger.book(before_J, after_J, asset.has_guard);
  if (all.count == 0) joint.ledger.close(after_J);
  const double share = joint.ledger.share(after_J);
  const double kept = after_J > 0 ? joint.ledger.stored_J(after_J) / after_J : 1;
  for (int k = 0; k < all.count; ++k) {
    Output& out = output_of(k);
    Contact& contact = contact_of(k);
    const int i = all.tool[k];
    put(all.force[k], joint.force_N[i]);
    put(all.force[k], contact.sway.force_N);
    out.stored_J = kept * (stored_J[k] + 0.5 * dot(all.force[k], all.sunk(k, all.force)));
    put(make_vec3<double>(out.force_on_tool_N) * share, out.force_on_tool_N);
    put(make_vec3<double>(out.acts_at_m) + all.x[k] - make_vec3<double>(contact.tip_m),
        out.acts_at_m);
    if (!is_settled) out.flags |= kFlagUnfinished;
    if (joint.ledger.debt_J > 0) out.flags |= kFlagHeldBack;
    for (int other = 0; other < n; ++other)
      if (other != i && are_crowded(asset, tool[i], tool[other])) out.flags |= kFlagCrowded;
  }
  for (int i = 0; i < n; ++i) {
    tool[i].contact->ledger = Ledger();
    if (tool[i].contact->triangle < 0) tool[i].out = Output();
    tool[i].out.dissipated_J = joint.ledger.dissipated_J;
    tool[i].out.refused_J = joint.ledger.refused_J;
    tool[i].out.refused_ticks = joint.ledger.refused_ticks;
  }
}

/// touch_together() of tools at poses `tool` [n] against a body at `body`, in world coordinates, as
/// touch_tool(): with dampers, ramps and caps, without tangents. A tool whose pose or time step is
/// refused is out of contact.
inline void touch_tools_together(const AssetView& asset, Joint& joint, ToolContact* const* state,
                                 const Pose* tool, const Pose& body, double dt_s, ToolOutput* out,
                                 Status* status, int n) noexcept {
  JointTool at[kMaxTools];
  ToolPlace place[kMaxTools];
  for (int i = 0; i < n; ++i) {
    out[i] = ToolOutput();
    status[i] = place_tool(asset, *state[i], tool[i], body, dt_s, place[i]);
    at[i].contact = &state[i]->contact;
    at[i].radius_m = state[i]->shape.radius_m;
    // No place at all is refused below, like any that is not finite.
    for (int k = 0; k < 3; ++k)
      at[i].place_m[k] = status[i] == Status::ok ? place[i].tip_m[k] : kNowhere_m;
  }
  touch_together(asset, joint, at, n, dt_s);
  for (int i = 0; i < n; ++i) {
    out[i].body = at[i].out;
    if (status[i] != Status::ok) {
      out[i].damped_J = state[i]->damped_J;
      continue;
    }
    status[i] = at[i].status;
    tell_tool(*state[i], place[i], dt_s, out[i]);
  }
}

}  // namespace runtime
}  // namespace palpate
