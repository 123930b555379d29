#include "tools/study/study_folder.hpp"

#include <fmt/format.h>

#include <sstream>

#include "libfit/core/error.hpp"

namespace palpate::tools {
namespace {

// Tables of a study whose entries have names, and the section of a scene that each changes.
struct NamedTables {
  const char *key, *column, *section, *whole;  ///< whole: a key that replaces the section
};
constexpr NamedTables kNamed[] = {{"bodies", "body", "body", nullptr},
                                  {"materials", "material", "material", "law"},
                                  {"probes", "probe", "probe", "shape"}};

std::string in_words(const toml::node& value) {
  if (value.is_string()) return value.as_string()->get();
  std::ostringstream text;
  value.visit([&](const auto& v) {
    if constexpr (requires { text << v; }) text << v;
  });
  return text.str();
}

toml::table boxed(const toml::node& value) {
  toml::table box;
  value.visit([&](const auto& v) { box.insert_or_assign("value", v); });
  return box;
}

// Each key of [vary] is a list, and an axis of its own.
void read_vary(SceneTable& top, const std::string& file, Axes& out) {
  const toml::node* node = top.node("vary");
  if (!node) return;
  if (!node->is_table())
    throw Error(top.where("vary"), "is no table", "Write [vary] with keys of the scene.");
  for (const auto& [name, value] : *node->as_table()) {
    const std::string key(name.str());
    const std::string where = fmt::format("{}:{}:{}: {}", file, value.source().begin.line,
                                          value.source().begin.column, key);
    if (key.find('.') == std::string::npos)
      throw Error(where, "names no section of the scene",
                  "Write section and key, such as \"material.young\".");
    const toml::array* list = value.as_array();
    if (!list || list->empty())
      throw Error(where, "is no list of values",
                  "Write [a, b, c]; values drawn by a program go into a table, `cases`.");
    Axis axis;
    for (const toml::node& item : *list) {
      CaseChange choice{{in_words(item)}, {}, {}};
      choice.changes.emplace_back(key, boxed(item));
      axis.push_back(std::move(choice));
    }
    out.inputs.push_back(key);
    out.axis.push_back(std::move(axis));
  }
}

void read_named(SceneTable& top, const NamedTables& named, Axes& out) {
  const toml::node* node = top.node(named.key);
  if (!node) return;
  const toml::table* all = node->as_table();
  if (!all || all->empty())
    throw Error(top.where(named.key), fmt::format("{} is no table of named tables", named.key),
                fmt::format("Write [{}.name] with keys of [{}].", named.key, named.section));
  Axis axis;
  for (const auto& [name, value] : *all) {
    const toml::table* entry = value.as_table();
    if (!entry)
      throw Error(top.where(named.key), fmt::format("{} of {} is no table", name.str(), named.key),
                  fmt::format("Write [{}.{}].", named.key, name.str()));
    CaseChange choice{{std::string(name.str())}, {}, {}};
    if (named.whole && entry->get(named.whole)) choice.replaced = named.section;
    for (const auto& [key, setting] : *entry)
      choice.changes.emplace_back(key.str().find('.') == std::string_view::npos
                                      ? fmt::format("{}.{}", named.section, key.str())
                                      : std::string(key.str()),
                                  boxed(setting));
    axis.push_back(std::move(choice));
  }
  out.inputs.emplace_back(named.column);
  out.axis.push_back(std::move(axis));
}

}  // namespace

Axes read_axes(SceneTable& top, const std::string& file) {
  Axes out;
  for (const NamedTables& named : kNamed) read_named(top, named, out);
  read_vary(top, file, out);
  return out;
}

}  // namespace palpate::tools
