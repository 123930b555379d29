#pragma once

#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "libfem/materials/element_kernel.hpp"
#include "libfit/core/geometry.hpp"

namespace palpate::fem {

using Mat9 = Eigen::Matrix<double, 9, 9, Eigen::RowMajor>;

/// The material a scene names. values: in the order of the law's parameter rows, SI.
struct MaterialParameters {
  std::string law = "neo-hookean";
  std::vector<double> values;
};

/// Constants as a law's kernel reads them; a law uses the first few.
inline constexpr int kMaxConstants = 8;
using LawConstants = std::array<double, kMaxConstants>;

/// The law's limit at small strains: shear modulus and Lame's first constant.
struct SmallStrain {
  double mu_Pa = 0;
  double lambda_Pa = 0;

  double young_Pa() const { return mu_Pa * (3 * lambda_Pa + 2 * mu_Pa) / (lambda_Pa + mu_Pa); }
  double poisson() const { return lambda_Pa / (2 * (lambda_Pa + mu_Pa)); }
};

/// A key of [material] in a scene; unit "" for plain numbers.
struct ParameterRow {
  std::string_view name, unit, summary;
};

/// A material law: what it is called, what it needs, and how it is evaluated.
/// refusal: why the values (one per parameter) cannot be used, empty when they can.
/// energy: stored energy per rest volume [Pa], +inf where det F <= 0. stress: P = dW/dF [Pa].
/// tangent: dP/dF [Pa], rows and columns are entries of F, row major.
struct LawRow {
  std::string_view name, summary;
  std::span<const ParameterRow> parameters;
  int constants_used;
  std::string (*refusal)(std::span<const double> values);
  LawConstants (*constants)(std::span<const double> values);
  SmallStrain (*small_strain)(const LawConstants&);
  double (*energy)(const LawConstants&, const Mat3& F);
  Mat3 (*stress)(const LawConstants&, const Mat3& F);
  Mat9 (*tangent)(const LawConstants&, const Mat3& F);
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
};

/// Looks the law up and checks its values. Throws Error at `where` (the scene's place) when the law
/// is unknown, a value is missing or not finite, or the material would not be stable at rest.
Material make_material(const MaterialParameters& parameters, const std::string& where);

}  // namespace palpate::fem
