#pragma once

#include "libfem/materials/isochoric.hpp"
#include "libfem/materials/law_types.hpp"
#include "libfem/materials/pack_math.hpp"

namespace palpate::fem {

/// One family of fibres that bear tension only, in a neo-Hookean matrix:
///   W = mu/2 x1 + k1/(2 k2) (exp(k2 <E>^2) - 1) + K/2 (J - 1)^2,
///   E = kappa x1 + (1 - 3 kappa) (a.C a - 1),  x1 = I1 J^(-2/3) - 3,  <E> = E where positive, else
///   0.
/// a: fibre direction at rest, in the body's frame. kappa: dispersion, 0 (all along a) to 1/3 (none
/// preferred). constants: K, mu, k1/(2 k2) [Pa], k2, kappa, a.
/// The fibre's stretch is the whole one, not its isochoric part: with that, a slightly compressible
/// body pulled along its fibres would swell instead of stretching them (Nolan et al. 2014,
/// doi:10.1016/j.jmbbm.2014.06.016). In the incompressible limit both agree.
/// At rest the tangent jumps: small_strain and the tangent at E = 0 are the matrix's; pulled along
/// a, the fibres add 4 k1 (1 - 3 kappa)^2 to the modulus. Energy is +inf where k2 E^2 exceeds
/// kLargestExponent.
/// Source: Gasser, Ogden and Holzapfel 2006, doi:10.1098/rsif.2005.0073.
struct HolzapfelGasserOgden : IsochoricLaw<HolzapfelGasserOgden, Uses::first_and_fibre> {
  static constexpr std::string_view kName = "holzapfel-gasser-ogden";
  static constexpr std::string_view kSummary =
      "W = mu/2 x1 + k1/(2 k2) (exp(k2 <E>^2) - 1) + K/2 (J - 1)^2; one family of fibres";
  static constexpr std::array<ParameterRow, 7> kParameters{
      {{"shear", "Pa", "shear modulus mu of the matrix"},
       {"k1", "Pa", "stiffness of the fibres, not negative"},
       {"k2", "", "exponent of the fibres, positive"},
       {"fibre", "", "direction of the fibres at rest, three numbers of any length", kRequired, 3},
       {"dispersion", "", "kappa, 0 for aligned fibres to 1/3 for none preferred", 0.0},
       kPoissonRow,
       kBulkRow}};
  static constexpr int kConstants = 8;

  static Refusal refusal(std::span<const double> values) {
    const auto refuse_if = [](bool is_refused, std::string_view key, const std::string& text) {
      return is_refused ? Refusal{key, text} : Refusal{};
    };
    return first_refusal(
        {must_be_positive("shear", values[0], "Pa"),
         refuse_if(values[1] < 0, "k1",
                   "must not be negative, not " + short_number(values[1]) + " Pa"),
         must_be_positive("k2", values[2], ""),
         refuse_if(!(length(values) > 0), "fibre", "must have a direction, not be zero"),
         refuse_if(!(values[6] >= 0 && values[6] <= 1.0 / 3), "dispersion",
                   "must lie between 0 and 1/3, not " + short_number(values[6])),
         refuse_compressibility(values[7], values[8])});
  }
  static LawConstants constants(std::span<const double> values) {
    const double size = length(values);
    return {bulk_modulus_Pa(values[0], values[7], values[8]),
            values[0],
            values[1] / (2 * values[2]),
            values[2],
            values[6],
            values[3] / size,
            values[4] / size,
            values[5] / size};
  }
  static SmallStrain small_strain(const LawConstants& c) { return of_shear_and_bulk(c[1], c[0]); }

  template <class S>
  static PALPATE_INLINE void shape(const S* constants, const S& x1, const S& x4,
                                   ShapeTerms<S>& out) {
    const S zero = x1 * 0.0;
    const S factor = constants[2], k2 = constants[3], kappa = constants[4];
    const S along = 1.0 - 3.0 * kappa;
    const S E = kappa * x1 + along * x4;
    const S pulled = E > 0.0 ? E : zero;
    S energy, grown;
    bounded_expm1_of(S(k2 * pulled * pulled), energy, grown);
    // f(E) = factor (exp(k2 E^2) - 1)
    const S f1 = 2.0 * factor * k2 * pulled * (grown + 1.0);
    const S stiff = 2.0 * factor * k2 * (grown + 1.0) * (1.0 + 2.0 * k2 * pulled * pulled);
    const S f2 = E > 0.0 ? stiff : zero;
    out.w = 0.5 * constants[1] * x1 + factor * energy;
    out.w1 = 0.5 * constants[1] + f1 * kappa;
    out.w2 = f1 * along;
    out.w11 = f2 * kappa * kappa;
    out.w12 = f2 * kappa * along;
    out.w22 = f2 * along * along;
  }

 private:
  static double length(std::span<const double> values) {
    return std::hypot(values[3], values[4], values[5]);
  }
};

}  // namespace palpate::fem
