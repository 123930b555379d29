// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// One tick of the engine: the position of a tip or of a ball's centre in, a force out. No heap, no
// lock, no exception, no clock.

#include "contact.hpp"
#include "status.hpp"

namespace palpate {
namespace runtime {

inline void put(const Vec3d& from, double to[3]) noexcept {
  to[0] = from.x;
  to[1] = from.y;
  to[2] = from.z;
}

/// The surface point under a ball's rest position, or a tip's contact point itself.
template <bool kIsBall, class Spot>
Vec3d surface_point(const Spot& spot, const Arm& arm) noexcept {
  if (!kIsBall) return spot.point;
  const Vec3d skew = make_vec3<double>(arm.skew_m);
  return spot.point + skew + spot.normal * (arm.reach_m - dot(skew, spot.normal));
}

/// After a slip the skew lies across the new normal; the rest position stays what it is.
inline void lay_skew(Arm& arm, const Vec3d& normal) noexcept {
  const Vec3d skew = make_vec3<double>(arm.skew_m);
  put(skew - normal * dot(skew, normal), arm.skew_m);
}

template <class F, bool kIsBall, class Foot>
void describe(const AssetView& asset, const Contact& contact, const Foot& foot, const Vec3d& x,
              Output& out) noexcept {
  const Vec3d origin = make_vec3<double>(asset.origin_m);
  const Vec3d c = surface_point<kIsBall>(foot.spot, contact.arm);
  put(c + origin, out.contact_m);
  put(kIsBall ? x + foot.spot.normal * contact.arm.reach_m + origin : x + origin, out.acts_at_m);
  put(foot.spot.normal, out.normal);
  out.triangle = contact.triangle;
  for (int k = 0; k < 3; ++k) out.weight[k] = contact.weight[k];
  out.normal_m = foot.d.normal_m;
  out.lateral_m = foot.d.lateral_m;
  if (foot.d.normal_m > double(asset.max_depth_m[contact.triangle])) out.flags |= kFlagTooDeep;
  if (F::is_frictionless(asset.curves, foot.spot)) out.flags |= kFlagFrictionless;
}

/// The answer of a tool that the contact holds: force, energy, what there is to say about them.
template <class F, bool kIsBall, class Foot>
Status resist(const AssetView& asset, Contact& contact, const Foot& foot,
              const typename F::template Memory<double>& memory, double stored_J, const Vec3d& x,
              Output& out) noexcept {
  const Vec3d force = F::force(asset.curves, foot, memory);
  if (!is_finite(force) || !std::isfinite(stored_J)) {
    forget(contact);
    return Status::force_not_finite;
  }
  describe<F, kIsBall>(asset, contact, foot, x, out);
  put(Vec3d{-force.x, -force.y, -force.z}, out.force_on_tool_N);
  out.state = ContactState::stick;
  out.stored_J = stored_J;
  F::save(memory, contact.memory);
  return Status::ok;
}

/// Whether the contact stands where it stood and sticks: then `status` is the answer's. Anything
/// else (a slip, a lift, a law that moves a sticking contact) is answer()'s to find anew.
template <class F, bool kIsBall>
bool stays(const AssetView& asset, Contact& contact, const Vec3d& x, Output& out,
           Status& status) noexcept {
  Hold& hold = contact.hold;
  if (!is_good(hold, asset, contact.triangle, contact.weight, kIsBall)) return false;
  const auto foot = F::footing(asset.curves, HeldSpot{hold.point, hold.normal, &hold, &asset}, x);
  if (!(foot.d.normal_m > 0) || F::is_slipping(asset.curves, foot)) return false;
  contact.withheld_J = 0;
  auto memory = F::template load<double>(contact.memory);
  contact.dissipated_J += F::settle(asset.curves, foot, memory);
  const double stored_J = F::energy_J(asset.curves, foot, memory);
  status = resist<F, kIsBall>(asset, contact, foot, memory, stored_J, x, out);
  return true;
}

/// Slides, then releases or answers with a force: the order matters (no pop at lift-off).
template <class F, bool kIsBall>
Status answer(const AssetView& asset, Contact& contact, const Vec3d& x, Output& out) noexcept {
  Status status = Status::ok;
  if (stays<F, kIsBall>(asset, contact, x, out, status)) return status;
  MeshSurface<double, kIsBall> surface(asset, contact.triangle, contact.weight, contact.arm);
  const bool is_held = is_good(contact.hold, asset, contact.triangle, contact.weight, kIsBall);
  auto foot = footing_of<F>(asset, contact.hold, is_held, surface.standing(), x);
  auto memory = F::template load<double>(contact.memory);
  const SlideEnd end = F::slide(asset.curves, x, surface, foot, memory);
  account(contact, surface);
  contact.triangle = surface.triangle();
  for (int k = 0; k < 3; ++k) contact.weight[k] = surface.weight(k);
  const bool is_lifted = !(foot.d.normal_m > 0) && end != SlideEnd::unfinished;
  if (is_lifted || is_powerless(asset, contact)) {
    release(contact);
    return Status::ok;
  }
  const double stored_J =
      surface.has_moved() ? surface.stored_J() : F::energy_J(asset.curves, foot, memory);
  status = resist<F, kIsBall>(asset, contact, foot, memory, stored_J, x, out);
  if (status != Status::ok) return status;
  out.flags |= surface.flags();
  // A slip moves a ball's arm; a family without a bed finds nothing in a hold that has just
  // slipped.
  if (end == SlideEnd::stick || (!kIsBall && std::is_same_v<F, Rings>))
    keep<F>(contact.hold, asset, contact.triangle, contact.weight, kIsBall, foot);
  else
    drop(contact.hold);
  if (end == SlideEnd::stick) return Status::ok;
  out.state = ContactState::slip;
  if (end == SlideEnd::unfinished) out.flags |= kFlagUnfinished;
  if (kIsBall) lay_skew(contact.arm, foot.spot.normal);
  return Status::ok;
}

/// Where tangents go, row-major 3 x 3 [N/m]; null: none is computed.
using TangentOut = double*;

/// Derivative of the force ON THE BODY with respect to the place of the tip or centre, of the
/// branches that answer() takes from this contact: the slip's way, its ends, its roots. At the tick
/// of first touch the contact point found counts as fixed, and of a slip that the guard held back
/// the share it let pass.
template <class F, bool kIsBall>
void tangent(const AssetView& asset, const Contact& contact, const Vec3d& x,
             TangentOut tangent_N_m) noexcept {
  const Vec3<Jet3> tip{Jet3(x.x, 1, 0, 0), Jet3(x.y, 0, 1, 0), Jet3(x.z, 0, 0, 1)};
  MeshSurface<Jet3, kIsBall> surface(asset, contact.triangle, contact.weight, contact.arm);
  auto foot = F::footing(asset.curves, surface.standing(), tip);
  auto memory = F::template load<Jet3>(contact.memory);
  F::slide(asset.curves, tip, surface, foot, memory);
  const Vec3<Jet3> force = F::force(asset.curves, foot, memory);
  for (int k = 0; k < 3; ++k) {
    tangent_N_m[k] = force.x.v[k];
    tangent_N_m[3 + k] = force.y.v[k];
    tangent_N_m[6 + k] = force.z.v[k];
  }
}

/// What touch() and touch_ball() share: the guard of inputs, first touch, answer.
template <bool kIsBall>
Status tick(const AssetView& asset, Contact& contact, const double tip_m[3], double radius_m,
            Output& out, TangentOut tangent_N_m) noexcept {
  out = Output();
  out.dissipated_J = contact.dissipated_J;
  out.refused_J = contact.refused_J;
  out.refused_ticks = contact.refused_ticks;
  if (tangent_N_m != nullptr)
    for (int k = 0; k < 9; ++k) tangent_N_m[k] = 0;
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
  put(x, contact.tip_m);
  const Vec3d step = x - before;
  if (!(dot(step, step) <= asset.max_step_m * asset.max_step_m)) {
    release(contact);
    return Status::tip_teleported;
  }
  if (contact.triangle < 0) {
    if constexpr (kIsBall)
      seek_contact(asset, contact, before, x, radius_m);
    else
      seek_contact(asset, contact, before, x);
  }
  if (contact.triangle < 0) return Status::ok;
  const Status status = with_family(asset.curves, [&](auto f) noexcept {
    using F = decltype(f);
    if (tangent_N_m != nullptr) tangent<F, kIsBall>(asset, contact, x, tangent_N_m);
    return answer<F, kIsBall>(asset, contact, x, out);
  });
  out.dissipated_J = contact.dissipated_J;
  out.refused_J = contact.refused_J;
  out.refused_ticks = contact.refused_ticks;
  if (tangent_N_m != nullptr && out.state == ContactState::air)
    for (int k = 0; k < 9; ++k) tangent_N_m[k] = 0;
  return status;
}

/// The force on a tool whose tip (reference point) is at tip_m [m], in body coordinates.
/// Call once per tick, at any rate, with the Contact of that tool. The first tick only learns where
/// the tip is; a tip that starts inside the body feels nothing until it has come out and entered
/// again through a covered triangle; so does one that slid off over the rim of the covered surface,
/// where forces have faded to zero. Touch is swept from the previous tip, so nothing tunnels.
/// Refuses (status, zero force, contact reset): a tip that is not finite or moved farther than
/// asset.max_step_m in one tick; a contact of another asset; a force that is not finite.
/// Work: in the air the tree nodes along the way; in contact at most kMaxSegments segments of
/// kMaxRootSteps + 4 curve evaluations and kMaxGuardSteps + 2 energies. What does not fit into a
/// tick goes on at the next. Deterministic: the same bytes and tips give the same bits.
/// tangent_N_m: optional, row-major 3 x 3, d(force on the body)/d(tip): the exact derivative of the
/// branches this tick took; zero without force. Asking for it makes a tick several times as
/// long and changes no other bit.
inline Status touch(const AssetView& asset, Contact& contact, const double tip_m[3], Output& out,
                    TangentOut tangent_N_m = nullptr) noexcept {
  return tick<false>(asset, contact, tip_m, 0, out, tangent_N_m);
}

/// The force on a ball of radius_m [m] whose centre is at centre_m [m], in body coordinates: as
/// touch(), but contact begins where the ball touches first (docs/method.md, section 12), and the
/// reference point is x = p + R u(c). A ball that begins a tick deeper in the surface than
/// kRestShare of its radius feels nothing until it has come out; one that is less deep, as after
/// lifting off, begins contact there. radius 0 is a tip. Refuses a radius that is negative or not
/// finite. Work in the air: the tree nodes within the radius of the way.
inline Status touch_ball(const AssetView& asset, Contact& contact, const double centre_m[3],
                         double radius_m, Output& out, TangentOut tangent_N_m = nullptr) noexcept {
  if (radius_m == 0) return touch(asset, contact, centre_m, out, tangent_N_m);
  if (!(radius_m > 0 && radius_m <= 1e3)) {
    out = Output();
    if (tangent_N_m != nullptr)
      for (int k = 0; k < 9; ++k) tangent_N_m[k] = 0;
    forget(contact);
    return Status::radius_wrong;
  }
  return tick<true>(asset, contact, centre_m, radius_m, out, tangent_N_m);
}

}  // namespace runtime
}  // namespace palpate
