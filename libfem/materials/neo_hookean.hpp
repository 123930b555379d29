#pragma once

#include <limits>

#include "libfem/materials/pack.hpp"

namespace palpate::fem {

/// Compressible neo-Hookean law (Bonet and Wood 2008, 6.4.3):
///   W = mu/2 (I1 - 3) - mu ln J + lambda/2 (ln J)^2.
/// Written in the displacement gradient H = F - 1, so that small strains lose no digits.
/// constants: mu, lambda [Pa]. Matrices are 9 scalars, row major.
struct NeoHookean {
  static constexpr int kConstants = 2;
  static constexpr bool kSplitsVolume = true;

  /// The part U(J) of W that carries the bulk modulus, lambda/2 (ln J)^2, and its first and second
  /// derivative by J [Pa]. dilation: J - 1, above -1.
  template <class S>
  static PALPATE_INLINE void volumetric(const S* constants, const S& dilation, S& U, S& U1, S& U2) {
    const S lambda = constants[1], inverse_J = 1.0 / (dilation + 1.0);
    S log_J;
    log1p_of(dilation, log_J);
    U = lambda * 0.5 * (log_J * log_J);
    U1 = lambda * log_J * inverse_J;
    U2 = lambda * (1.0 - log_J) * (inverse_J * inverse_J);
  }

  /// W [Pa], +inf where J <= 0; P = dW/dF [Pa] (finite garbage there); A = dP/dF, 9 x 9 row major,
  /// upper triangle only, null when not wanted. `bend` scales the part of A that carries the second
  /// derivative of J: 1 is the exact tangent, 0 is positive definite for ln J < 1 + mu/lambda.
  template <class S>
  static PALPATE_INLINE void evaluate(const S* constants, const S* H, double bend, S& J, S& W,
                                      S* P, S* A) {
    const S mu = constants[0], lambda = constants[1];
    const S zero = mu * 0.0, one = zero + 1.0, infinite = zero + kInfinity;
    const S f00 = H[0] + 1.0, f11 = H[4] + 1.0, f22 = H[8] + 1.0;
    // Cofactors of F; J - 1 is summed from the small terms.
    S g[9];
    g[0] = f11 * f22 - H[5] * H[7];
    g[1] = H[5] * H[6] - H[3] * f22;
    g[2] = H[3] * H[7] - f11 * H[6];
    g[3] = H[2] * H[7] - H[1] * f22;
    g[4] = f00 * f22 - H[2] * H[6];
    g[5] = H[1] * H[6] - f00 * H[7];
    g[6] = H[1] * H[5] - H[2] * f11;
    g[7] = H[2] * H[3] - f00 * H[5];
    g[8] = f00 * f11 - H[1] * H[3];
    const S minors = H[4] * H[8] - H[5] * H[7] + H[0] * H[8] - H[2] * H[6] + H[0] * H[4] -
                     H[1] * H[3];
    const S trace = H[0] + H[4] + H[8];
    const S determinant = H[0] * (H[4] * H[8] - H[5] * H[7]) + H[1] * (H[5] * H[6] - H[3] * H[8]) +
                          H[2] * (H[3] * H[7] - H[4] * H[6]);
    const S dilation = trace + minors + determinant;
    J = dilation + 1.0;
    const S safe_dilation = J > 0.0 ? dilation : zero;
    S log_J;
    log1p_of(safe_dilation, log_J);
    S squares = zero;
    for (int i = 0; i < 9; ++i) squares += H[i] * H[i];
    W = mu * (trace + squares * 0.5 - log_J) + lambda * 0.5 * (log_J * log_J);
    W = J > 0.0 ? W : infinite;
    if (!P) return;

    const S inverse_J = one / (J > 0.0 ? J : one);
    for (int i = 0; i < 9; ++i) g[i] *= inverse_J;  // F^-T
    // mu (F - F^-T) = mu (H + H^T F^-T)
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        P[3 * i + j] = mu * (H[3 * i + j] + H[i] * g[j] + H[3 + i] * g[3 + j] + H[6 + i] * g[6 + j]) +
                       lambda * log_J * g[3 * i + j];
    if (!A) return;

    const S pressure_part = (lambda * log_J - mu) * bend;   // J U'
    const S stiff_part = mu + lambda - lambda * log_J;      // J^2 U''
    for (int a = 0; a < 9; ++a) {
      for (int b = a; b < 9; ++b) {
        // g_a g_b (J^2 U'' + J U') - J U' F^-T_(iL) F^-T_(kJ), with a = (i,J), b = (k,L)
        const int i = a / 3, J_ = a % 3, k = b / 3, L = b % 3;
        A[9 * a + b] = (stiff_part + pressure_part) * (g[a] * g[b]) -
                       pressure_part * (g[3 * i + L] * g[3 * k + J_]);
      }
      A[10 * a] += mu;
    }
  }

 private:
  static constexpr double kInfinity = std::numeric_limits<double>::infinity();
};

}  // namespace palpate::fem
