#include "libfem/materials/isochoric.hpp"
#include "libfem/materials/materials.hpp"
#include "libfem/materials/neo_hookean.hpp"
#include "libfem/materials/ogden.hpp"
#include "libfem/materials/pack_math.hpp"

namespace palpate::fem {
namespace {

constexpr const char* kEnergyFalls = ": the energy would fall without bound under large strain";

Refusal must_not_be_negative(std::string_view key, double value_Pa, const char* why) {
  if (!(value_Pa < 0)) return {};
  return {key, "must not be negative, not " + short_number(value_Pa) + " Pa" + why};
}

}  // namespace

/// Neo-Hookean law with shape and volume apart, W = mu/2 (I1 J^(-2/3) - 3) + K/2 (J - 1)^2.
/// constants: bulk modulus K, mu/2 [Pa].
/// Source: Simo, Taylor and Pister 1985, doi:10.1016/0045-7825(85)90033-7.
struct NeoHookeanIsochoric : IsochoricLaw<NeoHookeanIsochoric>, YoungPoissonLaw {
  static constexpr std::string_view kName = "neo-hookean-isochoric";
  static constexpr std::string_view kSummary =
      "W = mu/2 (I1 J^(-2/3) - 3) + K/2 (J - 1)^2; strains to about 50 %";

  using IsochoricLaw::small_strain;

  static LawConstants constants(std::span<const double> values) {
    const SmallStrain hooke = of_young_and_poisson(values);
    return {hooke.bulk_Pa(), hooke.mu_Pa / 2};
  }

  template <class S>
  static PALPATE_INLINE void shape(const S* constants, const S& x1, const S&, ShapeTerms<S>& out) {
    out.w = constants[1] * x1;
    out.w1 = constants[1];
    out.w11 = constants[1] * 0.0;
  }
};

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
    const Refusal refusal = first_refusal({must_not_be_negative("c10", values[0], kEnergyFalls),
                                           must_not_be_negative("c01", values[1], kEnergyFalls)});
    if (refusal.is_refused()) return refusal;
    if (!(values[0] + values[1] > 0))
      return {"c10", "and c01 must not both be zero: the shear modulus is 2 (c10 + c01)"};
    return refuse_compressibility(values[2], values[3]);
  }
  static LawConstants constants(std::span<const double> values) {
    return {bulk_modulus_Pa(2 * (values[0] + values[1]), values[2], values[3]), values[0],
            values[1]};
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
    const Refusal refusal = first_refusal(
        {must_be_positive("c10", c10, "Pa"), must_not_be_negative("c30", c30, kEnergyFalls)});
    if (refusal.is_refused()) return refusal;
    if (c20 < 0 && !(c20 * c20 < 3 * c10 * c30))
      return {"c20", "must be above -sqrt(3 c10 c30) = " + short_number(-std::sqrt(3 * c10 * c30)) +
                         " Pa, not " + short_number(c20) +
                         " Pa: the material would lose all stiffness at some strain"};
    return refuse_compressibility(values[3], values[4]);
  }
  static LawConstants constants(std::span<const double> values) {
    return {bulk_modulus_Pa(2 * values[0], values[3], values[4]), values[0], values[1], values[2]};
  }

  template <class S>
  static PALPATE_INLINE void shape(const S* constants, const S& x1, const S&, ShapeTerms<S>& out) {
    const S c10 = constants[1], c20 = constants[2], c30 = constants[3];
    out.w = x1 * (c10 + x1 * (c20 + x1 * c30));
    out.w1 = c10 + x1 * (2.0 * c20 + x1 * (3.0 * c30));
    out.w11 = 2.0 * c20 + x1 * (6.0 * c30);
  }
};

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
    const Refusal refusal = first_refusal({must_be_positive("shear", values[0], "Pa"),
                                           must_not_be_negative("k1", values[1], ""),
                                           must_be_positive("k2", values[2], "")});
    if (refusal.is_refused()) return refusal;
    if (!(length(values) > 0)) return {"fibre", "must have a direction, not be zero"};
    if (!(values[6] >= 0 && values[6] <= 1.0 / 3))
      return {"dispersion", "must lie between 0 and 1/3, not " + short_number(values[6])};
    return refuse_compressibility(values[7], values[8]);
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

namespace {

template <class Law>
LawPoint evaluate_at(const LawConstants& constants, const Mat3& F) {
  const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> H = F - Mat3::Identity();
  Eigen::Matrix<double, 3, 3, Eigen::RowMajor> P;
  Mat9 A;
  double J, W;
  Law::template evaluate<double>(constants.data(), H.data(), 1.0, J, W, P.data(), A.data());
  return {W, P, A.selfadjointView<Eigen::Upper>()};
}

template <class Law>
void volumetric_at(const LawConstants& constants, double dilation, double& U, double& U1,
                   double& U2) {
  Law::template volumetric<double>(constants.data(), dilation, U, U1, U2);
}

template <class Law>
constexpr LawRow law_row() {
  static_assert(Law::kConstants <= kMaxConstants);
  return {.name = Law::kName,
          .summary = Law::kSummary,
          .parameters = Law::kParameters,
          .constants_used = Law::kConstants,
          .refusal = Law::refusal,
          .constants = Law::constants,
          .small_strain = Law::small_strain,
          .evaluate = evaluate_at<Law>,
          .volumetric = volumetric_at<Law>,
          .kernels = &kElementKernels<Law>};
}

// The kernels of all laws are compiled here, which takes half a minute.
constexpr LawRow kLaws[] = {
    law_row<NeoHookean>(),
    law_row<NeoHookeanIsochoric>(),
    law_row<MooneyRivlin>(),
    law_row<Yeoh>(),
    law_row<Ogden>(),
    law_row<Fung>(),
    law_row<HolzapfelGasserOgden>(),
};

}  // namespace

std::span<const LawRow> material_laws() { return kLaws; }

}  // namespace palpate::fem
