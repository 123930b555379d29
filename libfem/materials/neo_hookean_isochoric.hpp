#pragma once

#include "libfem/materials/isochoric.hpp"
#include "libfem/materials/law_types.hpp"

namespace palpate::fem {

/// Neo-Hookean law with shape and volume apart, W = mu/2 (I1 J^(-2/3) - 3) + K/2 (J - 1)^2.
/// constants: bulk modulus K, mu/2 [Pa].
/// Source: Simo, Taylor and Pister 1985, doi:10.1016/0045-7825(85)90033-7.
struct NeoHookeanIsochoric : IsochoricLaw<NeoHookeanIsochoric>, YoungPoissonLaw {
  static constexpr std::string_view kName = "neo-hookean-isochoric";
  static constexpr std::string_view kSummary =
      "W = mu/2 (I1 J^(-2/3) - 3) + K/2 (J - 1)^2; strains to about 50 %";

  static LawConstants constants(std::span<const double> values) {
    const SmallStrain hooke = of_young_and_poisson(values);
    return {hooke.bulk_Pa(), hooke.mu_Pa / 2};
  }
  static SmallStrain small_strain(const LawConstants& c) {
    return of_shear_and_bulk(2 * c[1], c[0]);
  }

  template <class S>
  static PALPATE_INLINE void shape(const S* constants, const S& x1, const S&, ShapeTerms<S>& out) {
    out.w = constants[1] * x1;
    out.w1 = constants[1];
    out.w11 = constants[1] * 0.0;
  }
};

}  // namespace palpate::fem
