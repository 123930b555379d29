#include <fmt/core.h>

#include <tuple>

#include "tools/scene/scene.hpp"
#include "tools/scene/toml_table.hpp"

namespace palpate::tools {
namespace {

constexpr double kHighestModulus = 1e13;  // Pa; ten diamonds
constexpr double kHighestNumber = 1e6;    // of parameters without unit

[[noreturn]] void refuse_missing(const SceneTable& table, const fem::LawRow& law,
                                 const fem::ParameterRow& row) {
  const std::string units = known_units(Dimension::pressure);
  const std::string form = row.count > 1      ? fmt::format("[...], {} numbers", row.count)
                           : row.unit.empty() ? "a plain number"
                                              : fmt::format("\"...\" with a unit ({})", units);
  throw Error(table.where_table(),
              fmt::format("{} has no {}, which law {} needs", table.name(), row.name, law.name),
              fmt::format("Add {} = {}: {}.", row.name, form, row.summary));
}

// Appends the numbers of one row.
void read_parameter(SceneTable& table, const fem::LawRow& law, const fem::ParameterRow& row,
                    std::vector<double>& values) {
  if (!table.has(row.name)) {
    if (row.fallback == fem::kRequired) refuse_missing(table, law, row);
    values.insert(values.end(), static_cast<std::size_t>(row.count), row.fallback);
    return;
  }
  if (!row.instead_of.empty() && table.has(row.instead_of))
    throw Error(table.where(row.name),
                fmt::format("{} of {} is given beside {}", row.name, table.name(), row.instead_of),
                "Keep one of the two.");
  if (row.count > 1) {
    const auto count = static_cast<std::size_t>(row.count);
    for (const double number : table.numbers(row.name, count, -kHighestNumber, kHighestNumber))
      values.push_back(number);
  } else if (row.unit.empty()) {
    values.push_back(table.number(row.name, 0, -kHighestNumber, kHighestNumber));
  } else {
    values.push_back(
        table.quantity(row.name, Dimension::pressure, 0, -kHighestModulus, kHighestModulus));
  }
}

// relaxation = [[g, "tau"], ...]
Relaxation read_relaxation(SceneTable& table) {
  const auto branches = table.pairs("relaxation", 1e-6, runtime::kMaxShare, Dimension::time,
                                    runtime::kMinRelaxation_s, runtime::kMaxRelaxation_s);
  Relaxation out;
  out.share.resize(branches.size());
  out.time_s.resize(out.share.size());
  for (Eigen::Index k = 0; k < out.share.size(); ++k)
    std::tie(out.share[k], out.time_s[k]) = branches[k];
  return out;
}

// softening = { r, m, beta }
fem::Softening read_softening(SceneTable& table) {
  if (!table.has("softening")) return {};
  SceneTable own = table.table("softening", "softening of " + table.name());
  fem::Softening out;
  if (own.holds("r") || own.holds("m") || own.holds("beta")) {
    out.r = own.number("r", 0, 1, fem::kMaxSoftening);
    out.scale_Pa = own.quantity("m", Dimension::pressure, 0, 0, kHighestModulus);
    out.beta = own.number("beta", 0, 0, fem::kMaxSoftening);
    if (!own.holds("r"))
      throw Error(own.where_table(), fmt::format("softening of {} has no r", table.name()),
                  fem::kSofteningRemedy);
  }
  own.finish();
  return out;
}

}  // namespace

fem::MaterialParameters read_material(SceneTable table, bool may_relax) {
  std::vector<std::string_view> laws;
  for (const fem::LawRow& row : fem::material_laws()) laws.push_back(row.name);
  fem::MaterialParameters material;
  material.law = table.choice("law", material.law, laws);
  const fem::LawRow& law = fem::find_law(material.law, table.where("law"));
  // A misspelt key is named before the key that it was meant to be is missed.
  for (const fem::ParameterRow& row : law.parameters) table.has(row.name);
  if (may_relax)
    for (const char* key : {"relaxation", "softening"}) table.has(key);
  table.finish();
  for (const fem::ParameterRow& row : law.parameters)
    read_parameter(table, law, row, material.values);
  const auto check = [&](const fem::Refusal& refusal, const std::string& remedy) {
    if (refusal.is_refused())
      throw Error(table.where(refusal.key),
                  fmt::format("{} of {} {}", refusal.key, table.name(), refusal.text), remedy);
  };
  const fem::Refusal refusal = law.refusal(material.values);
  const fem::ParameterRow* row = fem::find_parameter(law, refusal.key);
  check(refusal, fmt::format("{} is the {}.", refusal.key, row ? row->summary : law.summary));
  if (!may_relax) return material;
  material.relaxation = read_relaxation(table);
  check(fem::refuse_relaxation(material.relaxation), fem::kRelaxationRemedy);
  material.softening = read_softening(table);
  if (material.relaxation.branches() > 0 && material.softening.is_any())
    throw Error(table.where("softening"),
                fmt::format("{} has both relaxation and softening, and the simulator computes one "
                            "of the two in a material",
                            table.name()),
                "Keep one of them here. Curves that recordings of both are fitted to may do both: "
                "the engine plays them together.");
  check(fem::refuse_softening(material), fem::kSofteningRemedy);
  return material;
}

}  // namespace palpate::tools
