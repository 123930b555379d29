#pragma once

#include "libfem/materials/isochoric.hpp"
#include "libfem/materials/law_types.hpp"

namespace palpate::fem {

/// Mooney-Rivlin law W = C10 (I1 J^(-2/3) - 3) + C01 (I2 J^(-4/3) - 3) + K/2 (J - 1)^2.
/// constants: K, C10, C01 [Pa].
/// A negative C10 or C01 is refused: the energy would fall without bound in tension or in
/// equibiaxial tension.
/// Source: Rivlin 1948, doi:10.1098/rsta.1948.0024; Mooney 1940, doi:10.1063/1.1712836.
struct MooneyRivlin : IsochoricLaw<MooneyRivlin, Uses::first_and_second> {
  static constexpr std::string_view kName = "mooney-rivlin";
  static constexpr std::string_view kSummary =
      "W = C10 (I1 J^(-2/3) - 3) + C01 (I2 J^(-4/3) - 3) + K/2 (J - 1)^2; strains to about 100 %";
  static constexpr std::array<ParameterRow, 4> kParameters{
      {{"c10", "Pa", "coefficient of the first invariant, not negative"},
       {"c01", "Pa", "coefficient of the second invariant, not negative"},
       kPoissonRow,
       kBulkRow}};
  static constexpr int kConstants = 3;

  static Refusal refusal(std::span<const double> values) {
    for (const int i : {0, 1})
      if (values[i] < 0)
        return {kParameters[i].name,
                "must not be negative, not " + short_number(values[i]) +
                    " Pa: the energy would fall without bound under large strain"};
    if (!(values[0] + values[1] > 0))
      return {"c10", "and c01 must not both be zero: the shear modulus is 2 (c10 + c01)"};
    return refuse_compressibility(values[2], values[3]);
  }
  static LawConstants constants(std::span<const double> values) {
    return {bulk_modulus_Pa(2 * (values[0] + values[1]), values[2], values[3]), values[0],
            values[1]};
  }
  static SmallStrain small_strain(const LawConstants& c) {
    return of_shear_and_bulk(2 * (c[1] + c[2]), c[0]);
  }

  template <class S>
  static PALPATE_INLINE void shape(const S* constants, const S& x1, const S& x2,
                                   ShapeTerms<S>& out) {
    out.w = constants[1] * x1 + constants[2] * x2;
    out.w1 = constants[1];
    out.w2 = constants[2];
    out.w11 = out.w12 = out.w22 = constants[1] * 0.0;
  }
};

}  // namespace palpate::fem
