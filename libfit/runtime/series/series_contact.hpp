// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// One ball or tip at a tick of its body, and how its contact ends.

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

}  // namespace runtime
}  // namespace palpate
