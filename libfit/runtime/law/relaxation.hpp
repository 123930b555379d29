// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// The Prony series of a body (docs/method-body.md, section 24): at time t after a step a contact is
// 1 + sum share_k e^{-t/time_k} times as stiff as in slow motion.

#include "../base/constants.hpp"
#include "../base/rounding.hpp"
#include "../base/scalar.hpp"

namespace palpate::runtime {

/// Prony series of a body; no branches: it does not relax.
struct RelaxationView {
  int branches = 0;
  double share[kMaxBranches] = {};   ///< > 0
  double time_s[kMaxBranches] = {};  ///< rising
  double fast = 1;                   ///< 1 + sum of the shares: stiffness at first over slow
  double radius_m = 0;               ///< of the ball; 0: slides renew no material
};

/// e^{-x} for x >= 0, to 1e-15 of itself: plain arithmetic, so every compiler and C library has the
/// same bits. 0 from x = 700 on.
inline double decay(double x) noexcept {
  if (!(x < 700)) return 0;
  constexpr double kLog2 = 0.693147180559945309417, kLog2High = 0.69314718036912381649,
                   kLog2Low = 1.90821492927058770002e-10;
  int halvings = static_cast<int>(x / kLog2 + 0.5);
  const double r = (halvings * kLog2High - x) + halvings * kLog2Low;  // within log(2)/2
  constexpr double kInverse[] = {0,        1,        1.0 / 2,  1.0 / 3,  1.0 / 4,
                                 1.0 / 5,  1.0 / 6,  1.0 / 7,  1.0 / 8,  1.0 / 9,
                                 1.0 / 10, 1.0 / 11, 1.0 / 12, 1.0 / 13, 1.0 / 14};
  double sum = 1;
  for (int k = 14; k > 0; --k) sum = 1 + sum * r * kInverse[k];
  for (double half = 0.5; halvings > 0; halvings >>= 1, half *= half)
    if (halvings & 1) sum *= half;
  return sum;
}

/// The same with derivatives; x >= 0.
template <class T>
T decay(const T& x) noexcept {
  return decay(value_of(x)) * (T(1) - (x - T(value_of(x))));
}

/// Share of each branch's force that is left after dt_s [s].
struct Decay {
  double share[kMaxBranches] = {1, 1, 1};
  double dt_s = 0;
};
inline Decay decay_over(const RelaxationView& relaxation, double dt_s) noexcept {
  Decay out;
  out.dt_s = dt_s;
  for (int k = 0; k < relaxation.branches; ++k) out.share[k] = decay(dt_s / relaxation.time_s[k]);
  return out;
}

}  // namespace palpate::runtime
