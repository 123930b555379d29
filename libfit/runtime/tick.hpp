// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// One tick of the engine: the position of a tip or of a ball's centre in, a force out. No heap, no
// lock, no exception, no clock.

#include "contact.hpp"
#include "status.hpp"

namespace palpate {
namespace runtime {

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

template <bool kIsBall, class Kinematics>
void describe(const AssetView& asset, const Contact& contact, const Kinematics& kinematics,
              const Vec3d& x, Output& out) noexcept {
  const Vec3d origin = make_vec3<double>(asset.origin_m);
  const Vec3d c = surface_point<kIsBall>(kinematics.spot, contact.arm);
  put(c + origin, out.contact_m);
  put(kIsBall ? x + kinematics.spot.normal * contact.arm.reach_m + origin : x + origin,
      out.acts_at_m);
  put(kinematics.spot.normal, out.normal);
  out.triangle = contact.triangle;
  for (int k = 0; k < 3; ++k) out.weight[k] = contact.weight[k];
  out.normal_m = kinematics.d.normal_m;
  out.lateral_m = kinematics.d.lateral_m;
  if (kinematics.d.normal_m > double(asset.max_depth_m[contact.triangle]))
    out.flags |= kFlagTooDeep;
  if (contact.cache.is_frictionless) out.flags |= kFlagFrictionless;
  if (contact.ledger.debt_J > 0) out.flags |= kFlagHeldBack;
  if (kinematics.d.normal_m > asset.max_fitted_m) out.flags |= kFlagExtrapolated;
  for (int k = 0; k < 3; ++k)
    if (asset.covered[asset.corner(contact.triangle, k)] != kMeasured) out.flags |= kFlagOutside;
}

/// The standing spot of a contact, cached.
template <class F, bool kIsBall>
CachedSpot cached_spot(const AssetView& asset, Contact& contact) noexcept {
  SpotCache& cache = contact.cache;
  if (!is_good(cache, asset, contact.triangle, contact.weight, kIsBall)) {
    const MeshSurface<double, kIsBall> surface(cache.corners, asset, contact.triangle,
                                               contact.weight, contact.arm);
    fill<F>(cache, asset, contact.triangle, contact.weight, kIsBall, surface.standing());
  }
  return {cache.point, cache.normal, &cache, &asset};
}

/// How far the contact point may go in a tick in which the tool moves by `step`.
template <class T>
T slip_budget_m(const Contact& contact, const Vec3<T>& step) noexcept {
  using std::sqrt;
  const T squared = dot(step, step);
  const T moved = value_of(squared) > 0 ? sqrt(squared) : T(0);
  return kSlipPerStep * moved + (kFreeSlip_m + contact.slip_left_m);
}

/// Lets the contact point slide.
template <class F, bool kIsBall, class Kinematics, class Memory>
SlideEnd follow(const AssetView& asset, Contact& contact, const Vec3d& x, const Vec3d& step,
                const Kinematics& kinematics, Memory& memory, Output& out) noexcept {
  MeshSurface<double, kIsBall> surface(contact.cache.corners, asset, contact.triangle,
                                       contact.weight, contact.arm, slip_budget_m(contact, step));
  auto mesh_kinematics = F::at_spot(kinematics, kinematics.spot.mesh_spot());
  const SlideEnd end = slide<F>(asset.curves, x, surface, mesh_kinematics, memory);
  contact.slip_left_m = end == SlideEnd::unfinished && !surface.is_spent() ? surface.budget_m() : 0;
  contact.triangle = surface.triangle();
  for (int k = 0; k < 3; ++k) contact.weight[k] = surface.weight(k);
  if (end != SlideEnd::stick) {
    F::carry(asset.curves, memory, mesh_kinematics.spot.point - kinematics.spot.point,
             mesh_kinematics.spot.normal);
    if constexpr (kIsBall) {  // its rest position is the same but for rounding
      lay_skew(contact.arm, mesh_kinematics.spot.normal);
      mesh_kinematics.spot = surface.standing();
    }
    fill<F>(contact.cache, asset, contact.triangle, contact.weight, kIsBall, mesh_kinematics.spot);
  }
  out.flags |= surface.flags();
  if (end == SlideEnd::unfinished) out.flags |= kFlagUnfinished;
  if (end == SlideEnd::stopped) out.flags |= kFlagBlocked;
  if (end != SlideEnd::stick) out.state = ContactState::slip;
  return end;
}

/// Slides, then releases or answers with a force: the order matters (no pop at lift-off).
/// kinematics: at x; slipping: at `seen`, where a slide sees the tool. before_J: what the law
/// stored before the dashpots of a body that relaxes flowed.
template <class F, bool kIsBall, class Memory, class Kinematics>
Status answer_from(const AssetView& asset, Contact& contact, const Vec3d& x, const Vec3d& seen,
                   const Vec3d& step, bool has_guard, Memory& memory, Kinematics& kinematics,
                   const Kinematics& slipping, double before_J, Output& out) noexcept {
  const CurveViews& views = asset.curves;
  out.state = ContactState::stick;
  const bool moves =
      !(kinematics.d.normal_m > 0) || F::is_out(memory) || F::is_slipping(views, slipping);
  if (moves) {
    if (!F::relaxes(views))
      before_J = F::stored_J(views, F::under(views, kinematics), kinematics, memory);
    const SlideEnd end = follow<F, kIsBall>(asset, contact, seen, step, slipping, memory, out);
    kinematics = F::kinematics(views, cached_spot<F, kIsBall>(asset, contact), x, memory);
    const bool is_lifted = !(kinematics.d.normal_m > 0) && end != SlideEnd::unfinished;
    if (is_lifted || is_powerless(asset, contact)) {
      const Vec3d pole = make_vec3<double>(contact.arm.pole_m);
      const bool is_tip = dot(pole, pole) > 0;
      release(contact, before_J);
      contact.has_lifted = kIsBall && is_lifted && !is_tip;
      out.state = ContactState::air;
      return Status::ok;
    }
  }
  const auto& under = F::under(views, kinematics);
  const auto slipped = F::slip(views, under, kinematics, memory);
  const Answer<double> law = F::answer(views, under, kinematics, slipped);
  if (!is_finite(law.force_N) || !is_finite(law.stored_J)) {
    forget(contact);
    out.state = ContactState::air;
    return Status::force_not_finite;
  }
  if (moves || F::relaxes(views))
    contact.ledger.book(before_J, law.stored_J, has_guard);
  else if (slipped.lost_J > 0)
    contact.ledger.book(law.stored_J + slipped.lost_J, law.stored_J, has_guard);
  F::save(memory, contact.memory, views.relaxation);
  contact.law_J = law.stored_J;
  put(law.force_N, contact.sway.force_N);
  describe<kIsBall>(asset, contact, kinematics, x, out);
  put(law.force_N * -contact.ledger.share(law.stored_J), out.force_on_tool_N);
  out.stored_J = contact.ledger.stored_J(law.stored_J);
  return Status::ok;
}

/// Half of a tick's time passes before the tool leaves x, where it was at the tick before (M47), if
/// it has not passed yet; for the dashpots of the sway all of it. give: the sway's compliance.
template <class F, bool kIsBall, class Memory>
void rest(const AssetView& asset, Contact& contact, const Compliance& give, const Vec3d& x,
          Memory& memory) noexcept {
  const CurveViews& views = asset.curves;
  if (contact.is_rested) return;
  contact.is_rested = true;
  const auto kinematics = F::kinematics(views, cached_spot<F, kIsBall>(asset, contact), x, memory);
  if (!(kinematics.d.normal_m > 0)) return;
  const double sway_J = sway_energy(views.relaxation, contact.sway, give, contact.sway.force());
  F::relax(views, kinematics, contact.left, memory);
  double after_J = F::stored_J(views, F::under(views, kinematics), kinematics, memory);
  if (give.is_any()) {  // what flows at a sway that stays lowers what is stored
    const Vec3d stays = slow_force(views.relaxation, contact.sway, contact.sway.force());
    let_creep(views.relaxation, contact.left, contact.sway);
    const Vec3d held = (stays - rest_force(views.relaxation, contact.sway)) * views.relaxation.fast;
    after_J += sway_energy(views.relaxation, contact.sway, give, held);
  }
  contact.ledger.book(contact.law_J + sway_J, after_J, asset.has_guard);
}
/// The same by itself.
template <class F, bool kIsBall>
void rest(const AssetView& asset, Contact& contact, const Compliance& give,
          const Vec3d& place) noexcept {
  if constexpr (F::kCanRelax) {
    const RelaxationView& relaxation = asset.curves.relaxation;
    if (relaxation.branches == 0) return;
    auto memory = F::template load<double>(contact.memory, relaxation);
    rest<F, kIsBall>(asset, contact, give, place, memory);
    F::save(memory, contact.memory, relaxation);
  }
}

/// answer_from() what the contact remembers. Where the body relaxes, half of the tick's time passes
/// with the tool where it was, the other half with the tool at x (M47).
template <class F, bool kIsBall>
Status answer(const AssetView& asset, Contact& contact, const Vec3d& x, const Vec3d& step,
              bool has_guard, Output& out) noexcept {
  const CurveViews& views = asset.curves;
  auto memory = F::template load<double>(contact.memory, views.relaxation);
  if constexpr (F::kCanRelax)
    if (F::relaxes(views)) {
      rest<F, kIsBall>(asset, contact, Compliance(), x - step, memory);
      auto kinematics = F::kinematics(views, cached_spot<F, kIsBall>(asset, contact), x, memory);
      const double before_J = F::stored_J(views, F::under(views, kinematics), kinematics, memory);
      F::relax(views, kinematics, contact.left, memory);
      const Vec3d seen = F::seen(views, kinematics, x, memory);
      const auto slipping = F::kinematics(views, kinematics.spot, seen, memory);
      return answer_from<F, kIsBall>(asset, contact, x, seen, step, has_guard, memory, kinematics,
                                     slipping, before_J, out);
    }
  auto kinematics = F::kinematics(views, cached_spot<F, kIsBall>(asset, contact), x, memory);
  return answer_from<F, kIsBall>(asset, contact, x, x, step, has_guard, memory, kinematics,
                                 kinematics, 0, out);
}

/// Where tangents go, row-major 3 x 3 [N/m]; null: none is computed.
using TangentOut = double*;

/// Derivative of the law's force ON THE BODY with respect to the place of the tip or centre, of the
/// branches that answer() takes from this contact: the slip's way, its ends, its roots. At the tick
/// of first touch the contact point found counts as fixed.
template <class F, bool kIsBall>
void tangent(const AssetView& asset, const Contact& contact, const Vec3d& x, const Vec3d& step,
             TangentOut tangent_N_m) noexcept {
  const CurveViews& views = asset.curves;
  const Vec3<Jet3> tip{Jet3(x.x, 1, 0, 0), Jet3(x.y, 0, 1, 0), Jet3(x.z, 0, 0, 1)};
  const Vec3<Jet3> moved = tip - widened<Jet3>(x - step);
  Corners corners;
  MeshSurface<Jet3, kIsBall> surface(corners, asset, contact.triangle, contact.weight, contact.arm,
                                     slip_budget_m(contact, moved));
  auto memory = F::template load<Jet3>(contact.memory, views.relaxation);
  auto kinematics = F::kinematics(views, surface.standing(), tip, memory);
  const Vec3<Jet3> from = kinematics.spot.point;
  Vec3<Jet3> seen = tip;
  if constexpr (F::kCanRelax)
    if (F::relaxes(views)) {
      F::relax(views, kinematics, contact.left, memory);
      seen = F::seen(views, kinematics, tip, memory);
      kinematics = F::kinematics(views, surface.standing(), seen, memory);
    }
  slide<F>(views, seen, surface, kinematics, memory);
  F::carry(views, memory, kinematics.spot.point - from, kinematics.spot.normal);
  kinematics = F::kinematics(views, surface.standing(), tip, memory);
  const auto& under = F::under(views, kinematics);
  const Vec3<Jet3> force =
      F::answer(views, under, kinematics, F::slip(views, under, kinematics, memory)).force_N;
  for (int k = 0; k < 3; ++k) {
    tangent_N_m[k] = force.x.v[k];
    tangent_N_m[3 + k] = force.y.v[k];
    tangent_N_m[6 + k] = force.z.v[k];
  }
}

/// The law at x with nothing slipping.
template <class F, bool kIsBall>
Answer<double> hold(const AssetView& asset, Contact& contact, const Vec3d& x) noexcept {
  const CurveViews& views = asset.curves;
  const auto memory = F::template load<double>(contact.memory, views.relaxation);
  const auto kinematics = F::kinematics(views, cached_spot<F, kIsBall>(asset, contact), x, memory);
  const auto& under = F::under(views, kinematics);
  return F::answer(views, under, kinematics, F::stick(views, under, kinematics, memory));
}

/// answer() of a body that gives as a whole (M34). What a contact stores is the least of law and
/// sway together. It is found twice: with nothing slipping, then with the slips, on copies of the
/// contact. A contact point that has moved has another compliance, so the sway settles once more;
/// the ledger sees all of it.
template <class F, bool kIsBall>
Status answer_swaying(const AssetView& asset, Contact& contact, const Compliance& give,
                      const Vec3d& x, const Vec3d& step, Output& out,
                      TangentOut tangent_N_m) noexcept {
  const RelaxationView& relaxation = asset.curves.relaxation;
  const Vec3d before =
      x - step - give.times(slow_force(relaxation, contact.sway, contact.sway.force()));
  rest<F, kIsBall>(asset, contact, give, before);
  Contact start = contact;
  Sway sway = start.sway;
  // Dashpots hold still from here on: the sway gives by 1 / fast of C about where they have flowed.
  const Vec3d flowed = rest_force(relaxation, sway);
  const auto local = [&](const Compliance& c, const Vec3d& f) noexcept {
    return x - c.times(flowed + f * (1 / relaxation.fast));
  };
  const Compliance fast = give.over(relaxation.fast);
  Answer<double> law;
  bool is_settled = settle(fast, sway, [&](const Vec3d& f) noexcept {
    law = hold<F, kIsBall>(asset, start, local(give, f));
    return law.force_N;
  });
  const double before_J = law.stored_J + sway_energy(relaxation, sway, give, sway.force());
  Status status = Status::ok;
  is_settled = settle(fast, sway,
                      [&](const Vec3d& f) noexcept {
                        contact = start;
                        contact.ledger = Ledger();  // the law's own answer: nothing is owed
                        out = Output();
                        const Vec3d y = local(give, f);
                        status = answer<F, kIsBall>(asset, contact, y, y - before, false, out);
                        return make_vec3<double>(out.force_on_tool_N) * -1.0;
                      }) &&
               is_settled;
  if (status != Status::ok) return status;
  const bool has_slipped = contact.ledger.dissipated_J != 0 || out.state == ContactState::slip ||
                           F::relaxes(asset.curves);
  contact.ledger = start.ledger;
  if (contact.triangle < 0) {
    contact.ledger.close(before_J);
    return status;
  }
  if (tangent_N_m != nullptr) {
    const Vec3d y = local(give, sway.force());
    double K[9];
    tangent<F, kIsBall>(asset, start, y, y - before, K);
    for (int k = 0; k < 3; ++k) {
      const Vec3d column = unload(K, fast, {K[k], K[3 + k], K[6 + k]});
      tangent_N_m[k] = column.x;
      tangent_N_m[3 + k] = column.y;
      tangent_N_m[6 + k] = column.z;
    }
  }
  Compliance here = give;
  law.stored_J = out.stored_J;
  law.force_N = make_vec3<double>(out.force_on_tool_N) * -1.0;
  if (out.state == ContactState::slip) {
    here = compliance_at(asset, contact.triangle, contact.weight);
    is_settled = settle(here.over(relaxation.fast), sway,
                        [&](const Vec3d& f) noexcept {
                          law = hold<F, kIsBall>(asset, contact, local(here, f));
                          return law.force_N;
                        }) &&
                 is_settled;
  }
  const Vec3d force = sway.force();
  const double after_J = law.stored_J + sway_energy(relaxation, sway, here, force);
  if (has_slipped) contact.ledger.book(before_J, after_J, asset.has_guard);
  contact.sway = sway;
  contact.law_J = law.stored_J;
  if (!is_settled) out.flags |= kFlagUnfinished;
  if (contact.ledger.debt_J > 0) out.flags |= kFlagHeldBack;
  put(make_vec3<double>(out.acts_at_m) + here.times(slow_force(relaxation, sway, force)),
      out.acts_at_m);
  put(law.force_N * -contact.ledger.share(after_J), out.force_on_tool_N);
  out.stored_J = contact.ledger.stored_J(after_J);
  return Status::ok;
}

/// The tangent of what the contact bears of the law's force (M20); the debt counts as fixed.
inline void bear(const Contact& contact, const Output& out, TangentOut tangent_N_m) noexcept {
  const Ledger& ledger = contact.ledger;
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

/// The guard of inputs, first touch, answer. Fills the output in contact; in the air its state
/// alone.
template <bool kIsBall>
Status tick_from(const AssetView& asset, Contact& contact, const double tip_m[3], double radius_m,
                 Output& out, TangentOut tangent_N_m, double dt_s) noexcept {
  out.state = ContactState::air;
  out.flags = 0;
  const Vec3d x{tip_m[0] - asset.origin_m[0], tip_m[1] - asset.origin_m[1],
                tip_m[2] - asset.origin_m[2]};
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
  const Vec3d step = x - before;
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
  if (contact.triangle < 0) return Status::ok;
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
    return answer<F, kIsBall>(asset, contact, place, step, asset.has_guard, out);
  });
}

/// What touch() and touch_ball() share.
template <bool kIsBall>
Status tick(const AssetView& asset, Contact& contact, const double tip_m[3], double radius_m,
            Output& out, TangentOut tangent_N_m, double dt_s) noexcept {
  const Status status = tick_from<kIsBall>(asset, contact, tip_m, radius_m, out, tangent_N_m, dt_s);
  const bool is_air = out.state == ContactState::air;
  if (is_air) out = Output();
  tell_sums(contact, out);
  if (tangent_N_m == nullptr) return status;
  if (is_air)
    for (int k = 0; k < 9; ++k) tangent_N_m[k] = 0;
  else
    bear(contact, out, tangent_N_m);
  return status;
}

/// The force on a tool whose tip (reference point) is at tip_m [m], in body coordinates.
/// Call once per tick, at any rate, with the Contact of that tool. The first tick only learns where
/// the tip is. Where the curves were measured with a ball, the tip is that ball's lowest point, and
/// the ball does not turn (M15a). A tip that starts inside the body feels nothing until it has come
/// out and entered again through a triangle that answers; so does one that slid off over the rim of
/// a surface that fades to zero. Touch is swept from the previous tip, so nothing tunnels. Refuses
/// (status, zero force, contact reset): a tip that is not finite or moved farther than
/// asset.max_step_m in one tick; a contact of another asset; a force that is not finite.
/// Work: in the air the tree nodes along the way; in contact at most kMaxSegments segments of
/// kMaxRootSteps + 3 evaluations of the law's slip, and two of its energy. What does not fit into a
/// tick goes on at the next. Deterministic: the same bytes and tips give the same bits.
/// tangent_N_m: optional, row-major 3 x 3, d(force on the body)/d(tip): the exact derivative of the
/// branches this tick took; zero without force. Asking for it makes a tick several times as
/// long and changes no other bit.
/// dt_s [s], kMinTimeStep_s to kMaxTimeStep_s: since the tick before; read where the body relaxes
/// (section 24), and refused there where it is not in range.
inline Status touch(const AssetView& asset, Contact& contact, const double tip_m[3], Output& out,
                    TangentOut tangent_N_m = nullptr, double dt_s = 0) noexcept {
  return asset.probe_radius_m > 0 ? tick<true>(asset, contact, tip_m, 0, out, tangent_N_m, dt_s)
                                  : tick<false>(asset, contact, tip_m, 0, out, tangent_N_m, dt_s);
}

/// The force on a ball of radius_m [m] whose centre is at centre_m [m], in body coordinates: as
/// touch(), but contact begins where the ball touches first (docs/method.md, section 12), and the
/// reference point is x = p + R u(c). A ball that begins a tick deeper in the surface than
/// kRestShare of its radius feels nothing until it has come out (kReentryShare of one that lifted
/// off there); one that is less deep begins contact there. radius 0 is a tip. Refuses a radius that
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
