#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "libfem/materials/element_kernel.hpp"
#include "libfem/materials/law_types.hpp"
#include "libfit/core/body.hpp"
#include "libfit/core/geometry.hpp"

namespace palpate::fem {

using Mat9 = Eigen::Matrix<double, 9, 9, Eigen::RowMajor>;

constexpr double kMaxSoftening = 1000;

/// How a material softens (M54a): a pseudo-elastic law after Ogden and Roxburgh 1999,
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
