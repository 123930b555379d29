#pragma once

#include "libfem/materials/isochoric.hpp"
#include "libfem/materials/law_types.hpp"
#include "libfem/materials/pack_math.hpp"

namespace palpate::fem {

/// Isotropic exponential law of Fung's type,
///   W = mu/(2 b) (exp(b (I1 J^(-2/3) - 3)) - 1) + K/2 (J - 1)^2.
/// constants: K, mu/(2 b) [Pa], b. Energy is +inf where the exponent exceeds kLargestExponent.
/// Source: Demiray 1972, doi:10.1016/0021-9290(72)90047-4; Fung, Biomechanics (1993), 7.
struct Fung : IsochoricLaw<Fung> {
  static constexpr std::string_view kName = "fung";
  static constexpr std::string_view kSummary =
      "W = mu/(2 b) (exp(b (I1 J^(-2/3) - 3)) - 1) + K/2 (J - 1)^2; stiffening tissue";
  static constexpr std::array<ParameterRow, 4> kParameters{
      {{"shear", "Pa", "shear modulus mu at small strain"},
       {"b", "", "exponent, positive: how fast it stiffens"},
       kPoissonRow,
       kBulkRow}};
  static constexpr int kConstants = 3;

  static Refusal refusal(std::span<const double> values) {
    return first_refusal({must_be_positive("shear", values[0], "Pa"),
                          must_be_positive("b", values[1], ""),
                          refuse_compressibility(values[2], values[3])});
  }
  static LawConstants constants(std::span<const double> values) {
    return {bulk_modulus_Pa(values[0], values[2], values[3]), values[0] / (2 * values[1]),
            values[1]};
  }
  static SmallStrain small_strain(const LawConstants& c) {
    return of_shear_and_bulk(2 * c[1] * c[2], c[0]);
  }

  template <class S>
  static PALPATE_INLINE void shape(const S* constants, const S& x1, const S&, ShapeTerms<S>& out) {
    const S factor = constants[1], b = constants[2];
    S energy, grown;
    bounded_expm1_of(S(b * x1), energy, grown);
    out.w = factor * energy;
    out.w1 = factor * b * (grown + 1.0);
    out.w11 = out.w1 * b;
  }
};

}  // namespace palpate::fem
