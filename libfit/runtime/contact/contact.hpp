// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// The state of a ball's or a tip's contact from tick to tick, the output of a tick, and how
// contact begins and ends.

#include <cstring>

#include "../base/ledger.hpp"
#include "../base/once.hpp"
#include "../base/status.hpp"
#include "../law/compliance.hpp"
#include "../surface/spot_cache.hpp"
#include "../surface/sweep.hpp"
#include "../surface/sweep_ball.hpp"

namespace palpate::runtime {

/// Position of a contact point.
struct ContactPlace {
  int triangle = -1;             ///< -1 in the air
  double weight[3] = {0, 0, 0};  ///< area coordinates
  Arm arm;                       ///< of a ball, or of a tip that stands for one
  double slip_left_m = 0;        ///< of the slip budget, where a tick had too many segments
  double pending_J = 0;          ///< stored here and not yet loaded on the body (contact/body.hpp)
};
/// The same and what its law remembers: all that a slip changes.
struct ContactPoint : ContactPlace {
  double memory[kFamilyMemory] = {};  ///< what the family remembers beside the place
};

/// State of a contact in the series of the last tick (series/series.hpp): forces are found from
/// there. A rigid body has the force alone.
struct SeriesMemory {
  double force_N[3] = {0, 0, 0};                     ///< on the body
  double aside_m[3] = {0, 0, 0};                     ///< displacement of the body under it
  double flowed_N[kMaxBranches][3] = {};             ///< w_k (M49a) of a body that relaxes
  double holding_N_m[9] = {}, slipping_N_m[9] = {};  ///< stiffness where nothing slips, and where

  Vec3d force() const noexcept { return make_vec3<double>(force_N); }
  Vec3d flowed(int branch) const noexcept { return make_vec3<double>(flowed_N[branch]); }
};

/// State of one ball or tip between ticks. The caller allocates it; a fresh one is in the air
/// and knows no place yet. Plain data: copy it to rewind, compare it to test.
struct Contact : ContactPoint {
  bool has_tip = false;
  bool has_lifted = false;           ///< it ended and has not come out of the surface
  bool is_inside = false;            ///< in the air it began this tick in the surface
  bool has_side = false;             ///< of a tip in the air: whether is_under is known
  bool is_under = false;             ///< it is under the surface, and stays so until it comes out
  bool is_rested = false;            ///< half of this tick's time has passed on its memory
  std::uint64_t asset_checksum = 0;  ///< of the asset that it is used with
  double tip_m[3] = {0, 0, 0};  ///< tip or centre at the last tick, relative to the asset's origin
  /// Triangle over which a ball (a tip: the ball that it stands for) stands that has_lifted;
  /// weight, arm and memory are then those with which it resumes.
  int hover = -1;
  SeriesMemory series;
  Ledger ledger;     ///< of a contact by itself
  double law_J = 0;  ///< stored at the end of the last tick, of a body that relaxes
  Decay left;        ///< what half a tick leaves, of a body that remembers in time
  SpotCache cache;   ///< saves time, changes no bit
};

enum class ContactState { air, stick, slip };

/// Output of a tick. In the air, and with any status but ok, the force is exactly zero; of the
/// rest the air has PALPATE_FLAG_INSIDE alone.
struct Output {
  double force_on_tool_N[3] = {0, 0, 0};  ///< what a device displays; the body has the negative
  double contact_m[3] = {0, 0, 0};        ///< contact point c in body coordinates
  double acts_at_m[3] = {0, 0, 0};  ///< where the force acts: a tip, p + reach u of a ball (M15a)
  double normal[3] = {0, 0, 0};     ///< u(c), inward
  int triangle = -1;
  double weight[3] = {0, 0, 0};        ///< its area coordinates
  double normal_m = 0, lateral_m = 0;  ///< dz, dr of (M2); of rings d, |q|
  ContactState state = ContactState::air;
  unsigned flags = 0;                      ///< PALPATE_FLAG_...
  double law_share = 1;                    ///< of the law's force, what ledger and memories leave
  double stored_J = 0;                     ///< elastic energy now
  double dissipated_J = 0, refused_J = 0;  ///< running sums of the ledger
  std::int64_t refused_ticks = 0;
};

inline void put_sums(const Ledger& ledger, Output& out) noexcept {
  out.dissipated_J = ledger.dissipated_J;
  out.refused_J = ledger.refused_J;
  out.refused_ticks = ledger.refused_ticks;
}

/// Compliance of the body at a contact point.
inline Compliance compliance_at(const AssetView& asset, int triangle,
                                const double weight[3]) noexcept {
  Compliance out;
  const int part = sway_part_of(asset.curves.family);
  if (!asset.sways || part < 0) return out;
  for (int k = 0; k < 3; ++k) {
    const float* c = asset.node(asset.corner(triangle, k)) + asset.control_offset[part];
    for (int i = 0; i < 6; ++i) out.c[i] += weight[k] * double(c[i]);
  }
  return out;
}
inline bool any_sway(const AssetView& asset) noexcept {
  const int part = sway_part_of(asset.curves.family);
  if (part < 0) return false;
  for (int v = 0; v < asset.vertices; ++v)
    for (int i = 0; i < 6; ++i)
      if (asset.node(v)[asset.control_offset[part] + i] != 0) return true;
  return false;
}

/// Contact ends; the running sums and the tip stay.
inline void release(Contact& contact) noexcept {
  static_cast<ContactPoint&>(contact) = ContactPoint();
  contact.series = SeriesMemory();
  contact.law_J = 0;
  contact.has_side = false;
  clear(contact.cache);
}
/// The same with the energy at law_J, which the contact's own ledger books.
inline void release(Contact& contact, double law_J) noexcept {
  contact.ledger.close(law_J);
  release(contact);
}

/// Everything but the running sums is forgotten: contact begins again from outside.
inline void forget(Contact& contact) noexcept {
  release(contact, 0);
  contact.has_lifted = false;
  contact.has_tip = false;
}

/// A contact point whose curves are all zero: the outer rim of a skirt. There contact ends: coming
/// back at depth would store energy that nobody supplied.
inline bool is_powerless(const AssetView& asset, const ContactPoint& point) noexcept {
  for (int k = 0; k < 3; ++k)
    if (point.weight[k] > 0 && asset.covered[asset.corner(point.triangle, k)]) return false;
  return true;
}

/// Returns true if a ball at p that lifted off is still within the facets. It resumes contact then
/// at the place under it, where nothing is deflected, so that nothing is stored.
inline bool resumes_contact(Contact& contact, const BallEntry& entry, double radius_m) noexcept {
  contact.is_inside = !entry.is_clear;
  const bool had_lifted = contact.has_lifted;
  contact.has_lifted = false;
  if (had_lifted && contact.is_inside) {
    contact.triangle = contact.hover;
    if (contact.arm.reach_m > radius_m) contact.arm.reach_m = radius_m;
    return true;
  }
  if (had_lifted) release(contact, 0);
  return false;
}

/// Begins contact where a ball on its path from p to x first touches the body, if it does; splits
/// its arm (M15).
inline void find_contact(const AssetView& asset, Contact& contact, const Vec3d& p, const Vec3d& x,
                         double radius_m) noexcept {
  const BallEntry entry = first_ball_entry(asset, p, x, radius_m);
  if (resumes_contact(contact, entry, radius_m)) return;
  if (entry.triangle < 0 || entry.is_inside) return;
  contact.triangle = entry.triangle;
  for (int k = 0; k < 3; ++k) contact.weight[k] = entry.n[k];
  const Vec3d u = blended_normal(asset, entry.triangle, entry.n);
  contact.arm.reach_m = dot(entry.arm, u);
  const Vec3d skew = entry.arm - u * contact.arm.reach_m;
  put(skew, contact.arm.skew_m);
}

/// Begins contact where the path of a tip from p to x enters the body, if it does. The tip then
/// stands for the ball that the body was measured with (M15a), and goes on being it until that ball
/// has come out of the facets: where it lifted off, the tip itself may be below them, from where no
/// path enters. A tip that is under the surface otherwise has no force, and a flag.
inline void find_contact(const AssetView& asset, Contact& contact, const Vec3d& p,
                         const Vec3d& x) noexcept {
  if (contact.has_lifted) {
    const Vec3d pole = make_vec3<double>(contact.arm.pole_m);
    const BallEntry ball = first_ball_entry(asset, p - pole, x - pole, asset.probe_radius_m);
    if (resumes_contact(contact, ball, asset.probe_radius_m)) return;
  }
  if (!contact.has_side) contact.is_under = is_under(asset, p);
  contact.has_side = true;
  contact.is_inside = contact.is_under;
  if (contact.is_under) contact.has_side = first_entry(asset, x, p).triangle < 0;
  const Entry entry = first_entry(asset, p, x);
  contact.triangle = entry.triangle;
  for (int k = 0; k < 3; ++k) contact.weight[k] = entry.n[k];
  if (entry.triangle < 0) return;
  contact.arm.reach_m = asset.probe_radius_m;
  put(blended_normal(asset, entry.triangle, entry.n) * asset.probe_radius_m, contact.arm.pole_m);
}

/// The guards of inputs, and first touch, of a ball or a tip (radius 0) at x from the asset's
/// origin. aside_m: displacement of the surface now; contact.series has that of
/// the tick before, so that a moving surface touches, too. is_in_time: time changes what the body
/// remembers. step: of the tool itself.
PALPATE_ONCE Status approach(const AssetView& asset, Contact& contact, const Vec3d& x,
                             const Vec3d& aside_m, double radius_m, bool is_in_time, double dt_s,
                             Vec3d& step) noexcept
#if PALPATE_HAS_BODIES
{
  if (!is_finite(x)) {
    forget(contact);
    return Status::tip_not_finite;
  }
  if (is_in_time) {
    if (!(dt_s >= kMinTimeStep_s && dt_s <= kMaxTimeStep_s)) {
      forget(contact);
      return Status::time_step_wrong;
    }
    if (contact.left.dt_s != 0.5 * dt_s)
      contact.left = decay_over(asset.curves.relaxation, 0.5 * dt_s);
  }
  const bool is_first = !contact.has_tip;
  if (is_first) contact.asset_checksum = asset.checksum;
  if (contact.asset_checksum != asset.checksum || contact.triangle >= asset.triangles ||
      contact.triangle < -1) {
    forget(contact);
    return Status::contact_foreign;
  }
  const Vec3d before = is_first ? x : make_vec3<double>(contact.tip_m);
  contact.has_tip = true;
  put(x, contact.tip_m);
  step = x - before;
  if (!(dot(step, step) <= asset.max_step_m * asset.max_step_m)) {
    release(contact, 0);
    contact.has_lifted = false;
    return Status::tip_teleported;
  }
  contact.is_rested = contact.triangle < 0;
  if (contact.triangle >= 0) return Status::ok;
  const Vec3d from = before - make_vec3<double>(contact.series.aside_m), to = x - aside_m;
  if (radius_m > 0)
    find_contact(asset, contact, from, to, radius_m);
  else
    find_contact(asset, contact, from, to);
  put(aside_m, contact.series.aside_m);
  return Status::ok;
}
#else
    ;
#endif

}  // namespace palpate::runtime
