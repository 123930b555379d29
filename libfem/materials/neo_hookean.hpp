#pragma once

#include <limits>

#include "libfem/materials/kinematics.hpp"
#include "libfem/materials/materials.hpp"

namespace palpate::fem {
/// Compressible neo-Hookean law W = mu/2 (I1 - 3) - mu ln J + lambda/2 (ln J)^2. Source: Bonet and
/// Wood, Nonlinear Continuum Mechanics for Finite Element Analysis (2008), 6.4.3. constants: mu,
/// lambda [Pa]. Matrices are 9 scalars, row major.
struct NeoHookean : YoungPoissonLaw {
  static constexpr std::string_view kName = "neo-hookean";
  static constexpr std::string_view kSummary =
      "W = mu/2 (I1 - 3) - mu ln J + lambda/2 (ln J)^2; strains to about 50 %";

  /// U = lambda/2 (ln J)^2; +inf where J <= 0, with finite derivatives of no meaning. Not convex
  /// beyond J = e. The part -mu ln J stays with the shear.
  template <class S>
  static PALPATE_INLINE void volumetric(const S* constants, const S& dilation, S& U, S& U1, S& U2) {
    const S lambda = constants[1];
    const S zero = dilation * 0.0, infinite = zero + std::numeric_limits<double>::infinity();
    const S safe = dilation > -1.0 ? dilation : zero;
    const S inverse_J = (zero + 1.0) / (safe + 1.0);
    S log_J;
    log1p_of(safe, log_J);
    U = dilation > -1.0 ? lambda * 0.5 * (log_J * log_J) : infinite;
    U1 = lambda * log_J * inverse_J;
    U2 = lambda * (1.0 - log_J) * (inverse_J * inverse_J);
  }

  /// From H = F - 1: J = det F; W [Pa], +inf where J <= 0; P = dW/dF [Pa], null when not wanted (0
  /// where J <= 0); A = dP/dF, 9 x 9 row major, upper triangle only, null when not wanted (the
  /// tangent at rest where J <= 0). `geometric_scale` scales the part of A that carries the second
  /// derivative of J: 1 is the exact tangent; 0 is positive definite where ln J < 1 + mu/lambda.
  template <class S>
  static PALPATE_INLINE void evaluate(const S* constants, const S* H, double geometric_scale, S& J,
                                      S& W, S* P, S* A) {
    const S mu = constants[0];
    SoundState<S> state(H);
    J = state.J;
    S log_J, log_less, U, U1, U2;
    log1p_of(state.dilation, log_J, log_less);
    volumetric(constants, state.dilation, U, U1, U2);
    const GradientInvariants<S> in(state.H);
    S squares = state.H[0] * state.H[0];
    for (int i = 1; i < 9; ++i) squares += state.H[i] * state.H[i];
    // (I1 - 3)/2 - ln J, the first-order terms having cancelled
    W = mu * (squares * 0.5 - in.minors - in.determinant - log_less) + U;
    W = J > 0.0 ? W : J * 0.0 + std::numeric_limits<double>::infinity();
    if (!P) return;

    state.invert();
    const S* g = state.g;
    const S* h = state.H;
    // mu (F - F^-T) = mu (H + H^T F^-T)
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        P[3 * i + j] =
            mu * (h[3 * i + j] + h[i] * g[j] + h[3 + i] * g[3 + j] + h[6 + i] * g[6 + j]) +
            state.J_sound * U1 * g[3 * i + j];
    if (!A) return;

    const S geometric = (state.J_sound * U1 - mu) * geometric_scale;
    const S stiff_part = mu + state.J_sound * state.J_sound * U2;
    for (int a = 0; a < 9; ++a) {
      const int i = a / 3, K = a % 3;
      for (int b = a; b < 9; ++b) {
        const int k = b / 3, L = b % 3;
        A[9 * a + b] =
            (stiff_part + geometric) * (g[a] * g[b]) - geometric * (g[3 * i + L] * g[3 * k + K]);
      }
      A[10 * a] += mu;
    }
  }
};

}  // namespace palpate::fem
