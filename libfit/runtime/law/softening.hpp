// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// Softening of a damaged place (docs/method-body.md, section 26). With E what the law stores and M
// the largest energy that this place has stored, the contact stores Psi(E; M), and its force is eta
// dE/dx:
//
//     eta = dPsi/dE = max(0, 1 - (1/r) y / sqrt(w^2 + y^2)),   y = max(M - E, 0),   w = m + beta M
//
// which falls as M rises, at every E, so that damage dissipates (M56). Energies are in joules, and
// m = scale times the unit e of the place.

#include <cmath>

#include "../base/constants.hpp"
#include "../base/rounding.hpp"

namespace palpate::runtime {

/// Constants of the softening of a body.
struct DamageView {
  double r = 0;        ///< kMinDamage to kMaxDamage, below 1 a dent stays; 0: it does not soften
  double scale = 0;    ///< m over e
  double beta = 0;     ///< m or beta is not 0
  double reach_m = 0;  ///< how far around a contact as deep as the curves a place is damaged

  bool softens() const noexcept { return r != 0; }
};

/// Energy that a contact stores as a function of the law's energy E.
struct MemoryEnergy {
  double stored_J;  ///< Psi
  double share;     ///< eta
  double slope;     ///< d eta / dE [1/J]
};

/// (M56). law_J: E; most_J: M; unit_J: e; none negative.
inline MemoryEnergy softened(const DamageView& damage, double unit_J, double most_J,
                             double law_J) noexcept {
  if (!(most_J > 0) || !(law_J > 0)) return {law_J, 1, 0};
  const double w = damage.scale * unit_J + damage.beta * most_J;
  if (!(w > 0)) return {law_J, 1, 0};
  // y at which nothing is stored: M, or where eta comes to 0.
  double last = most_J;
  if (damage.r < 1) {
    const double zero = w * damage.r / std::sqrt(1 - damage.r * damage.r);
    if (zero < last) last = zero;
  }
  const double root_0 = std::sqrt(w * w + last * last);
  if (law_J >= most_J) return {law_J - most_J + last - (root_0 - w) / damage.r, 1, 0};
  const double y = most_J - law_J;
  if (y >= last) return {0, 0, 0};
  const double root = std::sqrt(w * w + y * y);
  return {last - y - (root_0 - root) / damage.r, 1 - y / (damage.r * root),
          w * w / (damage.r * (root * root * root))};
}

}  // namespace palpate::runtime
