#pragma once

#include <limits>

#include "libfem/materials/pack_math.hpp"

namespace palpate::fem {

/// Beyond this exponent an exponential law's energy is +inf (e^200 = 7e86 times its modulus: no
/// tissue is there), and its derivatives stay those of the bound, so that they never overflow.
inline constexpr double kLargestExponent = 200;

/// exp(Q) - 1, its value for energies (+inf beyond the bound) and for derivatives.
template <class S>
PALPATE_INLINE void bounded_expm1_of(const S& exponent, S& for_energy, S& for_derivatives) {
  const S bound = exponent * 0.0 + kLargestExponent;
  const S infinite = exponent * 0.0 + std::numeric_limits<double>::infinity();
  expm1_of(S(exponent < bound ? exponent : bound), for_derivatives);
  for_energy = exponent > bound ? infinite : for_derivatives;
}

}  // namespace palpate::fem
