// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// One tick of the engine: the position of a tip or of a ball's centre in, a force out. No heap, no
// lock, no exception, no clock.

#include "body/puncture.hpp"

namespace palpate {
namespace runtime {

/// The tangent of what the contact bears of the law's force (M20, M56); the debt counts as fixed,
/// and so does damage.
inline void bear(const Contact& contact, const Output& out, TangentOut tangent_N_m) noexcept {
  const Ledger& ledger = contact.ledger;
  if (contact.damage_share != 1) {
    // The force is the debt's share of eta f; what it bends by is eta' f f.
    double owed = 1;
    if (ledger.debt_J > 0) {
      const double half = 0.5 * out.stored_J;
      owed = ledger.share(half + std::sqrt(half * half + ledger.debt_J * out.stored_J));
    }
    const double whole = owed * contact.damage_share;
    const double bent = whole > 0 ? contact.damage_slope / (whole * whole) : 0;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        tangent_N_m[3 * i + j] = contact.damage_share * tangent_N_m[3 * i + j] +
                                 bent * (out.force_on_tool_N[i] * out.force_on_tool_N[j]);
  }
  if (!(ledger.debt_J > 0)) return;
  // U = E^2 / (E + b) has the root E = U/2 + sqrt(U^2/4 + b U).
  const double half = 0.5 * out.stored_J;
  const double law_J = half + std::sqrt(half * half + ledger.debt_J * out.stored_J);
  const double share = ledger.share(law_J);
  const double bent = share > 0 ? ledger.share_slope(law_J) / (share * share) : 0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      tangent_N_m[3 * i + j] =
          share * tangent_N_m[3 * i + j] + bent * (out.force_on_tool_N[i] * out.force_on_tool_N[j]);
}

inline void tell_sums(const Contact& contact, Output& out) noexcept {
  out.dissipated_J = contact.ledger.dissipated_J;
  out.refused_J = contact.ledger.refused_J;
  out.refused_ticks = contact.ledger.refused_ticks;
}

/// The guard of inputs, and first touch, of a tool at x from the asset's origin. step: since the
/// tick before.
inline Status approach(const AssetView& asset, Contact& contact, const Vec3d& x, double radius_m,
                       double dt_s, Vec3d& step) noexcept {
  if (!is_finite(x)) {
    forget(contact);
    return Status::tip_not_finite;
  }
  const RelaxationView& relaxation = asset.curves.relaxation;
  if (relaxation.branches > 0) {
    if (!(dt_s >= kMinTimeStep_s && dt_s <= kMaxTimeStep_s)) {
      forget(contact);
      return Status::time_step_wrong;
    }
    if (contact.half_tick_s != 0.5 * dt_s) {
      contact.half_tick_s = 0.5 * dt_s;
      contact.left = decay_over(relaxation, contact.half_tick_s);
    }
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
    release(contact);
    contact.has_lifted = false;
    return Status::tip_teleported;
  }
  contact.is_rested = contact.triangle < 0;
  if (contact.triangle < 0) {
    if (radius_m > 0)
      seek_contact(asset, contact, before, x, radius_m);
    else
      seek_contact(asset, contact, before, x);
  }
  return Status::ok;
}

/// approach() and answer. Fills the output in contact; in the air its state alone.
template <bool kIsBall>
Status tick_from(const AssetView& asset, Contact& contact, const double tip_m[3], double radius_m,
                 Output& out, TangentOut tangent_N_m, double dt_s) noexcept {
  out.state = ContactState::air;
  out.flags = 0;
  const Vec3d x{tip_m[0] - asset.origin_m[0], tip_m[1] - asset.origin_m[1],
                tip_m[2] - asset.origin_m[2]};
  Vec3d step{0, 0, 0};
  const Status status = approach(asset, contact, x, radius_m, dt_s, step);
  if (status != Status::ok || contact.triangle < 0) return status;
  const Vec3d place = x - make_vec3<double>(contact.arm.pole_m);
  return with_family(asset.curves, [&](auto f) noexcept {
    using F = decltype(f);
    if constexpr (F::kSwayPart >= 0) {
      const Compliance give = compliance_at(asset, contact.triangle, contact.weight);
      if (give.is_any())
        return answer_swaying<F, kIsBall>(asset, contact, give, place, step, out, tangent_N_m);
    }
    if (tangent_N_m != nullptr) {
      rest<F, kIsBall>(asset, contact, Compliance(), place - step);
      tangent<F, kIsBall>(asset, contact, place, step, tangent_N_m);
    }
    return answer<F, kIsBall>(asset, contact, place, step, asset.has_guard,
                              asset.body != nullptr ? &asset : nullptr, out);
  });
}

/// The same of a body that tools puncture. Out of line: a tick of others stays as quick.
template <bool kIsBall>
PALPATE_OUT_OF_LINE Status pierce_from(const AssetView& asset, Contact& contact,
                                       const double tip_m[3], double radius_m, Output& out,
                                       TangentOut tangent_N_m, double dt_s) noexcept {
  const Vec3d x{tip_m[0] - asset.origin_m[0], tip_m[1] - asset.origin_m[1],
                tip_m[2] - asset.origin_m[2]};
  const Vec3d before = make_vec3<double>(contact.tip_m), step = x - before;
  const bool is_known = contact.has_tip && contact.asset_checksum == asset.checksum &&
                        dot(step, step) <= asset.max_step_m * asset.max_step_m;
  if (is_known && contact.hole.number != 0) {
    out.state = ContactState::air;
    out.flags = 0;
    put(x, contact.tip_m);
    tick_in_channel(asset, contact, radius_m, kIsBall && radius_m > 0, before, x, out, tangent_N_m);
    return Status::ok;
  }
  if (is_known && contact.triangle < 0)
    if (const std::int64_t number = channel_at(asset, false, radius_m, before, x)) {
      put(x, contact.tip_m);
      fall_in(asset, contact, number, radius_m, x, out, tangent_N_m);
      return Status::ok;
    }
  if (!is_known && contact.hole.number != 0) release(contact);
  const Status status = tick_from<kIsBall>(asset, contact, tip_m, radius_m, out, tangent_N_m, dt_s);
  if (asset.channels != nullptr && out.state != ContactState::air)
    break_in(asset, contact, radius_m, before, x, out, tangent_N_m);
  return status;
}

/// What touch() and touch_ball() share.
template <bool kIsBall>
Status tick(const AssetView& asset, Contact& contact, const double tip_m[3], double radius_m,
            Output& out, TangentOut tangent_N_m, double dt_s) noexcept {
  const Ledger before = contact.ledger;
  contact.is_inside = false;
  const bool can_pierce = asset.channels != nullptr || contact.hole.number != 0;
  const Status status =
      can_pierce ? pierce_from<kIsBall>(asset, contact, tip_m, radius_m, out, tangent_N_m, dt_s)
                 : tick_from<kIsBall>(asset, contact, tip_m, radius_m, out, tangent_N_m, dt_s);
  const bool is_air = out.state == ContactState::air;
  if (is_air) {
    out = Output();
    if (contact.is_inside) {
      out.flags = kFlagInside;
      contact.ledger = before;  // nothing answered
    }
  }
  tell_sums(contact, out);
  if (tangent_N_m == nullptr) return status;
  if (is_air)
    for (int k = 0; k < 9; ++k) tangent_N_m[k] = 0;
  else if (contact.hole.number == 0)
    bear(contact, out, tangent_N_m);
  return status;
}

/// The force on a tool whose tip (reference point) is at tip_m [m], in body coordinates.
/// Call once per tick, at any rate, with the Contact of that tool. The first tick only learns where
/// the tip is. Where the curves were measured with a ball, the tip is that ball's lowest point, and
/// the ball does not turn (M15a). A tip that starts inside the body feels nothing (kFlagInside)
/// until it has come out and entered again through a triangle that answers; so does one that slid
/// off over the rim of a surface that fades to zero. One that lifts off goes on as touch_ball()
/// does. Touch is swept from the previous tip, so nothing tunnels. Refuses (status, zero force,
/// contact reset): a tip that is not finite or moved farther than asset.max_step_m in one tick; a
/// contact of another asset; a force that is not finite. Work: in the air the tree nodes along the
/// way; in contact at most kMaxSegments segments of kMaxRootSteps + 3 evaluations of the law's
/// slip, and two of its energy. What does not fit into a tick goes on at the next. Deterministic:
/// the same bytes and tips give the same bits. tangent_N_m: optional, row-major 3 x 3, d(force on
/// the body)/d(tip): the exact derivative of the branches this tick took; zero without force.
/// Asking for it makes a tick several times as long and changes no other bit. dt_s [s],
/// kMinTimeStep_s to kMaxTimeStep_s: since the tick before; read where the body relaxes (section
/// 24), and refused there where it is not in range.
inline Status touch(const AssetView& asset, Contact& contact, const double tip_m[3], Output& out,
                    TangentOut tangent_N_m = nullptr, double dt_s = 0) noexcept {
  return asset.probe_radius_m > 0 ? tick<true>(asset, contact, tip_m, 0, out, tangent_N_m, dt_s)
                                  : tick<false>(asset, contact, tip_m, 0, out, tangent_N_m, dt_s);
}

/// The force on a ball of radius_m [m] whose centre is at centre_m [m], in body coordinates: as
/// touch(), but contact begins where the ball touches first (docs/method.md, section 12), and the
/// reference point is x = p + R u(c). A ball that begins a tick deeper in the surface than
/// kRestShare of its radius feels nothing until it has come out, or, where it had lifted off, sinks
/// again; one that is less deep begins contact there. radius 0 is a tip. Refuses a radius that
/// is negative or not finite. Work in the air: the tree nodes within the radius of the way.
inline Status touch_ball(const AssetView& asset, Contact& contact, const double centre_m[3],
                         double radius_m, Output& out, TangentOut tangent_N_m = nullptr,
                         double dt_s = 0) noexcept {
  if (radius_m == 0) return touch(asset, contact, centre_m, out, tangent_N_m, dt_s);
  if (!(radius_m > 0 && radius_m <= 1e3)) {
    out = Output();
    if (tangent_N_m != nullptr)
      for (int k = 0; k < 9; ++k) tangent_N_m[k] = 0;
    forget(contact);
    return Status::radius_wrong;
  }
  return tick<true>(asset, contact, centre_m, radius_m, out, tangent_N_m, dt_s);
}

}  // namespace runtime
}  // namespace palpate
