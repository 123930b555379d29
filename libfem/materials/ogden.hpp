#pragma once

#include <limits>

#include "libfem/materials/kinematics.hpp"
#include "libfem/materials/materials.hpp"

namespace palpate::fem {

// Eigenvalues and eigenvectors of symmetric 3 x 3 matrices, lane by lane with one sequence of
// steps.

namespace spectral {

/// Turns M (symmetric, full) by the Jacobi rotation that empties entry (p, q), and the columns of V
/// with it. A lane whose entry is negligible is left as it is, to the bit. Returns whether any lane
/// was turned.
template <int p, int q, class S>
PALPATE_INLINE bool rotate(const S& negligible_squared, S* M, S* V) {
  constexpr int r = 3 - p - q;
  const S zero = M[0] * 0.0, one = zero + 1.0;
  const S off = M[3 * p + q];
  const S turned = off * off > negligible_squared ? one : zero;
  if (!is_any_nonzero(turned)) return false;
  const S gap = M[4 * q] - M[4 * p];
  const S size = gap < 0.0 ? -gap : gap;
  S root, inverse_c;
  sqrt_of(S(gap * gap + 4.0 * (off * off)), root);
  const S below = size + root;
  S t = 2.0 * off / (below > 0.0 ? below : one);
  t = gap < 0.0 ? -t : t;
  t = turned > 0.0 ? t : zero;
  sqrt_of(S(t * t + 1.0), inverse_c);
  const S c = one / inverse_c, s = t * c;
  M[4 * p] -= t * off;
  M[4 * q] += t * off;
  M[3 * p + q] = M[3 * q + p] = turned > 0.0 ? zero : off;
  const S rp = M[3 * r + p], rq = M[3 * r + q];
  M[3 * r + p] = M[3 * p + r] = c * rp - s * rq;
  M[3 * r + q] = M[3 * q + r] = s * rp + c * rq;
  for (int i = 0; i < 3; ++i) {
    const S vp = V[3 * i + p], vq = V[3 * i + q];
    V[3 * i + p] = c * vp - s * vq;
    V[3 * i + q] = s * vp + c * vq;
  }
  return true;
}

}  // namespace spectral

/// Eigenvalues (in no order) and orthonormal eigenvectors (columns of `vectors`, 9 scalars row
/// major) of a symmetric matrix, to rounding of its norm; repeated eigenvalues are no special case.
/// Cyclic Jacobi: it has converged after five sweeps at most, six are allowed.
/// Source: Golub and Van Loan, Matrix Computations (2013), 8.5.
template <class S>
PALPATE_INLINE void eigen_of(const S* symmetric, S* values, S* vectors) {
  const S zero = symmetric[0] * 0.0;
  S M[9];
  S squares = zero;
  for (int i = 0; i < 9; ++i) {
    M[i] = symmetric[i];
    squares += M[i] * M[i];
    vectors[i] = zero;
  }
  for (int i = 0; i < 9; i += 4) vectors[i] += 1.0;
  const S negligible = squares * 1e-36;
  for (int sweep = 0; sweep < 6; ++sweep) {
    bool is_turned = spectral::rotate<0, 1>(negligible, M, vectors);
    is_turned |= spectral::rotate<0, 2>(negligible, M, vectors);
    is_turned |= spectral::rotate<1, 2>(negligible, M, vectors);
    if (!is_turned) break;
  }
  for (int a = 0; a < 3; ++a) values[a] = M[4 * a];
}

/// Ogden law of one to three terms in the isochoric principal stretches l_a J^(-1/3),
///   W = sum_p mu_p/alpha_p (sum_a (l_a J^(-1/3))^alpha_p - 3) + K/2 (J - 1)^2.
/// Shear modulus 1/2 sum mu_p alpha_p. (Other programs write 2 mu/alpha^2: their mu times 2/alpha
/// is this one's.) Each product mu_p alpha_p must be positive: then every term is stable by itself.
/// constants: K, then mu_p/alpha_p [Pa] and alpha_p for three terms, 0 for one left out.
/// Written in logarithmic stretches; differences of principal stresses over differences of
/// stretches are evaluated as quotients of exp(x) - 1, which stay exact when stretches agree. Exact
/// while no more than one stretch is tiny: where the middle one is below 1/1000 of the greatest,
/// digits are lost (relative error about 1e-16 times the square of their ratio), but all stays
/// finite. geometric_scale: scales what makes principal blocks of the tangent indefinite,
/// compressive curvature and tension softening; 1 is exact, 0 positive semidefinite everywhere.
/// Source: Ogden 1972, doi:10.1098/rspa.1972.0026; Simo and Taylor 1991,
/// doi:10.1016/0045-7825(91)90100-K.
struct Ogden {
  static constexpr std::string_view kName = "ogden";
  static constexpr std::string_view kSummary =
      "W = sum mu_p/alpha_p (sum of isochoric stretches^alpha_p - 3) + K/2 (J - 1)^2, 1 to 3 "
      "terms; "
      "strains to about 200 %";
  static constexpr int kTerms = 3;
  static constexpr std::array<ParameterRow, 8> kParameters{
      {{"mu1", "Pa", "coefficient of the first term, of the sign of alpha1"},
       {"alpha1", "", "exponent of the first term, not zero"},
       {"mu2", "Pa", "coefficient of the second term, of the sign of alpha2", kAbsent},
       {"alpha2", "", "exponent of the second term, not zero", kAbsent},
       {"mu3", "Pa", "coefficient of the third term, of the sign of alpha3", kAbsent},
       {"alpha3", "", "exponent of the third term, not zero", kAbsent},
       kPoissonRow,
       kBulkRow}};
  static constexpr int kConstants = 1 + 2 * kTerms;

  static Refusal refusal(std::span<const double> values) {
    for (int p = 0; p < kTerms; ++p) {
      const double mu = values[2 * p], alpha = values[2 * p + 1];
      const std::string_view mu_key = kParameters[2 * p].name,
                             alpha_key = kParameters[2 * p + 1].name;
      if (std::isnan(mu) && std::isnan(alpha)) continue;
      if (std::isnan(mu)) return {mu_key, "is missing beside " + std::string(alpha_key)};
      if (std::isnan(alpha)) return {alpha_key, "is missing beside " + std::string(mu_key)};
      if (!(std::abs(alpha) <= 50))
        return {alpha_key, "must lie between -50 and 50, not " + short_number(alpha)};
      if (!(mu * alpha > 0))
        return {mu_key, "times " + std::string(alpha_key) + " must be positive, not " +
                            short_number(mu * alpha) + " Pa: the term would be unstable"};
    }
    return refuse_compressibility(values[2 * kTerms], values[2 * kTerms + 1]);
  }

  static LawConstants constants(std::span<const double> values) {
    LawConstants out{};
    double shear = 0;
    for (int p = 0; p < kTerms; ++p) {
      const double mu = values[2 * p], alpha = values[2 * p + 1];
      if (std::isnan(mu)) continue;
      out[1 + 2 * p] = mu / alpha;
      out[2 + 2 * p] = alpha;
      shear += mu * alpha / 2;
    }
    out[0] = bulk_modulus_Pa(shear, values[2 * kTerms], values[2 * kTerms + 1]);
    return out;
  }

  static SmallStrain small_strain(const LawConstants& c) {
    double shear = 0;
    for (int p = 0; p < kTerms; ++p) shear += c[1 + 2 * p] * c[2 + 2 * p] * c[2 + 2 * p] / 2;
    return of_shear_and_bulk(shear, c[0]);
  }

  template <class S>
  static PALPATE_INLINE void volumetric(const S* constants, const S& dilation, S& U, S& U1, S& U2) {
    quadratic_volume(constants[0], dilation, U, U1, U2);
  }

  /// As NeoHookean::evaluate.
  template <class S>
  static PALPATE_INLINE void evaluate(const S* constants, const S* H, double geometric_scale, S& J,
                                      S& W, S* P, S* A) {
    const SoundState<S> state(H);
    J = state.J;
    Stretches<S> at;
    at.evaluate(ShapeState<S>(state.H, state.J_sound));
    S U, U1, U2;
    volumetric(constants, state.dilation, U, U1, U2);
    PrincipalResponse<S> response;
    response.evaluate(constants, at, A != nullptr);
    W = J > 0.0 ? response.w + U : J * 0.0 + std::numeric_limits<double>::infinity();
    if (!P) return;

    // Deformed principal directions: F N_a = l_a n_a.
    S n[9], inverse[3];
    product_of(state.F, at.N, n);
    const S one = J * 0.0 + 1.0;
    for (int a = 0; a < 3; ++a) {
      inverse[a] = one / at.stretch[a];
      for (int i = 0; i < 3; ++i) n[3 * i + a] *= inverse[a];
    }
    const S pressure_part = state.J_sound * U1;
    for (S& b : response.beta) b += pressure_part;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        P[3 * i + j] = response.beta[0] * inverse[0] * n[3 * i] * at.N[3 * j];
        for (int a = 1; a < 3; ++a)
          P[3 * i + j] += response.beta[a] * inverse[a] * n[3 * i + a] * at.N[3 * j + a];
      }
    if (!A) return;

    const S zero = J * 0.0;
    const S stiff_part = state.J_sound * state.J_sound * U2 +
                         (pressure_part < 0.0 ? pressure_part * geometric_scale : pressure_part);
    for (int i = 0; i < 81; ++i) A[i] = zero;
    add_normal_block(response, stiff_part, geometric_scale, inverse, n, at.N, A);
    add_shear_block<0, 1>(response, geometric_scale, at, inverse, n, A);
    add_shear_block<0, 2>(response, geometric_scale, at, inverse, n, A);
    add_shear_block<1, 2>(response, geometric_scale, at, inverse, n, A);
  }

 private:
  /// Principal directions at rest N (columns), stretches, their squares, and logarithms of the
  /// isochoric stretches (sum 0).
  template <class S>
  struct Stretches {
    S N[9], stretch[3], squared[3], log[3];

    PALPATE_INLINE void evaluate(const ShapeState<S>& shape) {
      S less_one[3], value[3], kept[3];
      eigen_of(shape.d, less_one, N);
      for (int a = 0; a < 3; ++a) {
        value[a] = less_one[a] + 1.0;
        value[a] = value[a] > kFloor ? value[a] : value[a] * 0.0 + kFloor;
      }
      // The least one follows from the determinant where it is but a rest of rounding.
      for (int a = 0; a < 3; ++a) {
        const S b = value[(a + 1) % 3], c = value[(a + 2) % 3];
        const S from_det = shape.det / (b * c);
        const S least = b < c ? b : c;
        kept[a] = value[a] > 0.25 ? value[a] : (value[a] > least ? value[a] : from_det);
      }
      S mean = value[0] * 0.0, log_less;
      for (int a = 0; a < 3; ++a) {
        squared[a] = shape.scale * kept[a];
        sqrt_of(squared[a], stretch[a]);
        log_of(less_one[a], kept[a], log[a], log_less);
        mean += log[a] * (1.0 / 3);
      }
      for (S& l : log) l = 0.5 * (l - mean);
    }

   private:
    static constexpr double kFloor = 1e-14;
  };

  /// Energy of shape; beta: its derivatives by the logarithmic stretches (principal Kirchhoff
  /// stresses); stiffness: the derivatives of those; quotient: (beta_a - beta_b) / (l_a^2 - l_b^2)
  /// of the pairs 01, 02, 12.
  template <class S>
  struct PrincipalResponse {
    S w, beta[3], stiffness[9], quotient[3];

    PALPATE_INLINE void evaluate(const S* constants, const Stretches<S>& at, bool with_tangent) {
      const S zero = constants[0] * 0.0;
      w = zero;
      for (S& b : beta) b = zero;
      for (S& k : stiffness) k = zero;
      for (S& q : quotient) q = zero;
      S gap[3], gap_squared[3];
      for (int pair = 0; pair < 3; ++pair) {
        gap[pair] = at.log[first(pair)] - at.log[second(pair)];
        if (with_tangent) expm1_of(S(2.0 * gap[pair]), gap_squared[pair]);
      }
      for (int p = 0; p < kTerms; ++p) {
        const S factor = constants[1 + 2 * p], alpha = constants[2 + 2 * p];
        if (!is_any_nonzero(factor)) continue;
        const S mu = factor * alpha;
        S change[3], less;
        for (int a = 0; a < 3; ++a) {
          expm1_of(S(alpha * at.log[a]), change[a], less);
          w += factor * less;
        }
        const S mean = (change[0] + change[1] + change[2]) * (1.0 / 3);
        for (int a = 0; a < 3; ++a) beta[a] += mu * (change[a] - mean);
        if (!with_tangent) continue;
        add_stiffness(S(mu * alpha), change, mean);
        for (int pair = 0; pair < 3; ++pair) {
          S grown;
          expm1_of(S(alpha * gap[pair]), grown);
          const S ratio = gap[pair] == 0.0 ? alpha * 0.5 : grown / gap_squared[pair];
          const int b = second(pair);
          quotient[pair] += mu * (change[b] + 1.0) * ratio / at.squared[b];
        }
      }
    }

   private:
    static constexpr int first(int pair) { return pair == 2 ? 1 : 0; }
    static constexpr int second(int pair) { return pair == 0 ? 1 : 2; }

    PALPATE_INLINE void add_stiffness(const S& modulus, const S* change, const S& mean) {
      for (int a = 0; a < 3; ++a) {
        for (int b = 0; b < 3; ++b)
          stiffness[3 * a + b] -= modulus * (1.0 / 3) * (change[a] + change[b] - mean + 1.0);
        stiffness[4 * a] += modulus * (change[a] + 1.0);
      }
    }
  };

  /// Stretching along the principal directions: sum_ab (dbeta_a/dlog l_b - beta_a [a = b])
  /// / (l_a l_b) (n_a N_a) (n_b N_b).
  template <class S>
  static PALPATE_INLINE void add_normal_block(const PrincipalResponse<S>& response,
                                              const S& stiff_part, double geometric_scale,
                                              const S* inverse, const S* n, const S* N, S* A) {
    for (int a = 0; a < 3; ++a) {
      S row[9];
      for (int i = 0; i < 9; ++i) row[i] = stiff_part * 0.0;
      for (int b = 0; b < 3; ++b) {
        S entry = response.stiffness[3 * a + b] + stiff_part;
        if (a == b)
          entry -= response.beta[a] > 0.0 ? response.beta[a] * geometric_scale : response.beta[a];
        entry *= inverse[a] * inverse[b];
        for (int i = 0; i < 9; ++i) row[i] += entry * (n[i / 3 * 3 + b] * N[i % 3 * 3 + b]);
      }
      for (int i = 0; i < 9; ++i) {
        const S left = n[i / 3 * 3 + a] * N[i % 3 * 3 + a];
        for (int j = i; j < 9; ++j) A[9 * i + j] += left * row[j];
      }
    }
  }

  /// Shearing and turning in the plane of two principal directions.
  template <int a, int b, class S>
  static PALPATE_INLINE void add_shear_block(const PrincipalResponse<S>& response,
                                             double geometric_scale, const Stretches<S>& at,
                                             const S* inverse, const S* n, S* A) {
    const S quotient = response.quotient[a + b - 1];
    S cross = 0.5 *
              (quotient * (at.squared[a] + at.squared[b]) - response.beta[a] - response.beta[b]) *
              (inverse[a] * inverse[b]);
    S bounded = cross < quotient ? cross : quotient;
    bounded = bounded > -quotient ? bounded : -quotient;
    cross = bounded + geometric_scale * (cross - bounded);
    S ab[9], ba[9];
    for (int i = 0; i < 9; ++i) {
      ab[i] = n[i / 3 * 3 + a] * at.N[i % 3 * 3 + b];
      ba[i] = n[i / 3 * 3 + b] * at.N[i % 3 * 3 + a];
    }
    for (int i = 0; i < 9; ++i) {
      const S left = quotient * ab[i] + cross * ba[i], right = cross * ab[i] + quotient * ba[i];
      for (int j = i; j < 9; ++j) A[9 * i + j] += left * ab[j] + right * ba[j];
    }
  }
};

}  // namespace palpate::fem
