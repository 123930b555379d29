// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// The energy that a contact may store (docs/method.md, section 18). Between slips the law's force
// is the gradient of its energy E. A slip over an uneven body may raise E although nobody works.
// What earlier slips dissipated pays for it (the tank); what they cannot pay becomes a debt b, and
// the contact then stores and answers
//
//     U = E^2 / (E + b)        f = (dU/dE) dE/dx,    dU/dE = 1 - (b / (E + b))^2 (M20)
//
// U + tank never rises in a slip, so the work done on a contact is never negative.

#include <cmath>
#include <cstdint>

#include "constants.hpp"
#include "rounding.hpp"

namespace palpate::runtime {

/// Ledger of one contact; dissipated and refused are sums since it is in use.
struct Ledger {
  double tank_J = 0;  ///< of this contact, at most kTank_J
  double debt_J = 0;  ///< b
  double dissipated_J = 0;
  double refused_J = 0;            ///< that slips would have created, each joule once
  std::int64_t refused_ticks = 0;  ///< ticks at which a debt was made or grew

  /// U of the law's energy E [J] (M20).
  double stored_J(double law_J) const noexcept {
    return debt_J > 0 && law_J > 0 ? law_J * (law_J / (law_J + debt_J)) : law_J;
  }
  /// dU/dE (M20): the share of the law's force that the contact keeps.
  double share(double law_J) const noexcept {
    if (!(debt_J > 0)) return 1;
    const double owed = debt_J / ((law_J > 0 ? law_J : 0) + debt_J);
    return 1 - owed * owed;
  }
  /// The slope of share(): what the tangent adds.
  double share_slope(double law_J) const noexcept {
    if (!(debt_J > 0)) return 0;
    const double sum = (law_J > 0 ? law_J : 0) + debt_J;
    return 2 * (debt_J / sum) * (debt_J / sum) / sum;
  }

  /// Slips took the law's energy from before_J to after_J with the tool held: within (M10) nothing
  /// is owed. worked_J: done on the contact meanwhile, beside the work of the law's force.
  void book(double before_J, double after_J, bool has_guard, double worked_J = 0) noexcept {
    const double stored = stored_J(before_J), owed = before_J - stored;
    const double before = stored + worked_J, allowed = before + tank_J;
    if (!is_finite(before) || !is_finite(after_J)) {  // what has no number may store nothing
      tank_J = 0;
      debt_J = kMaxDebt_J;
      return;
    }
    double after = after_J;
    const bool is_paid = !has_guard || after_J <= allowed + before * kEnergyNoise;
    debt_J = 0;
    if (!is_paid) {
      after = allowed;
      debt_J = allowed > 0 ? after_J * ((after_J - allowed) / allowed) : kMaxDebt_J;
      if (!(debt_J < kMaxDebt_J)) debt_J = kMaxDebt_J;
      if (after_J - after > owed) {
        refused_J += after_J - after - owed;
        ++refused_ticks;
      }
    }
    dissipated_J += before - after;
    const double left = allowed - after;
    tank_J = left > 0 ? (left < kTank_J ? left : kTank_J) : 0;
  }
  /// Contact ends with the law's energy at law_J.
  void close(double law_J) noexcept {
    if (is_finite(law_J)) dissipated_J += stored_J(law_J);
    tank_J = debt_J = 0;
  }
};

}  // namespace palpate::runtime
