#pragma once

#include <limits>

#include "libfem/materials/kinematics.hpp"
#include "libfem/materials/law_types.hpp"

namespace palpate::fem {
/// St Venant-Kirchhoff law W = lambda/2 (tr E)^2 + mu E:E of Green's strain E: Hooke's law under
/// large rotations. For strains to about 10 %: compressed along one axis below 1/sqrt(3) of its
/// length it softens, and its energy stays finite as the volume goes; +inf where J <= 0 all the
/// same. constants: mu, lambda [Pa]. geometric_scale: scales the part of the tangent that carries
/// the stress; 1 is exact, 0 positive semidefinite everywhere. Source: Bonet and Wood, Nonlinear
/// Continuum Mechanics for Finite Element Analysis (2008), 6.3.
struct StVenantKirchhoff : YoungPoissonLaw {
  static constexpr std::string_view kName = "st-venant-kirchhoff";
  static constexpr std::string_view kSummary =
      "W = lambda/2 (tr E)^2 + mu E:E of Green's strain; strains to about 10 %";
  static constexpr bool kToleratesInversion = false;
  /// The bulk modulus multiplies tr E, which is no function of J.
  static constexpr bool kSplitsVolume = false;

  template <class S>
  static PALPATE_INLINE void volumetric(const S*, const S& dilation, S& U, S& U1, S& U2) {
    U = U1 = U2 = dilation * 0.0;
  }

  /// As NeoHookean::evaluate.
  template <class S>
  static PALPATE_INLINE void evaluate(const S* constants, const S* H, double geometric_scale, S& J,
                                      S& W, S* P, S* A) {
    const S mu = constants[0], lambda = constants[1];
    const SoundState<S> state(H);
    const S* F = state.F;
    J = state.J;
    S stress[9];  // second Piola-Kirchhoff: lambda tr E + 2 mu E
    metric_change_of(state.H, stress);
    const S trace = 0.5 * (stress[0] + stress[4] + stress[8]);
    S squares = stress[0] * stress[0] + stress[4] * stress[4] + stress[8] * stress[8];
    squares += 2.0 * (stress[1] * stress[1] + stress[2] * stress[2] + stress[5] * stress[5]);
    W = lambda * 0.5 * (trace * trace) + mu * 0.25 * squares;
    W = J > 0.0 ? W : J * 0.0 + std::numeric_limits<double>::infinity();
    if (!P) return;

    for (int i = 0; i < 9; ++i) stress[i] *= mu;
    for (int i = 0; i < 9; i += 4) stress[i] += lambda * trace;
    product_of(F, stress, P);
    if (!A) return;

    S B[9];
    for (int i = 0; i < 3; ++i)
      for (int k = i; k < 3; ++k)
        B[3 * i + k] =
            F[3 * i] * F[3 * k] + F[3 * i + 1] * F[3 * k + 1] + F[3 * i + 2] * F[3 * k + 2];
    for (int a = 0; a < 9; ++a) {
      const int i = a / 3, K = a % 3;
      for (int b = a; b < 9; ++b) {
        const int k = b / 3, L = b % 3;
        S entry = lambda * (F[a] * F[b]) + mu * (F[3 * i + L] * F[3 * k + K]);
        if (K == L) entry += mu * B[3 * i + k];
        if (i == k) entry += stress[3 * K + L] * geometric_scale;
        A[9 * a + b] = entry;
      }
    }
  }
};

}  // namespace palpate::fem
