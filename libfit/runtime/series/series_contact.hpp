// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// One ball or tip at a tick of its body: how its contact ends, and its tick by itself on a body
// that does not give.

#include "../contact/contact_law.hpp"

namespace palpate {
namespace runtime {

/// One ball or tip at a tick.
struct SeriesContact {
  const AssetView* asset = nullptr;  ///< as it meets it
  Contact* contact = nullptr;
  Output* out = nullptr;
  double radius_m = 0;  ///< 0: a tip
  Vec3d x{0, 0, 0};     ///< of the tip or the ball's centre, from the asset's origin
  Vec3d step{0, 0, 0};  ///< of the tool itself since the tick before
  Status status = Status::ok;
  int tool = 0;                   ///< contacts of one tool move together
  double worked_J = 0;            ///< done on the contact beside the work of its force
  double* tangent_N_m = nullptr;  ///< of the tool, 3 x 3; null: not wanted
};

/// act(F(), kIsBall) of a contact's law: of a ball, of its own or of the one that its tip stands
/// for.
template <class Act>
auto with_law(const AssetView& asset, double radius_m, const Act& act) noexcept {
  const bool is_ball = radius_m > 0 || asset.probe_radius_m > 0;
  return with_family(asset.curves, [&](auto f) noexcept {
    return is_ball ? act(f, std::true_type()) : act(f, std::false_type());
  });
}

/// A slide that nothing pays may leave a contact with next to none of its force, and for long: debt
/// falls as work comes in, and there is none where there is no force. With less than this share of
/// a force that is deeper than kDeepShare of the curves, contact begins anew where the ball stands,
/// with nothing deflected. What was stored is lost, so nothing is created.
constexpr double kLeastShare = 0.1, kDeepShare = 0.01;
inline bool is_held_too_far_back(const AssetView& asset, const Ledger& ledger, double law_J,
                                 double depth_m) noexcept {
  return ledger.debt_J > 0 && ledger.share(law_J) < kLeastShare &&
         depth_m > kDeepShare * asset.max_fitted_m;
}

/// Contact ends where its ball's centre or tip is at x; a ball that has lifted hovers there.
inline void let_go(const AssetView& asset, const SeriesContact& at, bool hovers,
                   const Vec3d& x) noexcept {
  Contact& contact = *at.contact;
  const Arm arm = contact.arm;
  const int triangle = contact.triangle;
  const double n[3] = {contact.weight[0], contact.weight[1], contact.weight[2]};
  release(contact);
  at.out->state = ContactState::air;
  if (!hovers) return;
  with_law(asset, at.radius_m, [&](auto f, auto is_ball) noexcept {
    if constexpr (is_ball)
      hover<decltype(f), true>(asset, contact, x - make_vec3<double>(arm.pole_m), triangle, n, arm);
  });
}

/// Time passes for a contact on a body that does not give.
template <class F, bool kIsBall>
void rest_alone(const AssetView& asset, Contact& contact, const Vec3d& before,
                Ledger& ledger) noexcept {
  if (!has_flow(asset, Memories()) || contact.is_rested) return;
  contact.is_rested = true;
  double law_J = contact.law_J;
  if (rest<F, kIsBall>(asset, contact, before, law_J))
    ledger.book(stored_in(asset, contact, contact.law_J, Memories()).stored_J,
                stored_in(asset, contact, law_J, Memories()).stored_J, asset.has_guard);
}

/// The tick of a contact by itself on a body that does not give.
template <class F, bool kIsBall>
Status tick_alone(const AssetView& asset, const SeriesContact& at, Ledger& ledger,
                  TangentOut tangent_N_m) noexcept {
  Contact& contact = *at.contact;
  Output& out = *at.out;
  const Vec3d x = at.x - make_vec3<double>(contact.arm.pole_m);
  const Vec3d step = at.step + make_vec3<double>(contact.series.aside_m);  // others have let go
  put({0, 0, 0}, contact.series.aside_m);
  rest_alone<F, kIsBall>(asset, contact, x - step, ledger);
  if (tangent_N_m != nullptr)
    law_tangent<F, kIsBall>(asset, contact, contact.left, x, step, tangent_N_m);
  auto memory = F::template load<double>(contact.memory, asset.curves.relaxation);
  Said said;
  const Slipped slipped = slip<F, kIsBall>(asset, contact, contact.cache, contact.cache,
                                           contact.left, x, step, memory, said);
  if (slipped.has_let_go) {
    ledger.close(slipped.before_J);
    let_go(asset, at, slipped.is_lifted, at.x);
    return Status::ok;
  }
  const Answer<double>& law = slipped.law;
  if (!is_finite(law.force_N) || !is_finite(law.stored_J)) {
    ledger.close(0);
    forget(contact);
    out.state = ContactState::air;
    return Status::force_not_finite;
  }
  const Softened held = load(asset, contact, slipped.depth.normal_m, law.stored_J, Memories());
  if (slipped.is_booked || at.worked_J != 0 || has_memory(asset, Memories()))
    ledger.book(slipped.before_J, held.stored_J, asset.has_guard, at.worked_J);
  if (is_held_too_far_back(asset, ledger, held.stored_J, slipped.depth.normal_m)) {
    ledger.close(held.stored_J);
    let_go(asset, at, true, at.x);
    return Status::ok;
  }
  F::save(memory, contact.memory, asset.curves.relaxation);
  contact.law_J = law.stored_J;
  put(law.force_N, contact.series.force_N);
  describe(asset, contact, contact.cache, slipped.depth, x, said, out);
  if (ledger.debt_J > 0) out.flags |= kFlagHeldBack;
  const double share = ledger.share(held.stored_J);
  out.law_share = share * held.share;
  put(law.force_N * -out.law_share, out.force_on_tool_N);
  out.stored_J = ledger.stored_J(held.stored_J);
  if (tangent_N_m == nullptr) return Status::ok;
  scale_tangent(held.share, held.slope, law.force_N, tangent_N_m);
  scale_tangent(share, ledger.share_slope(held.stored_J), law.force_N * held.share, tangent_N_m);
  return Status::ok;
}

}  // namespace runtime
}  // namespace palpate
