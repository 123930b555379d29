// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// One tick of the engine: a tip position in, a force out. No heap, no lock, no exception, no clock.

#include "mesh_surface.hpp"
#include "status.hpp"
#include "sweep.hpp"

namespace palpate {
namespace runtime {

/// What one tool remembers between ticks. The caller allocates it, one per tool; a fresh one is in
/// the air and knows no tip yet. Plain data: copy it to rewind, compare it to test.
struct Contact {
  bool has_tip = false;
  double tip_m[3] = {0, 0, 0};     ///< previous tip, relative to the asset's origin
  int triangle = -1;               ///< -1 in the air
  double weight[3] = {0, 0, 0};    ///< area coordinates of the contact point
  double dissipated_J = 0;         ///< by slips, since the Contact is in use
  double refused_J = 0;            ///< energy that slips would have created, each joule once
  double withheld_J = 0;           ///< refused at the latest tick
  std::int64_t refused_ticks = 0;  ///< ticks at which the guard acted
};

enum class ContactState { air, stick, slip };

/// What a tick brings. In the air, and with any status but ok, the force is exactly zero.
struct Output {
  double force_on_tool_N[3] = {0, 0, 0};  ///< what a device displays; the body feels the negative
  double contact_m[3] = {0, 0, 0};        ///< contact point in body coordinates
  int triangle = -1;
  double weight[3] = {0, 0, 0};        ///< its area coordinates
  double normal_m = 0, lateral_m = 0;  ///< dz, dr (from where the body leans to)
  ContactState state = ContactState::air;
  unsigned flags = 0;                      ///< kFlag... of mesh_surface.hpp
  double stored_J = 0;                     ///< elastic energy now
  double dissipated_J = 0, refused_J = 0;  ///< running sums of the Contact
  std::int64_t refused_ticks = 0;
};

/// Contact ends; the running sums and the tip stay.
inline void release(Contact& contact) noexcept {
  contact.triangle = -1;
  contact.withheld_J = 0;
  for (double& weight : contact.weight) weight = 0;
}

/// Everything but the running sums is forgotten: contact begins again from outside.
inline void forget(Contact& contact) noexcept {
  release(contact);
  contact.has_tip = false;
}

/// A contact point whose curves are all zero: the outer rim of a skirt. There contact ends: coming
/// back at depth would store energy that nobody supplied.
inline bool is_powerless(const AssetView& asset, const Contact& contact) noexcept {
  for (int k = 0; k < 3; ++k)
    if (contact.weight[k] > 0 && asset.covered[asset.corner(contact.triangle, k)]) return false;
  return true;
}

/// Begins contact where the way from p to x enters the body, if it does.
inline void seek_contact(const AssetView& asset, Contact& contact, const Vec3d& p,
                         const Vec3d& x) noexcept {
  const Entry entry = first_entry(asset, p, x);
  contact.triangle = entry.triangle;
  for (int k = 0; k < 3; ++k) contact.weight[k] = entry.n[k];
}

inline void account(Contact& contact, const MeshSurface& surface) noexcept {
  const double refused_J = surface.refused_J();
  contact.dissipated_J += surface.dissipated_J();
  // A slip refused at one tick is asked for again at the next: only what is new counts.
  if (refused_J > contact.withheld_J) contact.refused_J += refused_J - contact.withheld_J;
  if (refused_J > 0) ++contact.refused_ticks;
  contact.withheld_J = refused_J;
}

/// Slides, then releases or answers with a force: the order matters (no pop at lift-off).
inline Status answer(const AssetView& asset, Contact& contact, const Vec3d& x,
                     Output& out) noexcept {
  MeshSurface surface(asset, contact.triangle, contact.weight);
  const SlideEnd end = slide(asset.curves, x, surface);
  account(contact, surface);
  contact.triangle = surface.triangle();
  for (int k = 0; k < 3; ++k) contact.weight[k] = surface.weights()[k];
  const MeshSpot<double> spot = surface.standing();
  const Deflection<double> d = deflection(asset.curves, spot, x);
  const bool is_lifted = !(d.normal_m > 0) && end != SlideEnd::unfinished;
  if (is_lifted || is_powerless(asset, contact)) {
    release(contact);
    return Status::ok;
  }
  const Vec3d force = response(asset.curves, spot, d);
  const double stored_J = stored_energy_J(asset.curves, spot, x);
  if (!is_finite(force) || !std::isfinite(stored_J)) {
    forget(contact);
    return Status::force_not_finite;
  }
  out.force_on_tool_N[0] = -force.x;
  out.force_on_tool_N[1] = -force.y;
  out.force_on_tool_N[2] = -force.z;
  out.contact_m[0] = spot.point.x + asset.origin_m[0];
  out.contact_m[1] = spot.point.y + asset.origin_m[1];
  out.contact_m[2] = spot.point.z + asset.origin_m[2];
  out.triangle = contact.triangle;
  for (int k = 0; k < 3; ++k) out.weight[k] = contact.weight[k];
  out.normal_m = d.normal_m;
  out.lateral_m = d.lateral_m;
  out.state = end == SlideEnd::stick ? ContactState::stick : ContactState::slip;
  out.stored_J = stored_J;
  out.flags = surface.flags();
  if (end == SlideEnd::unfinished) out.flags |= kFlagUnfinished;
  if (d.normal_m > double(asset.max_depth_m[contact.triangle])) out.flags |= kFlagTooDeep;
  if (is_frictionless(asset.curves, spot)) out.flags |= kFlagFrictionless;
  return Status::ok;
}

/// The force on a tool whose tip (reference point) is at tip_m [m], in body coordinates.
/// Call once per tick, at any rate, with the Contact of that tool. The first tick only learns where
/// the tip is; a tip that starts inside the body feels nothing until it has come out and entered
/// again through a covered triangle; so does one that slid off over the rim of the covered surface,
/// where forces have faded to zero. Touch is swept from the previous tip, so nothing tunnels.
/// Refuses (status, zero force, contact reset): a tip that is not finite or moved farther than
/// asset.max_step_m in one tick; a contact of another asset; a force that is not finite.
/// Work: in the air the tree nodes along the way; in contact at most kMaxSegments segments of
/// kMaxRootSteps + 2 curve evaluations and kMaxGuardSteps + 2 energies. What does not fit into a
/// tick goes on at the next. Deterministic: the same bytes and tips give the same bits.
inline Status touch(const AssetView& asset, Contact& contact, const double tip_m[3],
                    Output& out) noexcept {
  out = Output();
  out.dissipated_J = contact.dissipated_J;
  out.refused_J = contact.refused_J;
  out.refused_ticks = contact.refused_ticks;
  const Vec3d x{tip_m[0] - asset.origin_m[0], tip_m[1] - asset.origin_m[1],
                tip_m[2] - asset.origin_m[2]};
  if (!is_finite(x)) {
    forget(contact);
    return Status::tip_not_finite;
  }
  if (contact.triangle >= asset.triangles || contact.triangle < -1) {
    forget(contact);
    return Status::contact_foreign;
  }
  const bool is_first = !contact.has_tip;
  const Vec3d before = is_first ? x : make_vec3<double>(contact.tip_m);
  contact.has_tip = true;
  contact.tip_m[0] = x.x;
  contact.tip_m[1] = x.y;
  contact.tip_m[2] = x.z;
  const Vec3d step = x - before;
  if (!(dot(step, step) <= asset.max_step_m * asset.max_step_m)) {
    release(contact);
    return Status::tip_teleported;
  }
  if (contact.triangle < 0) seek_contact(asset, contact, before, x);
  if (contact.triangle < 0) return Status::ok;
  const Status status = answer(asset, contact, x, out);
  out.dissipated_J = contact.dissipated_J;
  out.refused_J = contact.refused_J;
  out.refused_ticks = contact.refused_ticks;
  return status;
}

}  // namespace runtime
}  // namespace palpate
