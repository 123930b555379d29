#include "tools/scene/tissues.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <sstream>
#include <utility>

#include "libfit/core/error.hpp"
#include "libfit/io/atomic_file.hpp"
#include "tools/scene/nearest_name.hpp"
#include "tools/scene/toml_table.hpp"

namespace palpate::tools {

extern const char* const kMaterialsToml;  // generated from data/materials.toml
extern const char* const kDevicesToml;    // generated from data/devices.toml

namespace {

struct MaterialTable {
  std::vector<Tissue> tissues;
  std::vector<HollowOrgan> hollow;
};

MaterialTable read_materials() {
  const toml::table parsed =
      toml::parse(std::string_view(kMaterialsToml), std::string_view("data/materials.toml"));
  SceneTable root(parsed, "the table of materials", "data/materials.toml");
  MaterialTable out;
  for (SceneTable& table : root.tables("hollow", "[[hollow]]")) {
    HollowOrgan& row = out.hollow.emplace_back();
    row.name = table.text("name", "");
    row.wall_m = table.required_quantity("wall", Dimension::length, 1e-4, 0.1);
    row.source = table.text("source", "");
    row.doi = table.text("doi", "");
    table.finish();
  }
  std::vector<Tissue>& rows = out.tissues;
  for (SceneTable& table : root.tables("material", "[[material]]")) {
    Tissue row;
    row.name = table.text("name", "");
    row.law = table.text("law", "");
    row.young_Pa = table.required_quantity("young", Dimension::pressure, 1, 1e13);
    row.deviation_Pa = table.quantity("deviation", Dimension::pressure, 0, 0, 1e13);
    row.poisson = table.number("poisson", 0, 0, 0.5);
    row.measured = table.text("measured", "");
    row.source = table.text("source", "");
    row.doi = table.text("doi", "");
    row.relaxation = table.text("relaxation", "");
    row.rests_on = table.text("rests_on", "");
    table.finish();
    rows.push_back(std::move(row));
  }
  root.finish();
  return out;
}

const MaterialTable& material_table() {
  static const MaterialTable table = read_materials();
  return table;
}

// Words of file names for those of the table.
constexpr std::pair<std::string_view, std::string_view> kSynonyms[] = {
    {"hepatic", "liver"},    {"renal", "kidney"},     {"cardiac", "heart"},
    {"myocardium", "heart"}, {"cerebrum", "brain"},   {"colon", "bowel"},
    {"intestine", "bowel"},  {"gall", "gallbladder"}, {"tumor", "tumour"},
};

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }
bool is_capital(char c) { return c >= 'A' && c <= 'Z'; }

// Words of a name in small letters, each also without the ending of a plural, and their synonyms.
std::set<std::string> words_of(std::string_view name) {
  std::set<std::string> words;
  const auto add = [&](const std::string& word) {
    words.insert(word);
    for (const auto& [other, known] : kSynonyms)
      if (word == other) words.insert(std::string(known));
  };
  for (std::size_t i = 0; i < name.size();) {
    std::string word;
    for (; i < name.size() && is_letter(name[i]); ++i) {
      if (!word.empty() && is_capital(name[i]) && !is_capital(name[i - 1])) break;
      word += static_cast<char>(is_capital(name[i]) ? name[i] - 'A' + 'a' : name[i]);
    }
    if (word.empty()) {
      ++i;
      continue;
    }
    add(word);
    for (const std::string_view ending : {"s", "es"})
      if (word.ends_with(ending)) add(word.substr(0, word.size() - ending.size()));
  }
  return words;
}

void add_devices(std::string_view text, const std::string& file,
                 std::vector<certify::Device>& rows) {
  const toml::table parsed = parse_toml(text, file, "Write it as data/devices.toml is written.");
  SceneTable root(parsed, "the table of devices", file);
  for (SceneTable& table : root.tables("device", "[[device]]")) {
    certify::Device row;
    row.name = table.text("name", "");
    row.max_force_N = table.quantity("max_force", Dimension::force, 0, 0, 1e4);
    row.max_stiffness_N_m = table.number("max_stiffness", 0, 0, 1e7);
    row.resolution_m = table.quantity("resolution", Dimension::length, 0, 0, 0.1);
    row.friction_N = table.quantity("friction", Dimension::force, 0, 0, 1e3);
    row.source = table.text("source", "");
    table.finish();
    rows.push_back(std::move(row));
  }
  root.finish();
}

}  // namespace

const std::vector<Tissue>& tissues() { return material_table().tissues; }

const HollowOrgan* hollow_organ_of_name(std::string_view name) {
  const std::set<std::string> words = words_of(name);
  for (const HollowOrgan& row : material_table().hollow)
    if (words.contains(row.name)) return &row;
  return nullptr;
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

const Tissue* tissue_of_name(std::string_view name) {
  const std::set<std::string> words = words_of(name);
  const Tissue* meant = nullptr;
  std::size_t most_letters = 0;
  for (const Tissue& row : tissues()) {
    std::istringstream parts(row.name);
    std::size_t letters = 0;
    for (std::string part; std::getline(parts, part, '-');) {
      if (words.contains(part))
        letters += part.size();
      else if (letters == 0)
        break;  // the first word is not there
    }
    if (letters > most_letters) {
      meant = &row;
      most_letters = letters;
    }
  }
  return meant;
}

std::vector<certify::Device> read_devices(const std::filesystem::path& more) {
  std::vector<certify::Device> rows;
  add_devices(kDevicesToml, "data/devices.toml", rows);
  if (!more.empty()) add_devices(read_whole_file(more), more.string(), rows);
  return rows;
}

}  // namespace palpate::tools
