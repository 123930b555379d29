// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// One tick of balls and tips on one body: where they are in, forces out. No heap, no lock, no
// exception, no clock. tool/tool.hpp makes tools of them.

#include "series.hpp"

namespace palpate::runtime {

/// State that contacts on one body share between ticks, beside a Contact each, whose own
/// ledger is then not used. A fresh one knows of none. Plain data.
struct TogetherMemory {
  std::uint64_t asset_checksum = 0;
  Ledger ledger;
};

/// One ball or tip at a tick, in the frame of the body. status: what its touch() would return.
struct BallTick {
  Contact* contact = nullptr;
  const AssetView* asset = nullptr;  ///< made by with_indenter(); null: the asset of the tick
  double place_m[3] = {0, 0, 0};     ///< of the tip or the ball's centre
  double radius_m = 0;               ///< 0: a tip
  int tool = 0;                      ///< balls of one tool move together
  double worked_J = 0;               ///< done on the contact beside the work of its force
  TangentOut tangent_N_m = nullptr;
  Output out;
  Status status = Status::ok;
};

inline bool is_possible_radius(double radius_m) noexcept {
  return radius_m >= 0 && radius_m <= kMaxLength_m;
}
/// A contact at the beginning of a tick of its ball at place_m in the body's coordinates, in which
/// out is filled.
inline SeriesContact begin_tick(const AssetView& asset, Contact& contact, const double place_m[3],
                                double radius_m, Output& out) noexcept {
  out.state = ContactState::air;
  out.flags = 0;
  contact.is_inside = false;
  SeriesContact at;
  at.asset = &asset;
  at.contact = &contact;
  at.out = &out;
  at.radius_m = radius_m;
  at.x = make_vec3<double>(place_m) - make_vec3<double>(asset.origin_m);
  return at;
}
/// approach() of one whose radius is possible.
inline void approach(SeriesContact& at, const Vec3d& aside_m, double dt_s) noexcept {
  at.status = Status::radius_wrong;
  if (!is_possible_radius(at.radius_m)) return forget(*at.contact);
  at.status = approach(*at.asset, *at.contact, at.x, aside_m, at.radius_m,
                       has_flow(*at.asset, Memories()), dt_s, at.step);
}
/// Curves of another ball than this one are off by tens of percent, so that it is flagged.
inline bool is_other_radius(const AssetView& asset, double radius_m) noexcept {
  const double of = asset.probe_radius_m;
  return asset.is_rough ||
         (radius_m > 0 && of > 0 && !(std::fabs(radius_m - of) <= kSameRadius * of));
}

/// Completes an output at the end of a tick.
inline void finish(const AssetView& asset, const SeriesContact& at, const Ledger& ledger) noexcept {
  Output& out = *at.out;
  if (out.state == ContactState::air) {
    out = Output();
    if (at.status == Status::ok && at.contact->is_inside) out.flags = PALPATE_FLAG_INSIDE;
    if (TangentOut tangent = at.tangent_N_m)
      for (int k = 0; k < 9; ++k) tangent[k] = 0;
  } else if (is_other_radius(asset, at.radius_m)) {
    out.flags |= PALPATE_FLAG_OTHER_RADIUS;
  }
  put_sums(ledger, out);
}

/// The force on a tip (radius 0) or a ball whose tip or centre is at place_m [m], in the body's
/// coordinates. Call once per tick, at any rate, with its Contact. The first tick only learns where
/// it is. Where the curves were measured with a ball, a tip is that ball's lowest point, and the
/// ball does not turn (M15a). A ball's reference point is x = p + R u(c); contact begins where it
/// touches first (docs/method.md, section 12). One that begins inside the body, or a ball deeper in
/// the surface than kRestShare of its radius, has no force (PALPATE_FLAG_INSIDE) until it has come
/// out, or, having lifted off, sinks again; so does one that slid off over the rim of a surface
/// that fades to zero. Touch is swept from the previous place, so nothing tunnels. Refuses (status,
/// zero force, contact reset): a place that is not finite or farther than asset.max_step_m from the
/// one before; a contact of another asset; a radius that is negative or not finite; a force that is
/// not finite; where the body relaxes, a dt_s [s] since the tick before that is not kMinTimeStep_s
/// to kMaxTimeStep_s. worked_J: done on the contact since the tick before, beside its force's work.
/// tangent_N_m: optional, row-major 3 x 3, d(force on the body)/d(place): of the branches this tick
/// took; zero without force. Asking for it makes a tick several times as long and changes no other
/// bit. Deterministic: the same bytes and places lead to the same bits. Work: in the air the tree
/// nodes near the path; in contact, where the body does not sway, one slip of at most kMaxSegments
/// segments of kMaxRootSteps + 3 evaluations of the law's slip, and two energies; where it sways at
/// most 3 (kMaxSettleSteps + 2) of these. A longer slip continues at the next tick.
inline Status touch_ball(const AssetView& asset, Contact& contact, const double place_m[3],
                         double radius_m, Output& out, TangentOut tangent_N_m = nullptr,
                         double dt_s = 0, double worked_J = 0) noexcept {
  const Ledger before = contact.ledger;
  SeriesContact at = begin_tick(asset, contact, place_m, radius_m, out);
  at.tangent_N_m = tangent_N_m;
  at.worked_J = worked_J;
  approach(at, {0, 0, 0}, dt_s);
  if (at.status == Status::ok && contact.triangle >= 0)
    tick_contacts(asset, contact.ledger, &at, 1);
  if (out.state == ContactState::air && contact.is_inside) contact.ledger = before;  // no answer
  finish(asset, at, contact.ledger);
  return at.status;
}
/// The same of a tip.
inline Status touch(const AssetView& asset, Contact& contact, const double tip_m[3], Output& out,
                    TangentOut tangent_N_m = nullptr, double dt_s = 0) noexcept {
  return touch_ball(asset, contact, tip_m, 0, out, tangent_N_m, dt_s);
}

/// Places a contact that begins where the series will have its ball: moved by C of its own place
/// under the forces of the others. displacement_beside(), by which it was found, knows neither its
/// normal nor its sway, so that it would begin deflected by the difference, with energy that nobody
/// supplied.
inline void place_in_series(const AssetView& asset, SeriesContact& at, const CouplingPlace* place,
                            const Vec3d* force, int count) noexcept {
  Contact& contact = *at.contact;
  const CouplingPlace own = coupling_place(*at.asset, contact);
  Vec3d moved{0, 0, 0};
  for (int k = 0; k < count; ++k) {
    double by_other[9], by_own[9];
    couple(asset, own, place[k], by_other, by_own);
    moved = moved + times(by_other, force[k]);
  }
  const Vec3d arm = own.normal * contact.arm.reach_m + make_vec3<double>(contact.arm.skew_m) +
                    (moved - make_vec3<double>(contact.series.aside_m));
  contact.arm.reach_m = dot(arm, own.normal);
  put(arm - own.normal * contact.arm.reach_m, contact.arm.skew_m);
  put(moved, contact.series.aside_m);
}

/// Balls meet the surface where the others have brought it at the tick before.
inline void approach_together(const AssetView& asset, const BallTick* ball, SeriesContact* at,
                              int count, double dt_s) noexcept {
  CouplingPlace place[kMaxContacts];
  Vec3d force[kMaxContacts];
  int touching = 0;
  for (int i = 0; i < count; ++i) {
    const Contact& contact = *at[i].contact;
    if (contact.triangle < 0 || contact.asset_checksum != at[i].asset->checksum ||
        contact.triangle >= asset.triangles)
      continue;
    place[touching] = coupling_place(*at[i].asset, contact);
    force[touching++] = slow_force(asset.curves.relaxation, contact.series, contact.series.force());
  }
  for (int i = 0; i < count; ++i) {
    Contact& contact = *at[i].contact;
    const bool was_outside = contact.triangle < 0 && !contact.has_lifted;
    const Vec3d aside =
        touching > 0 && contact.triangle < 0
            ? displacement_beside(asset, place, force, touching, at[i].x, ball[i].radius_m)
            : Vec3d{0, 0, 0};
    approach(at[i], aside, dt_s);
    const bool begins = was_outside && at[i].status == Status::ok && contact.triangle >= 0;
    if (touching > 0 && begins && contact.arm.reach_m > 0)
      place_in_series(asset, at[i], place, force, touching);
  }
}

/// The asset of a ball: its own, or that of the tick.
inline const AssetView& ball_asset(const AssetView& asset, const BallTick& ball) noexcept {
  return ball.asset != nullptr ? *ball.asset : asset;
}

/// Returns true if two balls overlap: their coupling is then bounded, not known.
inline bool are_crowded(const AssetView& asset, const BallTick& a, const BallTick& b) noexcept {
  const Vec3d offset = make_vec3<double>(a.place_m) - make_vec3<double>(b.place_m);
  const auto radius = [&](const BallTick& t) noexcept {
    return t.radius_m > 0 ? t.radius_m : ball_asset(asset, t).probe_radius_m;
  };
  const double reach = radius(a) + radius(b);
  return dot(offset, offset) < reach * reach;
}

/// One tick of 1 to kMaxContacts balls and tips; some may join or leave between ticks. Where the
/// asset's contacts do not move each other this is touch_ball() of each, bit for bit. Otherwise
/// stored_J of the outputs add up to what all store together, and the sums are those of all
/// together; one whose status is not ok is out of contact, and the others go on. Work: of each what
/// touch_ball() says of a body that sways.
inline void touch_together(const AssetView& asset, TogetherMemory& together, BallTick* ball,
                           int count, double dt_s = 0) noexcept {
  if (asset.coupling == nullptr) {
    for (int i = 0; i < count; ++i)
      ball[i].status =
          touch_ball(ball_asset(asset, ball[i]), *ball[i].contact, ball[i].place_m,
                     ball[i].radius_m, ball[i].out, ball[i].tangent_N_m, dt_s, ball[i].worked_J);
    return;
  }
  if (together.asset_checksum != asset.checksum) {
    together = TogetherMemory();
    together.asset_checksum = asset.checksum;
    for (int i = 0; i < count; ++i) forget(*ball[i].contact);
  }
  Room<SeriesContact, kMaxContacts> at;
  for (int i = 0; i < count; ++i) {
    BallTick& b = ball[i];
    at.make(i, begin_tick(ball_asset(asset, b), *b.contact, b.place_m, b.radius_m, b.out));
    at[i].tool = b.tool;
    at[i].worked_J = b.worked_J;
    at[i].tangent_N_m = b.tangent_N_m;
  }
  approach_together(asset, ball, at.begin(), count, dt_s);
  tick_contacts(asset, together.ledger, at.begin(), count);
  for (int i = 0; i < count; ++i) {
    ball[i].status = at[i].status;
    finish(*at[i].asset, at[i], together.ledger);
    for (int j = 0; j < count; ++j)
      if (ball[j].tool != ball[i].tool && ball[i].out.state != ContactState::air &&
          are_crowded(asset, ball[i], ball[j]))
        ball[i].out.flags |= PALPATE_FLAG_CROWDED;
  }
}

}  // namespace palpate::runtime
