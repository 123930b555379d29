#include <fmt/core.h>

#include "libfit/recordings/formats/importers.hpp"
#include "tools/manifest/keys.hpp"

namespace palpate::tools {
namespace {

// A column's name, or its number in a file without header.
std::string column(SceneTable& table, std::string_view key, const toml::node& node) {
  if (node.is_string()) return node.as_string()->get();
  if (node.is_integer() && node.as_integer()->get() > 0)
    return fmt::format("#{}", node.as_integer()->get());
  fail(table, key, fmt::format("{} of columns is no column", key),
       "Give a name of the header in quotes, or a number counted from 1.");
}

void read_column(SceneTable& table, std::string_view key, std::string& target) {
  if (const toml::node* node = table.node(key)) target = column(table, key, *node);
}

// counts: how many names are right.
void read_columns_of(SceneTable& table, std::string_view key, std::vector<std::string>& target,
                     bool may_be_one) {
  const toml::node* node = table.node(key);
  if (!node) return;
  target.clear();
  if (const toml::array* list = node->as_array())
    for (const toml::node& name : *list) target.push_back(column(table, key, name));
  else
    target.push_back(column(table, key, *node));
  if (target.size() != 3 && !(may_be_one && target.size() == 1))
    fail(table, key, fmt::format("{} of columns has {} names", key, target.size()),
         may_be_one ? "Give one name, or three: [\"x\", \"y\", \"z\"]."
                    : "Give three: [\"x\", \"y\", \"z\"].");
}

void read_unit(SceneTable& table, std::string_view key, Dimension dimension, std::string& target) {
  target = table.text(key, target);
  if (!target.empty() &&
      !unit_factor(importers::split_unit(fmt::format("({})", target)).second, dimension))
    fail(table, key,
         fmt::format("{} of units is \"{}\", which is no unit of {}", key, target,
                     dimension_name(dimension)),
         "Known: " + known_units(dimension) + ".");
}

}  // namespace

void read_columns(SceneTable table, importers::ColumnNames& names) {
  for (const auto& [key, name] : {std::pair{"time", &names.time},
                                  {"force_time", &names.force_time},
                                  {"depth", &names.depth},
                                  {"retract_depth", &names.retract_depth},
                                  {"retract_force", &names.retract_force}})
    read_column(table, key, *name);
  for (const auto& [key, axes] :
       {std::pair{"position", &names.position}, {"force", &names.force}, {"torque", &names.torque}})
    read_columns_of(table, key, *axes, true);
  for (const auto& [key, axes] : {std::pair{"contact", &names.contact}, {"normal", &names.normal}})
    read_columns_of(table, key, *axes, false);
  table.finish();
}

void read_units(SceneTable table, importers::UnitNames& units) {
  read_unit(table, "time", Dimension::time, units.time);
  read_unit(table, "position", Dimension::length, units.position);
  read_unit(table, "force", Dimension::force, units.force);
  read_unit(table, "torque", Dimension::torque, units.torque);
  table.finish();
}

}  // namespace palpate::tools
