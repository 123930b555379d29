#include "libfem/materials/materials.hpp"

#include "libfit/core/error.hpp"

namespace palpate::fem {
namespace {

std::string parameter_names(const LawRow& law) {
  std::string names;
  for (const ParameterRow& row : law.parameters)
    names += (names.empty() ? "" : ", ") + std::string(row.name) +
             (row.count > 1 ? " (" + std::to_string(row.count) + ")" : "") +
             (row.fallback == kRequired ? "" : " (may be left out)");
  return names;
}

// All values of the law, those left out at the end filled in.
std::vector<double> complete_values(const LawRow& law, std::vector<double> values,
                                    const std::string& where) {
  std::size_t most = 0, least = 0;
  for (const ParameterRow& row : law.parameters) {
    most += row.count;
    if (row.fallback == kRequired) least = most;
  }
  if (values.size() < least || values.size() > most)
    throw Error(where,
                "law " + std::string(law.name) + " takes " + std::to_string(most) +
                    " values, not " + std::to_string(values.size()),
                "Give " + parameter_names(law) + ".");
  std::size_t begin = 0;
  for (const ParameterRow& row : law.parameters) {
    for (std::size_t i = begin; i < begin + row.count; ++i)
      if (i >= values.size())
        values.push_back(row.fallback);
      else if (!std::isfinite(values[i]) && !(std::isnan(values[i]) && std::isnan(row.fallback)))
        throw Error(where, std::string(row.name) + " is not a finite number",
                    "Give " + std::string(row.summary) + ".");
    begin += row.count;
  }
  return values;
}

}  // namespace

const LawRow& find_law(std::string_view name, const std::string& where) {
  std::string names;
  for (const LawRow& row : material_laws()) {
    if (row.name == name) return row;
    names += (names.empty() ? "" : ", ") + std::string(row.name);
  }
  throw Error(where, "unknown material law \"" + std::string(name) + "\"",
              "Use one of: " + names + ".");
}

const ParameterRow* find_parameter(const LawRow& law, std::string_view key) {
  for (const ParameterRow& row : law.parameters)
    if (row.name == key) return &row;
  return nullptr;
}

std::vector<std::size_t> moduli_of(const MaterialParameters& parameters) {
  std::vector<std::size_t> moduli;
  std::size_t at = 0;
  for (const ParameterRow& row : find_law(parameters.law, "law").parameters)
    for (int k = 0; k < row.count && at < parameters.values.size(); ++k, ++at)
      if (!row.unit.empty() && std::isfinite(parameters.values[at])) moduli.push_back(at);
  return moduli;
}

double sum_of_moduli(const MaterialParameters& parameters) {
  double sum = 0;
  for (const std::size_t m : moduli_of(parameters)) sum += std::abs(parameters.values[m]);
  return sum;
}

Refusal refuse_relaxation(const Relaxation& relaxation) {
  const auto refused = [](const std::string& text) { return Refusal{"relaxation", text}; };
  if (relaxation.branches() == 0) return {};
  if (relaxation.branches() > runtime::kMaxBranches)
    return refused("must have " + std::to_string(runtime::kMaxBranches) + " branches or fewer");
  for (Eigen::Index k = 0; k < relaxation.branches(); ++k) {
    if (!(relaxation.share[k] > 0 && relaxation.share[k] <= runtime::kMaxShare))
      return refused("must have shares above 0 and up to " + short_number(runtime::kMaxShare));
    if (!(relaxation.time_s[k] >= runtime::kMinRelaxation_s &&
          relaxation.time_s[k] <= runtime::kMaxRelaxation_s))
      return refused("must have times from " + short_number(runtime::kMinRelaxation_s) + " to " +
                     short_number(runtime::kMaxRelaxation_s) + " s");
    if (k > 0 && !(relaxation.time_s[k] > relaxation.time_s[k - 1]))
      return refused("must have times that rise");
  }
  return {};
}

Refusal refuse_softening(const MaterialParameters& material) {
  const Softening& softening = material.softening;
  const auto refused = [](const std::string& text) { return Refusal{"softening", text}; };
  if (!softening.is_any()) return {};
  if (!(softening.r >= 1 && softening.r <= kMaxSoftening))
    return refused("must have r from 1 to " + short_number(kMaxSoftening));
  if (!(softening.scale_Pa >= 0 && softening.beta >= 0 && softening.beta <= kMaxSoftening &&
        softening.scale_Pa + softening.beta > 0))
    return refused("must have m and beta from 0, and not both 0");
  if (material.relaxation.branches() > 0)
    return refused("must be left out of a material that relaxes");
  return {};
}

Material make_material(const MaterialParameters& parameters, const std::string& where) {
  const LawRow& law = find_law(parameters.law, where);
  const std::vector<double> values = complete_values(law, parameters.values, where);
  const auto check = [&](const Refusal& refusal, const std::string& remedy) {
    if (refusal.is_refused())
      throw Error(where, std::string(refusal.key) + " " + refusal.text, remedy);
  };
  check(law.refusal(values), "Correct the material; law " + std::string(law.name) + " takes " +
                                 parameter_names(law) + ".");
  check(refuse_relaxation(parameters.relaxation), kRelaxationRemedy);
  check(refuse_softening(parameters), kSofteningRemedy);
  return {&law, law.constants(values), parameters.relaxation, parameters.softening};
}

}  // namespace palpate::fem
