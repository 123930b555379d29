#pragma once

#include <limits>

#include "libfem/materials/isochoric.hpp"
#include "libfem/materials/law_types.hpp"

namespace palpate::fem {

/// Gent law W = -mu Jm/2 ln(1 - x/Jm) + K/2 (J - 1)^2, x = I1 J^(-2/3) - 3 below Jm; +inf from Jm
/// on, where chains are straight. constants: K, mu Jm/2 [Pa], 1/Jm. Source: Gent
/// 1996, doi:10.5254/1.3538357.
struct Gent : IsochoricLaw<Gent, QuadraticVolume> {
  static constexpr std::string_view kName = "gent";
  static constexpr std::string_view kSummary =
      "W = -mu Jm/2 ln(1 - x/Jm) + K/2 (J - 1)^2, x = I1 J^(-2/3) - 3; strains to where x is Jm";
  static constexpr std::array<ParameterRow, 4> kParameters{
      {{"shear", "Pa", "shear modulus at small strain"},
       {"limit", "", "Jm, the value of x at which chains are straight"},
       kPoissonRow,
       kBulkRow}};
  static constexpr int kConstants = 3;
  static constexpr double kNearest = 1 - 1e-6;  // of x to Jm, for derivatives

  static Refusal refusal(std::span<const double> values) {
    if (const Refusal r = must_be_positive("shear", values[0], "Pa"); r.is_refused()) return r;
    if (const Refusal r = must_be_positive("limit", values[1], ""); r.is_refused()) return r;
    return refuse_compressibility(values[2], values[3]);
  }
  static LawConstants constants(std::span<const double> values) {
    return {bulk_modulus_Pa(values[0], values[2], values[3]), values[0] * values[1] / 2,
            1 / values[1]};
  }
  static SmallStrain small_strain(const LawConstants& c) {
    return of_shear_and_bulk(2 * c[1] * c[2], c[0]);
  }

  template <class S>
  static PALPATE_INLINE void shape(const S* constants, const S& x1, const S&, ShapeTerms<S>& out) {
    const S factor = constants[1], inverse = constants[2];
    const S share = x1 * inverse, bound = x1 * 0.0 + kNearest;
    const S used = share < bound ? share : bound;
    S log;
    log1p_of(S(-used), log);
    const S infinite = x1 * 0.0 + std::numeric_limits<double>::infinity();
    out.w = share < bound ? -(factor * log) : infinite;
    out.w1 = factor * inverse / (1.0 - used);
    out.w11 = out.w1 * inverse / (1.0 - used);
  }
};

}  // namespace palpate::fem
