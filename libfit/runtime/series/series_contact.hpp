// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// One ball or tip at a tick of its body: how its contact ends, and its tick by itself on a rigid
// body.

#include "../contact/contact_law.hpp"

namespace palpate::runtime {

/// One ball or tip at a tick.
struct SeriesContact {
  const AssetView* asset = nullptr;  ///< made by with_indenter(), or that of the tick
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

inline bool exceeds_debt_limit(const AssetView& asset, const Ledger& ledger, double law_J,
                               double depth_m) noexcept {
  return ledger.debt_J > 0 && ledger.share(law_J) < kMinForceShare &&
         depth_m > kMinDepthShare * asset.max_fitted_m;
}

/// Contact ends where its ball's centre or tip is at x; a ball that has lifted hovers there.
inline void end_contact(const AssetView& asset, const SeriesContact& at, bool hovers,
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

/// Time passes for a contact on a rigid body.
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

/// The tick of a contact by itself on a rigid body.
template <class F, bool kIsBall>
Status tick_alone(const AssetView& asset, const SeriesContact& at, Ledger& ledger,
                  TangentOut tangent_N_m) noexcept {
  Contact& contact = *at.contact;
  Output& out = *at.out;
  const Vec3d x = at.x - make_vec3<double>(contact.arm.pole_m);
  const Vec3d step = at.step + make_vec3<double>(contact.series.aside_m);  // the others ended
  put({0, 0, 0}, contact.series.aside_m);
  rest_alone<F, kIsBall>(asset, contact, x - step, ledger);
  if (tangent_N_m != nullptr)
    law_tangent<F, kIsBall>(asset, contact, contact.left, x, step, tangent_N_m);
  auto memory = F::template load<double>(contact.memory, asset.curves.relaxation);
  SlipReport report;
  const Slipped slipped = slip<F, kIsBall>(asset, contact, contact.cache, contact.cache,
                                           contact.left, x, step, memory, report);
  if (slipped.is_released) {
    ledger.close(slipped.before_J);
    end_contact(asset, at, slipped.is_lifted, at.x);
    return Status::ok;
  }
  const Answer<double>& law = slipped.law;
  if (!is_finite(law.force_N) || !is_finite(law.stored_J)) {
    ledger.close(0);
    forget(contact);
    out.state = ContactState::air;
    return Status::force_not_finite;
  }
  const MemoryEnergy energy =
      load(asset, contact, slipped.depth.normal_m, law.stored_J, Memories());
  if (slipped.is_booked || at.worked_J != 0 || has_memory(asset, Memories()))
    ledger.book(slipped.before_J, energy.stored_J, asset.has_guard, at.worked_J);
  if (exceeds_debt_limit(asset, ledger, energy.stored_J, slipped.depth.normal_m)) {
    ledger.close(energy.stored_J);
    end_contact(asset, at, true, at.x);
    return Status::ok;
  }
  F::save(memory, contact.memory, asset.curves.relaxation);
  contact.law_J = law.stored_J;
  put(law.force_N, contact.series.force_N);
  describe(asset, contact, contact.cache, slipped.depth, x, report, out);
  if (ledger.debt_J > 0) out.flags |= PALPATE_FLAG_HELD_BACK;
  const double share = ledger.share(energy.stored_J);
  out.law_share = share * energy.share;
  put(law.force_N * -out.law_share, out.force_on_tool_N);
  out.stored_J = ledger.stored_J(energy.stored_J);
  if (tangent_N_m == nullptr) return Status::ok;
  scale_tangent(energy.share, energy.slope, law.force_N, tangent_N_m);
  scale_tangent(share, ledger.share_slope(energy.stored_J), law.force_N * energy.share,
                tangent_N_m);
  return Status::ok;
}

}  // namespace palpate::runtime
