#pragma once

#include "libfem/materials/isochoric.hpp"
#include "libfem/materials/law_types.hpp"
#include "libfem/materials/pack_math.hpp"

namespace palpate::fem {

/// Veronda-Westmann law of skin,
///   W = C1 (exp(C2 x1) - 1) - C1 C2/2 x2 + K/2 (J - 1)^2, x1 = I1 J^(-2/3) - 3, x2 = I2 J^(-4/3)
///   - 3.
/// constants: K, C1 [Pa], C2. Shear modulus C1 C2. Energy is +inf where C2 x1 exceeds
/// kLargestExponent.
/// C2 below 0.36 is refused: the Baker-Ericksen inequality exp(C2 x1) > l^2/2 (greater stress along
/// greater stretch, l the stretch across) needs C2 > 0.35753, where it is tightest, at l = 1.83.
/// Source: Veronda and Westmann 1970, doi:10.1016/0021-9290(70)90055-2.
struct VerondaWestmann : IsochoricLaw<VerondaWestmann, Uses::first_and_second> {
  static constexpr std::string_view kName = "veronda-westmann";
  static constexpr std::string_view kSummary =
      "W = C1 (exp(C2 x1) - 1) - C1 C2/2 x2 + K/2 (J - 1)^2; skin and other stiffening tissue";
  static constexpr double kMinC2 = 0.36;
  static constexpr std::array<ParameterRow, 4> kParameters{
      {{"c1", "Pa", "factor of the exponential; c1 times c2 is the shear modulus"},
       {"c2", "", "exponent, at least 0.36"},
       kPoissonRow,
       kBulkRow}};
  static constexpr int kConstants = 3;

  static Refusal refusal(std::span<const double> values) {
    if (const Refusal refusal = must_be_positive("c1", values[0], "Pa"); refusal.is_refused())
      return refusal;
    if (!(values[1] >= kMinC2))
      return {"c2", "must be at least " + short_number(kMinC2) + ", not " +
                        short_number(values[1]) +
                        ": the material would be unstable at some strain"};
    return refuse_compressibility(values[2], values[3]);
  }
  static LawConstants constants(std::span<const double> values) {
    return {bulk_modulus_Pa(values[0] * values[1], values[2], values[3]), values[0], values[1]};
  }
  static SmallStrain small_strain(const LawConstants& c) {
    return of_shear_and_bulk(c[1] * c[2], c[0]);
  }

  template <class S>
  static PALPATE_INLINE void shape(const S* constants, const S& x1, const S& x2,
                                   ShapeTerms<S>& out) {
    const S c1 = constants[1], c2 = constants[2];
    S energy, grown;
    bounded_expm1_of(S(c2 * x1), energy, grown);
    out.w2 = c1 * c2 * -0.5;
    out.w = c1 * energy + out.w2 * x2;
    out.w1 = c1 * c2 * (grown + 1.0);
    out.w11 = out.w1 * c2;
    out.w12 = out.w22 = c1 * 0.0;
  }
};

}  // namespace palpate::fem
