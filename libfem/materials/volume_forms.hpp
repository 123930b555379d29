#pragma once

#include <limits>

#include "libfem/materials/pack_math.hpp"

namespace palpate::fem {

// Volumetric energies U(J) with U(1) = U'(1) = 0 and U''(1) = modulus, from dilation = J - 1:
// U [Pa], U1 = dU/dJ, U2 = d2U/dJ2.

/// U = K/2 (J - 1)^2, finite at every J.
struct QuadraticVolume {
  template <class S>
  static PALPATE_INLINE void at(const S& modulus, const S& dilation, S& U, S& U1, S& U2) {
    U1 = modulus * dilation;
    U = U1 * dilation * 0.5;
    U2 = modulus;
  }
};

/// U = K/2 (ln J)^2; +inf where J <= 0, with finite derivatives of no meaning. Not convex beyond
/// J = e.
struct LogarithmicVolume {
  template <class S>
  static PALPATE_INLINE void at(const S& modulus, const S& dilation, S& U, S& U1, S& U2) {
    const S zero = dilation * 0.0, infinite = zero + std::numeric_limits<double>::infinity();
    const S safe = dilation > -1.0 ? dilation : zero;
    const S inverse_J = (zero + 1.0) / (safe + 1.0);
    S log_J;
    log1p_of(safe, log_J);
    U = dilation > -1.0 ? modulus * 0.5 * (log_J * log_J) : infinite;
    U1 = modulus * log_J * inverse_J;
    U2 = modulus * (1.0 - log_J) * (inverse_J * inverse_J);
  }
};

/// U = K/4 (J^2 - 1 - 2 ln J), convex; +inf where J <= 0, with finite derivatives of no meaning.
/// Source: Simo and Taylor 1991, doi:10.1016/0045-7825(91)90100-K.
struct SimoVolume {
  template <class S>
  static PALPATE_INLINE void at(const S& modulus, const S& dilation, S& U, S& U1, S& U2) {
    const S zero = dilation * 0.0, infinite = zero + std::numeric_limits<double>::infinity();
    const S safe = dilation > -1.0 ? dilation : zero;
    const S inverse_J = (zero + 1.0) / (safe + 1.0);
    S log_J, log_less;
    log1p_of(safe, log_J, log_less);
    U = dilation > -1.0 ? modulus * 0.25 * (safe * safe - 2.0 * log_less) : infinite;
    U1 = modulus * 0.5 * (safe * (safe + 2.0)) * inverse_J;
    U2 = modulus * 0.5 * (inverse_J * inverse_J + 1.0);
  }
};

}  // namespace palpate::fem
