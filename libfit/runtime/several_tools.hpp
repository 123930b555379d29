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

#include "tool.hpp"

namespace palpate {
namespace runtime {

constexpr int kMaxTools = 8;
constexpr int kMaxJointSteps = 16;        ///< answers of each law for one root; 3 to 5 as a rule
constexpr double kJointTolerance = 1e-7;  ///< of the forces; stored energy is then right to 1e-14
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

/// Solves m x = b of n unknowns by elimination with pivots, into b; false where there is none.
inline bool eliminate(double m[3 * kMaxTools][3 * kMaxTools], double b[3 * kMaxTools],
                      int n) noexcept {
  for (int c = 0; c < n; ++c) {
    int pivot = c;
    for (int r = c + 1; r < n; ++r)
      if (std::fabs(m[r][c]) > std::fabs(m[pivot][c])) pivot = r;
    if (!(std::fabs(m[pivot][c]) > 1e-9)) return false;
    for (int k = c; k < n && pivot != c; ++k) {
      const double kept = m[c][k];
      m[c][k] = m[pivot][k];
      m[pivot][k] = kept;
    }
    const double kept = b[c];
    b[c] = b[pivot];
    b[pivot] = kept;
    for (int r = c + 1; r < n; ++r) {
      const double factor = m[r][c] / m[c][c];
      if (factor == 0) continue;
      for (int k = c; k < n; ++k) m[r][k] -= factor * m[c][k];
      b[r] -= factor * b[c];
    }
  }
  for (int r = n - 1; r >= 0; --r) {
    for (int k = r + 1; k < n; ++k) b[r] -= m[r][k] * b[k];
    b[r] /= m[r][r];
  }
  return true;
}

/// The contacts of a tick that couple: where they are, and how each moves the others.
struct JointContacts {
  int count = 0;
  int tool[kMaxTools];
  Vec3d x[kMaxTools];       ///< of the tools, from the asset's origin
  Vec3d point[kMaxTools];   ///< contact points
  Vec3d normal[kMaxTools];  ///< inward there
  Coupling at[kMaxTools][kMaxTools];
  Vec3d force[kMaxTools];
  double* stiffness_N_m[kMaxTools];

  Vec3d sunk(int i, const Vec3d* forces) const noexcept {
    Vec3d sum{0, 0, 0};
    for (int j = 0; j < count; ++j)
      if (j != i) sum = sum + coupled(at[i][j], normal[i], normal[j], forces[j]);
    return sum;
  }
  /// What the coupling stores under the forces.
  double coupling_J() const noexcept {
    double sum = 0;
    for (int i = 0; i < count; ++i) sum += 0.5 * dot(force[i], sunk(i, force));
    return sum;
  }
  void couple(const AssetView& asset) noexcept {
    for (int i = 0; i < count; ++i)
      for (int j = 0; j < i; ++j) {
        const Vec3d way = point[i] - point[j];
        at[i][j] = at[j][i] = coupling_at(*asset.coupling, dot(way, way));
      }
  }
};

/// Newton's step of (M63) from what is left of it: (1 + K C) step = rest.
inline void joint_step(const JointContacts& all, const Vec3d* rest, Vec3d* step) noexcept {
  double m[3 * kMaxTools][3 * kMaxTools], b[3 * kMaxTools];
  const Vec3d axis[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  for (int i = 0; i < all.count; ++i) {
    put(rest[i], b + 3 * i);
    for (int j = 0; j < all.count; ++j)
      for (int c = 0; c < 3; ++c) {
        const Vec3d column =
            i == j ? axis[c]
                   : times(all.stiffness_N_m[i],
                           coupled(all.at[i][j], all.normal[i], all.normal[j], axis[c]));
        m[3 * i][3 * j + c] = column.x;
        m[3 * i + 1][3 * j + c] = column.y;
        m[3 * i + 2][3 * j + c] = column.z;
      }
  }
  const bool is_solved = eliminate(m, b, 3 * all.count);
  for (int i = 0; i < all.count; ++i) step[i] = is_solved ? make_vec3<double>(b + 3 * i) : rest[i];
}

/// Brings all.force to the root of (M63), from what it is, by Newton's steps with stiffnesses that
/// each answer corrects (Broyden 1965). respond(i, y): the answer of contact i to a tool at y; its
/// last calls are with the forces that are kept. false: kMaxJointSteps were not enough, and the
/// nearest forces are kept.
template <class Respond>
bool settle_jointly(JointContacts& all, const Respond& respond) noexcept {
  const int n = all.count;
  if (n == 1) {
    all.force[0] = respond(0, all.x[0]);
    return true;
  }
  Vec3d place[kMaxTools], answer[kMaxTools], rest[kMaxTools], step[kMaxTools], next[kMaxTools];
  for (int i = 0; i < n; ++i) {
    place[i] = all.x[i] - all.sunk(i, all.force);
    answer[i] = respond(i, place[i]);
    rest[i] = answer[i] - all.force[i];
  }
  bool is_root = false, is_last = true;
  for (int k = 0; k < kMaxJointSteps; ++k) {
    double error = 0, size = 0;
    for (int i = 0; i < n; ++i) {
      error += dot(rest[i], rest[i]);
      size += dot(answer[i], answer[i]);
    }
    is_root = error <= kJointTolerance * kJointTolerance * size + kSwayZero_N * kSwayZero_N;
    if (is_root || !(error < 1e300)) break;
    joint_step(all, rest, step);
    for (int i = 0; i < n; ++i) next[i] = all.force[i] + step[i];
    double next_error = 0;
    Vec3d next_place[kMaxTools], next_answer[kMaxTools];
    for (int i = 0; i < n; ++i) {
      next_place[i] = all.x[i] - all.sunk(i, next);
      next_answer[i] = respond(i, next_place[i]);
      const Vec3d left = next_answer[i] - next[i];
      next_error += dot(left, left);
      const Vec3d moved = next_place[i] - place[i];
      double* K = all.stiffness_N_m[i];
      const Vec3d off = next_answer[i] - answer[i] - times(K, moved);
      const double squared = dot(moved, moved);
      if (!(squared > 0) || !is_finite(off)) continue;
      const Vec3d way = moved * (1 / squared);
      const double w[3] = {way.x, way.y, way.z}, o[3] = {off.x, off.y, off.z};
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) K[3 * r + c] += o[r] * w[c];
    }
    is_last = next_error < error;
    if (!is_last) continue;
    for (int i = 0; i < n; ++i) {
      all.force[i] = next[i];
      place[i] = next_place[i];
      answer[i] = next_answer[i];
      rest[i] = answer[i] - next[i];
    }
  }
  if (!is_last)
    for (int i = 0; i < n; ++i) respond(i, place[i]);
  return is_root;
}

/// Where a contact stands, for coupling: its point and the inward normal there.
inline void stand(const AssetView& asset, const Contact& contact, Vec3d& point,
                  Vec3d& normal) noexcept {
  point = {0, 0, 0};
  for (int k = 0; k < 3; ++k)
    point = point + asset.vertex_at(asset.corner(contact.triangle, k)) * contact.weight[k];
  normal = blended_normal(asset, contact.triangle, contact.weight);
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
    stand(asset, contact, last.point[k], last.normal[k]);
  }
  last.couple(asset);
  for (int i = 0, own = 0; i < n; ++i) {
    Contact& contact = *tool[i].contact;
    Vec3d sunk{0, 0, 0};
    if (own < last.count && last.tool[own] == i) {
      sunk = last.sunk(own++, last.force);
    } else {  // in the air: as if it touched along the other's normal
      for (int k = 0; k < last.count; ++k) {
        const Vec3d way = x[i] + last.normal[k] * tool[i].radius_m - last.point[k];
        sunk = sunk + coupled(coupling_at(*asset.coupling, dot(way, way)), last.normal[k],
                              last.normal[k], last.force[k]);
      }
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
    stand(asset, contact, all.point[k], all.normal[k]);
    start[k].contact = contact;
    is_ball[k] = tool[i].radius_m > 0 || asset.probe_radius_m > 0;
  }
  all.couple(asset);
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
      stand(asset, contact, now.point[m], now.normal[m]);
    }
    now.couple(asset);
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
