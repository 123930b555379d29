// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// What a contact answers to a tool at x: it slides, its rings slip, time passes for a body that
// relaxes, the ledger books what that did; in series with the sway of a body that gives as a whole.
// tick.hpp brings the tool here.

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

/// Lets a ball hover that has let go over a place [area coordinates n of a triangle], its centre at
/// x: its contact goes on from there with nothing deflected. The normal there may pass the centre
/// by: the anchors are then under it, and draw the contact point there at the next ticks.
template <class F, bool kIsBall>
void hover(const AssetView& asset, Contact& contact, const Vec3d& x, int triangle,
           const double n[3], const Arm& arm) noexcept {
  const CurveViews& views = asset.curves;
  contact.has_lifted = true;
  contact.hover = triangle;
  for (int k = 0; k < 3; ++k) contact.weight[k] = n[k];
  contact.arm.reach_m = arm.reach_m;
  put(make_vec3<double>(arm.pole_m), contact.arm.pole_m);
  auto memory = F::template load<double>(contact.memory, views.relaxation);
  const auto standing = [&]() noexcept {
    return MeshSurface<double, kIsBall>(contact.cache.corners, asset, triangle, n, contact.arm)
        .standing();
  };
  contact.arm.reach_m -= F::kinematics(views, standing(), x, memory).d.normal_m;
  auto kinematics = F::kinematics(views, standing(), x, memory);
  F::let_go(views, kinematics, memory);
  F::slip(views, F::under(views, kinematics), kinematics, memory);
  F::save(memory, contact.memory, views.relaxation);
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
    contact.untold_J = 0;
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

/// What the contact stores and bears once its place has borne law_J.
inline Softened bear_in(const AssetView* body, Contact& contact, double depth_m,
                        double law_J) noexcept {
  const Softened held =
      borne(body, contact.triangle, contact.weight, depth_m, law_J, contact.untold_J);
  contact.damage_share = held.share;
  contact.damage_slope = held.slope;
  return held;
}

/// Slides, then releases or answers with a force: the order matters (no pop at lift-off).
/// kinematics: at x; slipping: at `seen`, where a slide sees the tool. before_J: what the law
/// stored before the dashpots of a body that relaxes flowed. body: what the answer damages; null
/// where it is a part of another's.
template <class F, bool kIsBall, class Memory, class Kinematics>
Status answer_from(const AssetView& asset, Contact& contact, const Vec3d& x, const Vec3d& seen,
                   const Vec3d& step, bool has_guard, Memory& memory, Kinematics& kinematics,
                   const Kinematics& slipping, double before_J, const AssetView* body,
                   Output& out) noexcept {
  const CurveViews& views = asset.curves;
  if (F::relaxes(views)) before_J = stored_in(body, contact.triangle, contact.weight, before_J);
  out.state = ContactState::stick;
  const bool moves =
      !(kinematics.d.normal_m > 0) || F::is_out(memory) || F::is_slipping(views, slipping);
  if (moves) {
    if (!F::relaxes(views))
      before_J = stored_in(body, contact.triangle, contact.weight,
                           F::stored_J(views, F::under(views, kinematics), kinematics, memory));
    const SlideEnd end = follow<F, kIsBall>(asset, contact, seen, step, slipping, memory, out);
    kinematics = F::kinematics(views, cached_spot<F, kIsBall>(asset, contact), x, memory);
    const bool is_lifted = !(kinematics.d.normal_m > 0) && end != SlideEnd::unfinished;
    if (is_lifted || is_powerless(asset, contact)) {
      const Arm arm = contact.arm;
      const int triangle = contact.triangle;
      const double n[3] = {contact.weight[0], contact.weight[1], contact.weight[2]};
      release(contact, before_J);
      if (kIsBall && is_lifted) hover<F, kIsBall>(asset, contact, x, triangle, n, arm);
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
  const bool is_booked = moves || F::relaxes(views) || slipped.lost_J > 0 || body != nullptr;
  if (!moves && !F::relaxes(views))
    before_J = stored_in(body, contact.triangle, contact.weight, law.stored_J + slipped.lost_J);
  const Softened held = bear_in(body, contact, kinematics.d.normal_m, law.stored_J);
  if (is_booked) contact.ledger.book(before_J, held.stored_J, has_guard);
  F::save(memory, contact.memory, views.relaxation);
  contact.law_J = law.stored_J;
  put(law.force_N, contact.sway.force_N);
  describe<kIsBall>(asset, contact, kinematics, x, out);
  put(law.force_N * -(contact.ledger.share(held.stored_J) * held.share), out.force_on_tool_N);
  out.stored_J = contact.ledger.stored_J(held.stored_J);
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
  const AssetView* const body = asset.body != nullptr ? &asset : nullptr;
  const auto stored_J = [&](double law_J) noexcept {
    return stored_in(body, contact.triangle, contact.weight, law_J);
  };
  contact.ledger.book(stored_J(contact.law_J + sway_J), stored_J(after_J), asset.has_guard);
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
              bool has_guard, const AssetView* body, Output& out) noexcept {
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
                                     slipping, before_J, body, out);
    }
  auto kinematics = F::kinematics(views, cached_spot<F, kIsBall>(asset, contact), x, memory);
  return answer_from<F, kIsBall>(asset, contact, x, x, step, has_guard, memory, kinematics,
                                 kinematics, 0, body, out);
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
  const AssetView* const body = asset.body != nullptr ? &asset : nullptr;
  const double before_J =
      stored_in(body, contact.triangle, contact.weight,
                law.stored_J + sway_energy(relaxation, sway, give, sway.force()));
  Status status = Status::ok;
  is_settled = settle(fast, sway,
                      [&](const Vec3d& f) noexcept {
                        contact = start;
                        contact.ledger = Ledger();  // the law's own answer: nothing is owed
                        out = Output();
                        const Vec3d y = local(give, f);
                        status =
                            answer<F, kIsBall>(asset, contact, y, y - before, false, nullptr, out);
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
  const Softened held = bear_in(body, contact, out.normal_m, after_J);
  if (has_slipped || body != nullptr) contact.ledger.book(before_J, held.stored_J, asset.has_guard);
  contact.sway = sway;
  contact.law_J = law.stored_J;
  if (!is_settled) out.flags |= kFlagUnfinished;
  if (contact.ledger.debt_J > 0) out.flags |= kFlagHeldBack;
  put(make_vec3<double>(out.acts_at_m) + here.times(slow_force(relaxation, sway, force)),
      out.acts_at_m);
  put(law.force_N * -(contact.ledger.share(held.stored_J) * held.share), out.force_on_tool_N);
  out.stored_J = contact.ledger.stored_J(held.stored_J);
  return Status::ok;
}

}  // namespace runtime
}  // namespace palpate
