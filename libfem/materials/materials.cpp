#include "libfem/materials/materials.hpp"

#include <cmath>

#include "libfem/materials/neo_hookean.hpp"
#include "libfit/core/error.hpp"

namespace palpate::fem {
namespace {

// Point evaluation, the same for every law.

struct PointResult {
  double J, W;
  std::array<double, 9> P;
  std::array<double, 81> A;
};

template <class Law>
PointResult evaluate(const LawConstants& constants, const Mat3& F) {
  const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> H = F - Mat3::Identity();
  PointResult out{};
  Law::template evaluate<double>(constants.data(), H.data(), 1.0, out.J, out.W, out.P.data(),
                                 out.A.data());
  return out;
}

template <class Law>
double energy(const LawConstants& constants, const Mat3& F) {
  return evaluate<Law>(constants, F).W;
}

template <class Law>
Mat3 stress(const LawConstants& constants, const Mat3& F) {
  const PointResult point = evaluate<Law>(constants, F);
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(point.P.data());
}

template <class Law>
Mat9 tangent(const LawConstants& constants, const Mat3& F) {
  const PointResult point = evaluate<Law>(constants, F);
  const Mat9 upper = Eigen::Map<const Mat9>(point.A.data());
  return upper.selfadjointView<Eigen::Upper>();
}

// Young's modulus and Poisson's ratio, the parameters of the neo-Hookean law.

constexpr std::array<ParameterRow, 2> kYoungPoisson{{
    {"young", "Pa", "Young's modulus at small strain"},
    {"poisson", "", "Poisson's ratio at small strain, above -1 and below 0.5"},
}};

std::string young_poisson_refusal(std::span<const double> values) {
  if (!(values[0] > 0)) return "young must be positive, not " + std::to_string(values[0]) + " Pa";
  if (!(values[1] > -1 && values[1] < 0.5))
    return "poisson must lie above -1 and below 0.5, not " + std::to_string(values[1]);
  return {};
}

LawConstants young_poisson_constants(std::span<const double> values) {
  const double young = values[0], poisson = values[1];
  return {young / (2 * (1 + poisson)), young * poisson / ((1 + poisson) * (1 - 2 * poisson))};
}

SmallStrain lame_small_strain(const LawConstants& constants) {
  return {constants[0], constants[1]};
}

// One row per law; add a law by its file and a row.
constexpr std::array<LawRow, 1> kLaws{{
    {"neo-hookean", "W = mu/2 (I1 - 3) - mu ln J + lambda/2 (ln J)^2; strains to about 50 %",
     kYoungPoisson, NeoHookean::kConstants, young_poisson_refusal, young_poisson_constants,
     lame_small_strain, energy<NeoHookean>, stress<NeoHookean>, tangent<NeoHookean>,
     &kElementKernels<NeoHookean>},
}};

std::string known_laws() {
  std::string names;
  for (const LawRow& row : kLaws) names += (names.empty() ? "" : ", ") + std::string(row.name);
  return names;
}

}  // namespace

std::span<const LawRow> material_laws() { return kLaws; }

const LawRow& find_law(std::string_view name, const std::string& where) {
  for (const LawRow& row : kLaws)
    if (row.name == name) return row;
  throw Error(where, "unknown material law \"" + std::string(name) + "\"",
              "Use one of: " + known_laws() + ".");
}

Material make_material(const MaterialParameters& parameters, const std::string& where) {
  const LawRow& law = find_law(parameters.law, where);
  std::string names;
  for (const ParameterRow& row : law.parameters)
    names += (names.empty() ? "" : ", ") + std::string(row.name);
  if (parameters.values.size() != law.parameters.size())
    throw Error(where, "law " + std::string(law.name) + " takes " +
                std::to_string(law.parameters.size()) + " values, not " +
                std::to_string(parameters.values.size()), "Give " + names + ".");
  for (std::size_t i = 0; i < parameters.values.size(); ++i)
    if (!std::isfinite(parameters.values[i]))
      throw Error(where, std::string(law.parameters[i].name) + " is not a finite number",
                  "Give " + std::string(law.parameters[i].summary) + ".");
  if (const std::string refusal = law.refusal(parameters.values); !refusal.empty())
    throw Error(where, refusal, "Correct the material; law " + std::string(law.name) + " takes " +
                names + ".");
  return {&law, law.constants(parameters.values)};
}

}  // namespace palpate::fem
