#pragma once

#include "libfem/materials/materials.hpp"
#include "libfem/materials/pack_math.hpp"

namespace palpate::fem {

/// erf(x) and its integral from 0 to x, for x >= 0, to 2e-15 of 1 and of themselves.
/// Source: the series of positive terms below kSwitch, Laplace's continued fraction of erfc above
/// (Abramowitz and Stegun 7.1.6 and 7.1.14).
template <class S>
PALPATE_INLINE void erf_of(const S& argument, S& erf, S& integral) {
  constexpr double kSwitch = 2.5, kMost = 26, kRootPi = 1.77245385090551602730;
  constexpr int kTerms = 60, kLevels = 40;
  const S zero = argument * 0.0, most = zero + kMost, change = zero + kSwitch;
  const S x = argument < most ? argument : most;
  const S square = x * x;
  S less, grown;  // e^{-x^2} - 1, and e^{x^2} - 1 for the digits that the first one loses
  expm1_of(S(-square), less);
  expm1_of(square, grown);
  const S low = x < change ? x : change, twice = 2.0 * (low * low);
  S term = low, series = low;
  for (int n = 1; n < kTerms; ++n) {
    term = term * twice * (1.0 / (2 * n + 1));
    series += term;
  }
  const S high = x > change ? x : change;
  S tail = high;
  for (int n = kLevels; n > 0; --n) tail = high + (0.5 * n) / tail;
  const S bell = 1.0 / ((grown + 1.0) * kRootPi);
  erf = x < change ? 2.0 * (bell * series) : 1.0 - bell / tail;
  integral = argument * erf + less * (1.0 / kRootPi);
}

/// Softening adds this to the energy of shape W0 >= 0 where the largest so far is `peak` (M54b)
/// [Pa], how much less than 1 its factor eta is (M54a), and the factor's slope over W0 [1/Pa]; all
/// 0 where W0 is the largest.
template <class S>
PALPATE_INLINE void soften(const Softening& softening, const S& peak, const S& shape, S& added,
                           S& less, S& slope) {
  constexpr double kRootPi = 1.77245385090551602730;
  const S zero = shape * 0.0;
  const S below = shape < peak ? peak - shape : zero;
  const S scale = softening.scale_Pa + softening.beta * peak + 1e-30;  // not 0 of a body at rest
  const S x = below / scale;
  S erf, integral, bell;
  erf_of(x, erf, integral);
  expm1_of(S(-(x * x)), bell);
  added = scale * integral * (1.0 / softening.r);
  less = erf * (1.0 / softening.r);
  slope = shape < peak ? (bell + 1.0) * (2.0 / (kRootPi * softening.r)) / scale : zero;
}

}  // namespace palpate::fem
