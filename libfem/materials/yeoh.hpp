#pragma once

#include "libfem/materials/isochoric.hpp"
#include "libfem/materials/law_types.hpp"

namespace palpate::fem {

/// Yeoh law W = C10 x + C20 x^2 + C30 x^3 + K/2 (J - 1)^2, x = I1 J^(-2/3) - 3.
/// constants: K, C10, C20, C30 [Pa].
/// Refused where dW/dx is not positive for every x >= 0: the material would soften to nothing.
/// Source: Yeoh 1993, doi:10.5254/1.3538343.
struct Yeoh : IsochoricLaw<Yeoh> {
  static constexpr std::string_view kName = "yeoh";
  static constexpr std::string_view kSummary =
      "W = C10 x + C20 x^2 + C30 x^3 + K/2 (J - 1)^2, x = I1 J^(-2/3) - 3; strains to about 200 %";
  static constexpr std::array<ParameterRow, 5> kParameters{
      {{"c10", "Pa", "coefficient of x, half the shear modulus"},
       {"c20", "Pa", "coefficient of x^2", 0.0},
       {"c30", "Pa", "coefficient of x^3, not negative", 0.0},
       kPoissonRow,
       kBulkRow}};
  static constexpr int kConstants = 4;

  static Refusal refusal(std::span<const double> values) {
    const double c10 = values[0], c20 = values[1], c30 = values[2];
    if (const Refusal refusal = must_be_positive("c10", c10, "Pa"); refusal.is_refused())
      return refusal;
    if (c30 < 0)
      return {"c30", "must not be negative, not " + short_number(c30) +
                         " Pa: the energy would fall without bound under large strain"};
    if (c20 < 0 && !(c20 * c20 < 3 * c10 * c30))
      return {"c20", "must be above -sqrt(3 c10 c30) = " + short_number(-std::sqrt(3 * c10 * c30)) +
                         " Pa, not " + short_number(c20) +
                         " Pa: the material would lose all stiffness at some strain"};
    return refuse_compressibility(values[3], values[4]);
  }
  static LawConstants constants(std::span<const double> values) {
    return {bulk_modulus_Pa(2 * values[0], values[3], values[4]), values[0], values[1], values[2]};
  }
  static SmallStrain small_strain(const LawConstants& c) {
    return of_shear_and_bulk(2 * c[1], c[0]);
  }

  template <class S>
  static PALPATE_INLINE void shape(const S* constants, const S& x1, const S&, ShapeTerms<S>& out) {
    const S c10 = constants[1], c20 = constants[2], c30 = constants[3];
    out.w = x1 * (c10 + x1 * (c20 + x1 * c30));
    out.w1 = c10 + x1 * (2.0 * c20 + x1 * (3.0 * c30));
    out.w11 = 2.0 * c20 + x1 * (6.0 * c30);
  }
};

}  // namespace palpate::fem
