#pragma once

#include <limits>

#include "libfem/materials/kinematics.hpp"
#include "libfem/materials/law_types.hpp"
#include "libfem/materials/volume_forms.hpp"

namespace palpate::fem {
/// Compressible neo-Hookean laws W = mu/2 (I1 - 3) - mu ln J + U(J), Lame's lambda being the
/// modulus of U. Source: Bonet and Wood, Nonlinear Continuum Mechanics for Finite Element Analysis
/// (2008), 6.4.3. constants: mu, lambda [Pa]. Matrices are 9 scalars, row major.
template <class Volume>
struct CompressibleNeoHookean : YoungPoissonLaw {
  static constexpr bool kSplitsVolume = true;
  static constexpr bool kToleratesInversion = false;

  /// U(J); the part -mu ln J stays with the shear.
  template <class S>
  static PALPATE_INLINE void volumetric(const S* constants, const S& dilation, S& U, S& U1, S& U2) {
    Volume::at(constants[1], dilation, U, U1, U2);
  }

  /// From H = F - 1: J = det F; W [Pa], +inf where J <= 0; P = dW/dF [Pa], null when not wanted (0
  /// where J <= 0); A = dP/dF, 9 x 9 row major, upper triangle only, null when not wanted (the
  /// tangent at rest where J <= 0). `geometric_scale` scales the part of A that carries the second
  /// derivative of J: 1 is the exact tangent; 0 is positive definite where U'' J^2 > -mu (with (ln
  /// J)^2, for ln J < 1 + mu/lambda).
  template <class S>
  static PALPATE_INLINE void evaluate(const S* constants, const S* H, double geometric_scale, S& J,
                                      S& W, S* P, S* A) {
    const S mu = constants[0];
    SoundState<S> state(H);
    J = state.J;
    S log_J, log_less, U, U1, U2;
    log1p_of(state.dilation, log_J, log_less);
    Volume::at(constants[1], state.dilation, U, U1, U2);
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

struct NeoHookean : CompressibleNeoHookean<LogarithmicVolume> {
  static constexpr std::string_view kName = "neo-hookean";
  static constexpr std::string_view kSummary =
      "W = mu/2 (I1 - 3) - mu ln J + lambda/2 (ln J)^2; strains to about 50 %";
};

struct NeoHookeanSimo : CompressibleNeoHookean<SimoVolume> {
  static constexpr std::string_view kName = "neo-hookean-simo";
  static constexpr std::string_view kSummary =
      "W = mu/2 (I1 - 3) - mu ln J + lambda/4 (J^2 - 1 - 2 ln J); strains to about 50 %";
};

}  // namespace palpate::fem
