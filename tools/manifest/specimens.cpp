#include "tools/manifest/manifest.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <optional>

#include "libfit/recordings/formats/importers.hpp"
#include "tools/scene/scene.hpp"
#include "tools/scene/toml_table.hpp"

namespace palpate::tools {
namespace {

using namespace importers;

constexpr const char* kRemedy =
    "Write [material] and [[test]] as docs/formats/tests.md shows tests of specimens.";

// The field of a column, by its name in a header or by its number.
std::optional<std::size_t> field_of(const std::string& column,
                                    const std::vector<std::string_view>& fields) {
  for (std::size_t k = 0; k < fields.size(); ++k)
    if (column == fmt::format("#{}", k + 1) || fields[k] == column ||
        split_unit(fields[k]).first == split_unit(column).first)
      return k;
  return std::nullopt;
}

struct TwoColumns {
  NumberTable table;
  std::string stress_unit;  ///< in the brackets of the header; empty: none
};

// The two columns of a file: below the line that names both, or from its first line of numbers on.
TwoColumns read_two(const std::filesystem::path& path, const std::string& strain,
                    const std::string& stress) {
  const std::uintmax_t most = ReadSettings{}.max_bytes;
  const std::string bytes = unpacked(path, read_bytes(path, most), most);
  const TextFile file(path, bytes, "utf-8");
  for (std::size_t i = 0; i < std::min(file.lines(), kHeaderLines); ++i) {
    const std::string_view line = file.line(i);
    if (unquoted(line).empty()) continue;
    const char separator = guess_separator(unquoted(line));
    const auto fields = split(unquoted(line), separator);
    const auto at = field_of(strain, fields), stress_at = field_of(stress, fields);
    const bool is_numbers = std::all_of(fields.begin(), fields.end(), [](std::string_view field) {
      return parse_number(field, '.').has_value();
    });
    const bool is_by_number = strain.starts_with('#') && stress.starts_with('#');
    if (!at || !stress_at || is_numbers != is_by_number) continue;
    TableLayout layout{.first = is_by_number ? i : i + 1,
                       .separator = separator,
                       .comment = "#",
                       .field = {*at, *stress_at},
                       .name = {strain, stress}};
    return {read_numbers(file, layout), is_by_number ? "" : split_unit(fields[*stress_at]).second};
  }
  throw file.error(0, fmt::format("has no column {} beside {}", strain, stress),
                   "Name columns of its header, or number them from 1 where it has none.");
}

fem::HomogeneousTest read_test(SceneTable& table, const std::filesystem::path& folder,
                               std::string& name) {
  fem::HomogeneousTest test;
  std::vector<std::string_view> kinds;
  for (const auto& row : fem::kHomogeneousTests) kinds.push_back(row.name);
  const std::string kind = table.choice("kind", std::string(kinds.front()), kinds);
  for (const auto& row : fem::kHomogeneousTests)
    if (row.name == kind) test.row = &row;
  const std::string file =
      table.required_text("file", "[[test]] names no file", "Add file = \"tension.csv\".");
  name = fmt::format("{} {}", kind, file);
  const bool is_stretch = table.has("stretch");
  if (is_stretch == table.has("strain") || (is_stretch && test.row->is_shear))
    throw Error(table.where_table(),
                is_stretch && !test.row->is_shear ? "[[test]] has both stretch and strain"
                : is_stretch                      ? "[[test]] has the stretch of a shear"
                                                  : "[[test]] has neither stretch nor strain",
                "Give the column of one: stretch = \"l\", or strain = 2 (nominal; of a shear its "
                "amount).");
  const char* of_strain = is_stretch ? "stretch" : "strain";
  const std::string strain = column(table, of_strain, table.node(of_strain)),
                    stress = column(table, "stress", table.node("stress"));
  if (strain == stress)
    fail(table, "stress", "is the column of the strain", "Name the column of the stress.");
  const std::string unit = table.text("unit", "");
  test.is_true = table.choice("measure", "nominal", {"nominal", "true"}) == "true";
  if (table.has("error"))
    test.deviation = table.quantity("error", Dimension::pressure, 0, 1e-9, 1e13);
  const TwoColumns read = read_two(folder / file, strain, stress);
  const std::string its_unit = unit.empty() ? read.stress_unit : unit;
  const auto factor = unit_factor(its_unit, Dimension::pressure);
  if (!factor)
    fail(table, unit.empty() ? "stress" : "unit",
         its_unit.empty() ? "nothing says the unit of the stress"
                          : fmt::format("\"{}\" is no unit of pressure", its_unit),
         "Add unit = \"kPa\"; known: " + known_units(Dimension::pressure) + ".");
  table.finish();
  const auto& columns = read.table.column;
  const Eigen::Index n = columns[0].size();
  test.stretch = Eigen::Map<const Eigen::VectorXd>(columns[0].data(), n);
  test.stress = *factor * Eigen::Map<const Eigen::VectorXd>(columns[1].data(), n);
  if (n > 0 && !(test.stress.cwiseAbs().maxCoeff() > 0))
    throw Error((folder / file).string(), "every stress of it is 0",
                "Name the column of the stress.");
  if (!is_stretch && !test.row->is_shear) test.stretch.array() += 1;
  for (Eigen::Index i = 0; i < n && !test.row->is_shear; ++i)
    if (!(test.stretch[i] > 0))
      throw Error(fmt::format("{}:{}", (folder / file).string(), read.table.line[i]),
                  fmt::format("a stretch of {:.6g} is none", test.stretch[i]),
                  "Give stretches above 0, or say strain where the column has strains.");
  return test;
}

}  // namespace

bool has_specimens(const std::string& text, const std::string& file) {
  return parse_toml(text, file, kRemedy).contains("test");
}

Specimens read_specimens(const std::string& text, const std::filesystem::path& path, KeyLog* log) {
  const toml::table parsed = parse_toml(text, path.string(), kRemedy);
  SceneTable root(parsed, "the file", path.string(), log);
  if (!root.has("material"))
    throw Error(path.string(), "has no [material]",
                "Add [material] with its law and the values that the search starts from.");
  Specimens out;
  out.material = read_material(root.table("material", "[material]"));
  for (SceneTable& table : root.tables("test", "[[test]]")) {
    out.name.emplace_back();
    out.tests.push_back(read_test(table, path.parent_path(), out.name.back()));
  }
  root.finish();
  return out;
}

}  // namespace palpate::tools
