// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// What a tool's contact remembers from tick to tick, what a tick says, and how contact begins and
// ends.

#include "body/body.hpp"
#include "ledger.hpp"
#include "surface/spot_cache.hpp"
#include "surface/sweep.hpp"
#include "surface/sweep_ball.hpp"
#include "sway.hpp"

namespace palpate {
namespace runtime {

constexpr double kMinTimeStep_s = 1e-5;  ///< of a tick that reads time: 100 kHz
constexpr double kMaxTimeStep_s = 1e6;

/// What one tool remembers between ticks. The caller allocates it, one per tool; a fresh one is in
/// the air and knows no tip yet. Plain data: copy it to rewind, compare it to test.
struct Contact {
  bool has_tip = false;
  bool has_lifted = false;           ///< a ball that let go and has not come out of the surface
  bool is_inside = false;            ///< a tool in the air began this tick in the surface
  bool has_side = false;             ///< of a tip in the air: whether is_under is known
  bool is_under = false;             ///< it is under the surface, and stays so until it comes out
  std::uint64_t asset_checksum = 0;  ///< of the asset that it is used with
  double tip_m[3] = {0, 0, 0};       ///< previous tip or centre, relative to the asset's origin
  int triangle = -1;                 ///< -1 in the air
  int hover = -1;  ///< triangle over which a ball (a tip: the ball that it stands for) stands that
                   ///< has_lifted; weight, arm and memory are then those with which it goes on
  double weight[3] = {0, 0, 0};  ///< area coordinates of the contact point
  Arm arm;                       ///< of a ball in contact, or a tip that stands for one
  Ledger ledger;
  Sway sway;
  double slip_left_m = 0;             ///< of the slip budget, where a tick had too many segments
  double memory[kFamilyMemory] = {};  ///< what the family remembers beside the place
  // Of a body that relaxes: half a tick and what of each branch it leaves; whether it has passed at
  // this tick; what the law stored at the end of the last one.
  double half_tick_s = 0;
  Decay left;
  bool is_rested = false;
  double law_J = 0;
  // Of a body that is damaged, at this tick: the share of the law's force, and its slope [1/J].
  double damage_share = 1, damage_slope = 0;
  double untold_J = 0;  ///< borne here since its vertices were told
  ChannelContact hole;
  SpotCache cache;  ///< saves time, changes no bit
};

enum class ContactState { air, stick, slip };

/// What a tick brings. In the air, and with any status but ok, the force is exactly zero; of the
/// rest the air has kFlagInside alone.
struct Output {
  double force_on_tool_N[3] = {0, 0, 0};  ///< what a device displays; the body feels the negative
  double contact_m[3] = {0, 0, 0};        ///< contact point c in body coordinates
  double acts_at_m[3] = {0, 0, 0};  ///< where the force acts: a tip, p + reach u of a ball (M15a)
  double normal[3] = {0, 0, 0};     ///< u(c), inward
  int triangle = -1;
  double weight[3] = {0, 0, 0};        ///< its area coordinates
  double normal_m = 0, lateral_m = 0;  ///< dz, dr of (M2), (M3a); of rings d, |q|
  ContactState state = ContactState::air;
  unsigned flags = 0;                      ///< kFlag... of mesh_surface.hpp
  double stored_J = 0;                     ///< elastic energy now
  double dissipated_J = 0, refused_J = 0;  ///< running sums of the Contact's ledger
  std::int64_t refused_ticks = 0;
};

/// How the body gives as a whole at a contact point.
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

/// Contact ends with the law's energy at law_J; the running sums and the tip stay.
inline void release(Contact& contact, double law_J = 0) noexcept {
  contact.triangle = -1;
  contact.ledger.close(law_J);
  contact.sway = Sway();
  contact.slip_left_m = 0;
  contact.law_J = 0;
  contact.untold_J = 0;
  contact.hole = ChannelContact();
  contact.has_side = false;
  for (double& weight : contact.weight) weight = 0;
  contact.arm = Arm();
  for (double& number : contact.memory) number = 0;
  clear(contact.cache);
}

/// Everything but the running sums is forgotten: contact begins again from outside.
inline void forget(Contact& contact) noexcept {
  release(contact);
  contact.has_lifted = false;
  contact.has_tip = false;
}

/// A contact point whose curves are all zero: the outer rim of a skirt. There contact ends: coming
/// back at depth would store energy that nobody supplied.
inline bool is_powerless(const AssetView& asset, const Contact& contact) noexcept {
  for (int k = 0; k < 3; ++k)
    if (contact.weight[k] > 0 && asset.covered[asset.corner(contact.triangle, k)]) return false;
  return true;
}

/// Whether a ball at p that lifted off has not come out of the facets since. It goes on then from
/// the place over which it stands: there nothing is deflected, so nothing is stored.
inline bool goes_on(Contact& contact, const BallEntry& entry, double radius_m) noexcept {
  contact.is_inside = !entry.is_clear;
  const bool had_lifted = contact.has_lifted;
  contact.has_lifted = false;
  if (had_lifted && contact.is_inside) {
    contact.triangle = contact.hover;
    if (contact.arm.reach_m > radius_m) contact.arm.reach_m = radius_m;
    return true;
  }
  if (had_lifted) release(contact);
  return false;
}

/// Begins contact where a ball on its way from p to x first touches the body, if it does; splits
/// its arm (M15).
inline void seek_contact(const AssetView& asset, Contact& contact, const Vec3d& p, const Vec3d& x,
                         double radius_m) noexcept {
  const BallEntry entry = first_ball_entry(asset, p, x, radius_m);
  if (goes_on(contact, entry, radius_m)) return;
  if (entry.triangle < 0 || entry.is_inside) return;
  contact.triangle = entry.triangle;
  for (int k = 0; k < 3; ++k) contact.weight[k] = entry.n[k];
  const Vec3d u = blended_normal(asset, entry.triangle, entry.n);
  contact.arm.reach_m = dot(entry.arm, u);
  const Vec3d skew = entry.arm - u * contact.arm.reach_m;
  put(skew, contact.arm.skew_m);
}

/// Begins contact where the way of a tip from p to x enters the body, if it does. The tip then
/// stands for the ball that the body was measured with (M15a), and goes on being it until that ball
/// has come out of the facets: where it lifted off, the tip itself may be below them, from where no
/// way enters. A tip that is under the surface otherwise answers nothing, and says so.
inline void seek_contact(const AssetView& asset, Contact& contact, const Vec3d& p,
                         const Vec3d& x) noexcept {
  if (contact.has_lifted) {
    const Vec3d pole = make_vec3<double>(contact.arm.pole_m);
    const BallEntry ball = first_ball_entry(asset, p - pole, x - pole, asset.probe_radius_m);
    if (goes_on(contact, ball, asset.probe_radius_m)) return;
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

}  // namespace runtime
}  // namespace palpate
