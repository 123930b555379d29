#include "tools/scene/tissues.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "libfit/core/error.hpp"
#include "tools/scene/nearest_name.hpp"
#include "tools/scene/toml_table.hpp"

namespace palpate::tools {

extern const char* const kMaterialsToml;  // generated from data/materials.toml

namespace {

constexpr double kHighest_Pa = 1e13;

std::vector<Tissue> read_tissues() {
  const toml::table parsed = toml::parse(std::string_view(kMaterialsToml), std::string_view("data/materials.toml"));
  SceneTable root(parsed, "the table of materials", "data/materials.toml");
  std::vector<Tissue> rows;
  for (SceneTable& table : root.tables("material", "[[material]]")) {
    Tissue row;
    row.name = table.text("name", "");
    row.law = table.text("law", "");
    row.young_Pa = table.required_quantity("young", Dimension::pressure, 1, kHighest_Pa);
    row.deviation_Pa = table.quantity("deviation", Dimension::pressure, 0, 0, kHighest_Pa);
    row.poisson = table.number("poisson", 0, 0, 0.5);
    row.measured = table.text("measured", "");
    row.source = table.text("source", "");
    row.doi = table.text("doi", "");
    table.finish();
    rows.push_back(std::move(row));
  }
  root.finish();
  return rows;
}

}  // namespace

const std::vector<Tissue>& tissues() {
  static const std::vector<Tissue> rows = read_tissues();
  return rows;
}

const Tissue& find_tissue(std::string_view name, const std::string& where) {
  const std::vector<Tissue>& rows = tissues();
  const auto found =
      std::find_if(rows.begin(), rows.end(), [&](const Tissue& row) { return row.name == name; });
  if (found != rows.end()) return *found;
  std::vector<std::string_view> names;
  for (const Tissue& row : rows) names.push_back(row.name);
  throw Error(where, fmt::format("\"{}\" is not in the table of materials", name),
              suggestion(name, names));
}

}  // namespace palpate::tools
