#pragma once

#include <array>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "libfem/materials/element_kernel.hpp"
#include "libfit/core/body.hpp"
#include "libfit/core/geometry.hpp"
#include "libfit/core/text.hpp"

namespace palpate::fem {

/// Constants as a law's kernel reads them; a law uses the first few.
inline constexpr int kMaxConstants = 8;
using LawConstants = std::array<double, kMaxConstants>;

/// The law's isotropic limit at small strains: shear modulus and Lame's first constant.
struct SmallStrain {
  double mu_Pa = 0;
  double lambda_Pa = 0;

  double bulk_Pa() const { return lambda_Pa + 2 * mu_Pa / 3; }
  double young_Pa() const { return mu_Pa * (3 * lambda_Pa + 2 * mu_Pa) / (lambda_Pa + mu_Pa); }
  double poisson() const { return lambda_Pa / (2 * (lambda_Pa + mu_Pa)); }
};

/// Values of ParameterRow::fallback: the key must be given; or it may be left out, and the law sees
/// NaN in its place.
inline constexpr double kRequired = std::numeric_limits<double>::infinity();
inline constexpr double kAbsent = std::numeric_limits<double>::quiet_NaN();

/// A key of [material] in a scene.
/// unit: "" for plain numbers. fallback: the value of a key left out, or kRequired, or kAbsent.
/// count: how many numbers the key holds (a list when more than 1). instead_of: a key that must not
/// be given beside this one.
struct ParameterRow {
  std::string_view name, unit, summary;
  double fallback = kRequired;
  int count = 1;
  std::string_view instead_of = {};
};

/// Why a material's values cannot be used: the key at fault and "must be ...". Empty text: they
/// can.
struct Refusal {
  std::string_view key;
  std::string text;

  bool is_refused() const { return !text.empty(); }
};

// Parameters that several laws share, and their checks.

inline constexpr ParameterRow kYoungRow{"young", "Pa", "Young's modulus at small strain"};
inline constexpr ParameterRow kPoissonRow{"poisson", "",
                                          "Poisson's ratio at small strain, above -1 and below 0.5 "
                                          "(nearly incompressible tissue: 0.45 to "
                                          "0.4999)",
                                          0.45};
inline constexpr ParameterRow kBulkRow{
    "bulk", "Pa", "bulk modulus at small strain, instead of poisson", kAbsent, 1, "poisson"};

inline constexpr std::array<ParameterRow, 2> kYoungPoisson{kYoungRow, kPoissonRow};

inline std::string short_number(double value) { return number(value, 6); }

inline Refusal must_be_positive(std::string_view key, double value, std::string_view unit) {
  if (value > 0) return {};
  return {key, "must be positive, not " + short_number(value) + (unit.empty() ? "" : " ") +
                   std::string(unit)};
}

/// The first of some refusals that refuses.
inline Refusal first_refusal(std::initializer_list<Refusal> refusals) {
  for (const Refusal& refusal : refusals)
    if (refusal.is_refused()) return refusal;
  return {};
}

inline Refusal refuse_poisson(double poisson) {
  if (poisson > -1 && poisson < 0.5) return {};
  return {"poisson", "must lie above -1 and below 0.5, not " + short_number(poisson)};
}

/// Of the pair poisson and bulk, of which bulk counts when it is given.
inline Refusal refuse_compressibility(double poisson, double bulk_Pa) {
  return std::isnan(bulk_Pa) ? refuse_poisson(poisson) : must_be_positive("bulk", bulk_Pa, "Pa");
}

/// Bulk modulus [Pa] of a material with shear modulus mu at small strain.
inline double bulk_modulus_Pa(double mu_Pa, double poisson, double bulk_Pa) {
  return std::isnan(bulk_Pa) ? 2 * mu_Pa * (1 + poisson) / (3 * (1 - 2 * poisson)) : bulk_Pa;
}

inline SmallStrain of_shear_and_bulk(double mu_Pa, double bulk_Pa) {
  return {mu_Pa, bulk_Pa - 2 * mu_Pa / 3};
}

inline SmallStrain of_young_and_poisson(std::span<const double> values) {
  const double young = values[0], poisson = values[1];
  return {young / (2 * (1 + poisson)), young * poisson / ((1 + poisson) * (1 - 2 * poisson))};
}

/// The part that laws of Young's modulus and Poisson's ratio have in common. constants: mu, lambda
/// [Pa], unless the law has others.
struct YoungPoissonLaw {
  static constexpr std::span<const ParameterRow> kParameters = kYoungPoisson;
  static constexpr int kConstants = 2;

  static Refusal refusal(std::span<const double> values) {
    return first_refusal({must_be_positive("young", values[0], "Pa"), refuse_poisson(values[1])});
  }
  static LawConstants constants(std::span<const double> values) {
    const SmallStrain hooke = of_young_and_poisson(values);
    return {hooke.mu_Pa, hooke.lambda_Pa};
  }
  static SmallStrain small_strain(const LawConstants& c) { return {c[0], c[1]}; }
};

using Mat9 = Eigen::Matrix<double, 9, 9, Eigen::RowMajor>;

constexpr double kMaxSoftening = 1000;

/// Softening of a material (M54a): a pseudo-elastic law after Ogden and Roxburgh 1999,
/// doi:10.1098/rspa.1999.0431. r 0: it does not.
struct Softening {
  double r = 0;         ///< >= 1: most of the stress that unloading loses is 1/r of it
  double scale_Pa = 0;  ///< m
  double beta = 0;

  bool is_any() const { return r != 0; }
};

/// The material a scene names. values: of the law's parameter rows in their order, SI, a row of
/// count 3 being three of them; values of rows that have a fallback may be left out from the end.
/// relaxation: of the law's shape part W - U (M14a); the values are those of slow motion.
/// softening: of the same part; the values are those of first loading.
struct MaterialParameters {
  std::string law = "neo-hookean";
  std::vector<double> values;
  Relaxation relaxation = {};
  Softening softening = {};
};

/// A law at one deformation gradient F. W: stored energy per rest volume [Pa], +inf where det F <=
/// 0. P = dW/dF [Pa]. A = dP/dF [Pa], rows and columns are entries of F, row major.
struct LawPoint {
  double W;
  Mat3 P;
  Mat9 A;
};

/// A material law: its name, its parameters and its evaluation.
/// refusal: why the values (all of them) cannot be used, if so. volumetric: the part U(J) of W that
/// carries the bulk modulus and its first two derivatives by J [Pa], from J - 1.
struct LawRow {
  std::string_view name, summary;
  std::span<const ParameterRow> parameters;
  int constants_used;
  Refusal (*refusal)(std::span<const double> values);
  LawConstants (*constants)(std::span<const double> values);
  SmallStrain (*small_strain)(const LawConstants&);
  LawPoint (*evaluate)(const LawConstants&, const Mat3& F);
  void (*volumetric)(const LawConstants&, double dilation, double& U, double& U1, double& U2);
  const ElementKernels* kernels;
};

/// Every law there is.
std::span<const LawRow> material_laws();

/// The law's row. Throws Error at `where` naming the known laws.
const LawRow& find_law(std::string_view name, const std::string& where);

/// A material ready for evaluation.
struct Material {
  const LawRow* law = nullptr;
  LawConstants constants{};
  Relaxation relaxation = {};
  Softening softening = {};
};

/// The row of the parameter that `key` names; nullptr when the law has none such.
const ParameterRow* find_parameter(const LawRow& law, std::string_view key);

/// Indices of the values that are moduli [Pa] and given: a law is linear in all of them together.
std::vector<std::size_t> moduli_of(const MaterialParameters& parameters);

double sum_of_moduli(const MaterialParameters& parameters);

/// Shear modulus at first over that of slow motion: 1 + sum_k g_k.
inline double instantaneous_stiffness(const Relaxation& relaxation) {
  return 1 + relaxation.share.sum();
}

/// Why a material cannot relax or soften as it says, if so.
Refusal refuse_relaxation(const Relaxation& relaxation);
Refusal refuse_softening(const MaterialParameters& material);
inline constexpr const char* kRelaxationRemedy =
    "Give relaxation = [[g, \"tau\"], ...]: shares of the long-term shear modulus and times.";
inline constexpr const char* kSofteningRemedy =
    "Give softening = { r = 1.5, m = \"200 Pa\", beta = 0.1 }, or { } for none.";

/// Looks the law up, fills in values left out and checks them. Throws Error at `where` (the scene's
/// place) when the law is unknown, a value is missing or not finite, or the material would not be
/// stable, in slow motion or in fast.
Material make_material(const MaterialParameters& parameters, const std::string& where);

}  // namespace palpate::fem
