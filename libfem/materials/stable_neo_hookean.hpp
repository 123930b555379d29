#pragma once

#include "libfem/materials/kinematics.hpp"
#include "libfem/materials/law_types.hpp"
#include "libfem/materials/volume_forms.hpp"

namespace palpate::fem {
/// Neo-Hookean law that stays finite and smooth when elements turn inside out,
///   W = m/2 (I1 - 3) - m/2 ln((I1 + 1)/4) + l/2 (J - 1)^2 - 3 m/4 (J - 1),
/// with m = 4/3 mu and l = lambda + 5/6 mu, so that small strains follow Hooke's law with mu and
/// lambda. Where J <= 0 energy, stress and tangent are the formula's: turned inside out or
/// flattened, a body is driven back to rest. constants: m, l [Pa]. geometric_scale: scales the part
/// of the tangent that carries the second derivative of J; 1 is exact, 0 positive semidefinite
/// everywhere. Source: Smith, de Goes and Kim 2018, doi:10.1145/3180491, equations (14) to (16)
/// less their constant, so that W = 0 at rest.
struct StableNeoHookean : YoungPoissonLaw {
  static constexpr std::string_view kName = "stable-neo-hookean";
  static constexpr std::string_view kSummary =
      "Neo-Hookean of Smith, de Goes and Kim, finite when turned inside out; strains to about 50 %";
  static constexpr bool kSplitsVolume = true;
  static constexpr bool kToleratesInversion = true;

  static LawConstants constants(std::span<const double> values) {
    const SmallStrain hooke = of_young_and_poisson(values);
    return {4 * hooke.mu_Pa / 3, hooke.lambda_Pa + 5 * hooke.mu_Pa / 6};
  }
  static SmallStrain small_strain(const LawConstants& c) {
    return {3 * c[0] / 4, c[1] - 5 * c[0] / 8};
  }

  /// U = l/2 (J - 1)^2; the part linear in J stays with the shear.
  template <class S>
  static PALPATE_INLINE void volumetric(const S* constants, const S& dilation, S& U, S& U1, S& U2) {
    QuadraticVolume::at(constants[1], dilation, U, U1, U2);
  }

  /// As NeoHookean::evaluate, but finite at every J.
  template <class S>
  static PALPATE_INLINE void evaluate(const S* constants, const S* H, double geometric_scale, S& J,
                                      S& W, S* P, S* A) {
    const S m = constants[0], l = constants[1];
    const GradientInvariants<S> in(H);
    const S dilation = in.trace + in.minors + in.determinant;
    J = dilation + 1.0;
    S squares = H[0] * H[0];
    for (int i = 1; i < 9; ++i) squares += H[i] * H[i];
    const S stretch = 2.0 * in.trace + squares;  // I1 - 3
    S log, log_less;
    log1p_of(S(stretch * 0.25), log, log_less);
    // The first-order terms have cancelled.
    W = m * (0.75 * (0.5 * squares - in.minors - in.determinant) - 0.5 * log_less) +
        l * 0.5 * (dilation * dilation);
    if (!P) return;

    S F[9], cofactor[9], cofactor_change[9];  // cof F = (1 + tr H) 1 - H^T + cof H
    cofactors_of(H, cofactor_change);
    for (int i = 0; i < 9; ++i) F[i] = H[i];
    for (int i = 0; i < 9; i += 4) {
      F[i] += 1.0;
      cofactor_change[i] += in.trace;
    }
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) cofactor_change[3 * i + j] -= H[3 * j + i];
    for (int i = 0; i < 9; ++i) cofactor[i] = cofactor_change[i];
    for (int i = 0; i < 9; i += 4) cofactor[i] += 1.0;
    const S inverse = (m * 0.0 + 1.0) / (stretch + 4.0);  // 1/(I1 + 1)
    const S softened = m * 0.25 * stretch * inverse;      // m (3/4 + this) multiplies F
    for (int i = 0; i < 9; ++i)
      P[i] = m * 0.75 * (H[i] - cofactor_change[i]) + softened * F[i] + l * dilation * cofactor[i];
    if (!A) return;

    const S geometric = (l * dilation - m * 0.75) * geometric_scale,
            along = 2.0 * m * (inverse * inverse);
    for (int a = 0; a < 9; ++a) {
      const int i = a / 3, K = a % 3;
      for (int b = a; b < 9; ++b) {
        const int k = b / 3, L = b % 3;
        S entry = along * (F[a] * F[b]) + l * (cofactor[a] * cofactor[b]);
        if (i != k && K != L) {  // second derivative of J: e_ikm e_KLn F_mn
          const bool is_even = ((k - i + 3) % 3 == 1) == ((L - K + 3) % 3 == 1);
          const S part = geometric * F[3 * (3 - i - k) + 3 - K - L];
          entry += is_even ? part : -part;
        }
        A[9 * a + b] = entry;
      }
      A[10 * a] += m * 0.75 + softened;
    }
  }
};

}  // namespace palpate::fem
