#include "tools/scene/toml_table.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "tools/scene/nearest_name.hpp"

namespace palpate::tools {
namespace {

std::string place(const std::string& file, const toml::node& node) {
  return fmt::format("{}:{}:{}", file, node.source().begin.line, node.source().begin.column);
}

std::string in_quotes(std::string_view text) { return fmt::format("\"{}\"", text); }

std::string kind_of(const toml::node& node) {
  switch (node.type()) {
    case toml::node_type::string:
      return "a text";
    case toml::node_type::integer:
      return "a whole number";
    case toml::node_type::floating_point:
      return "a number";
    case toml::node_type::boolean:
      return "true or false";
    case toml::node_type::array:
      return "a list";
    case toml::node_type::table:
      return "a table";
    default:
      return "a date or time";
  }
}

}  // namespace

SceneTable::SceneTable(const toml::table& table, std::string name, std::string file, KeyLog* log)
    : table_(&table), name_(std::move(name)), file_(std::move(file)), log_(log) {}

// A key may be asked for twice, first whether it is there: the first fallback and the last value.
void SceneTable::note(std::string_view key, std::string value, std::string fallback) {
  if (!log_) return;
  auto at = std::ranges::find_if(
      *log_, [&](const KeyRead& read) { return read.table == name_ && read.key == key; });
  if (at == log_->end()) at = log_->insert(at, {name_, std::string(key), "", ""});
  if (!value.empty()) at->value = std::move(value);
  if (at->fallback.empty()) at->fallback = std::move(fallback);
}

const toml::node* SceneTable::node(std::string_view key) {
  asked_.emplace(key);
  note(key, "", "");
  return table_->get(key);
}

bool SceneTable::has_only(std::initializer_list<std::string_view> keys) const {
  for (const auto& [key, value] : *table_)
    if (std::find(keys.begin(), keys.end(), key.str()) == keys.end()) return false;
  return true;
}

bool SceneTable::has(std::string_view key) {
  note(key, "", "none");
  return node(key) != nullptr;
}

std::string SceneTable::where(std::string_view key) const {
  const toml::node* value = table_->get(key);
  return value ? place(file_, *value) : where_table();
}

std::string SceneTable::where_table() const { return place(file_, *table_); }

void SceneTable::fail(const toml::node& value, std::string_view key, const std::string& what,
                      const std::string& remedy) const {
  throw Error(place(file_, value), fmt::format("{} of {} {}", key, name_, what), remedy);
}

std::string SceneTable::text(std::string_view key, std::string fallback) {
  note(key, "text", fallback.empty() ? "none" : in_quotes(fallback));
  const toml::node* value = node(key);
  if (!value) return fallback;
  if (!value->is_string())
    fail(*value, key, "is " + kind_of(*value) + ", not a text", "Put the value in double quotes.");
  return value->as_string()->get();
}

std::string SceneTable::required_text(std::string_view key, const std::string& fact,
                                      const std::string& remedy) {
  note(key, "text", "required");
  const std::string value = text(key, "");
  if (value.empty()) throw Error(where_table(), fact, remedy);
  return value;
}

std::string SceneTable::choice(std::string_view key, std::string fallback,
                               const std::vector<std::string_view>& choices) {
  const std::string chosen = text(key, std::move(fallback));
  std::vector<std::string> quoted;
  for (const std::string_view name : choices) quoted.push_back(in_quotes(name));
  note(key, fmt::format("{}", fmt::join(quoted, ", ")), "");
  for (const auto name : choices)
    if (name == chosen) return chosen;
  const toml::node* value = node(key);
  fail(value ? *value : *table_, key, fmt::format("is \"{}\", which is not known", chosen),
       suggestion(chosen, choices));
}

bool SceneTable::boolean(std::string_view key, bool fallback) {
  note(key, "true, false", fallback ? "true" : "false");
  const toml::node* value = node(key);
  if (!value) return fallback;
  if (!value->is_boolean())
    fail(*value, key, "is " + kind_of(*value) + ", not true or false", "Write true or false.");
  return value->as_boolean()->get();
}

long SceneTable::integer(std::string_view key, long fallback, long low, long high) {
  note(key, fmt::format("{} to {}", low, high), fmt::format("{}", fallback));
  const toml::node* value = node(key);
  if (!value) return fallback;
  if (!value->is_integer())
    fail(*value, key, "is " + kind_of(*value) + ", not a whole number",
         fmt::format("Give a whole number from {} to {}.", low, high));
  const long number = value->as_integer()->get();
  if (number < low || number > high)
    fail(*value, key, fmt::format("is {}", number),
         fmt::format("Give a whole number from {} to {}.", low, high));
  return number;
}

double SceneTable::number_of(const toml::node& value, std::string_view key, const std::string& verb,
                             double low, double high, const std::string& remedy) const {
  const auto number = value.value<double>();
  if (!value.is_number() || !number)
    fail(value, key, fmt::format("{} {}, not a number", verb, kind_of(value)), remedy);
  if (!(*number >= low && *number <= high))
    fail(value, key, fmt::format("{} {}", verb, *number), remedy);
  return *number;
}

double SceneTable::number(std::string_view key, double fallback, double low, double high) {
  note(key, fmt::format("{:.7g} to {:.7g}", low, high), fmt::format("{:g}", fallback));
  const toml::node* value = node(key);
  if (!value) return fallback;
  return number_of(*value, key, "is", low, high,
                   fmt::format("Give a plain number from {} to {}.", low, high));
}

const toml::array& SceneTable::items_of(const toml::node* value, std::string_view key,
                                        std::size_t count, const std::string& what,
                                        const std::string& remedy) const {
  const toml::array* list = value ? value->as_array() : nullptr;
  if (!list || (count > 0 && list->size() != count))
    fail(value ? *value : *table_, key, "is not " + what, remedy);
  return *list;
}

double SceneTable::quantity_of(const toml::node& value, std::string_view key, Dimension dimension,
                               double low, double high) const {
  const std::string example = dimension == Dimension::pressure ? "5 kPa"
                              : dimension == Dimension::length ? "12 mm"
                              : dimension == Dimension::speed  ? "10 mm/s"
                              : dimension == Dimension::angle
                                  ? "30 deg"
                                  : "1 " + known_units(dimension).substr(0, 1);
  double si = 0;
  if (value.is_string()) {
    const std::string& text = value.as_string()->get();
    const auto parsed = parse_quantity(text, dimension);
    if (!parsed)
      fail(value, key, fmt::format("is \"{}\", which is not a {}", text, dimension_name(dimension)),
           fmt::format("Write a number and a unit, such as \"{}\". Units: {}.", example,
                       known_units(dimension)));
    si = *parsed;
  } else if (value.is_number()) {
    si = *value.value<double>();
  } else {
    fail(value, key, "is " + kind_of(value) + fmt::format(", not a {}", dimension_name(dimension)),
         fmt::format("Write a number and a unit, such as \"{}\".", example));
  }
  if (!(si >= low && si <= high))
    fail(value, key, fmt::format("is {} in SI units", si),
         si < low ? fmt::format("It must be at least {}.", low)
                  : fmt::format("It must be at most {}; is the unit right?", high));
  return si;
}

double SceneTable::quantity(std::string_view key, Dimension dimension, double fallback, double low,
                            double high) {
  note(key, std::string(dimension_name(dimension)),
       std::isnan(fallback) ? "none" : fmt::format("{:g}", fallback));
  const toml::node* value = node(key);
  return value ? quantity_of(*value, key, dimension, low, high) : fallback;
}

double SceneTable::required_quantity(std::string_view key, Dimension dimension, double low,
                                     double high) {
  note(key, std::string(dimension_name(dimension)), "required");
  const toml::node* value = node(key);
  if (!value)
    throw Error(where_table(), fmt::format("{} has no {}", name_, key),
                fmt::format("Add {} = \"...\" with a unit ({}).", key, known_units(dimension)));
  return quantity_of(*value, key, dimension, low, high);
}

std::vector<double> SceneTable::quantities(std::string_view key, Dimension dimension, double low,
                                           double high) {
  note(key, fmt::format("list: {}", dimension_name(dimension)), "none");
  std::vector<double> out;
  const toml::node* value = node(key);
  if (!value) return out;
  if (!value->is_array())
    fail(*value, key, "is " + kind_of(*value) + ", not a list",
         "Write a list: [\"3 mm\", \"6 mm\"].");
  for (const toml::node& item : *value->as_array())
    out.push_back(quantity_of(item, key, dimension, low, high));
  return out;
}

std::vector<std::pair<double, double>> SceneTable::pairs(std::string_view key, double low,
                                                         double high, Dimension dimension,
                                                         double low_si, double high_si) {
  std::vector<std::pair<double, double>> out;
  const toml::node* value = node(key);
  if (!value) return out;
  const std::string remedy =
      fmt::format("Write {} = [[0.5, \"1 {}\"]]: pairs of a number from {} to {} and a {}.", key,
                  known_units(dimension).substr(0, known_units(dimension).find(',')), low, high,
                  dimension_name(dimension));
  if (!value->is_array()) fail(*value, key, "is " + kind_of(*value) + ", not a list", remedy);
  for (const toml::node& item : *value->as_array()) {
    const toml::array* pair = item.as_array();
    if (!pair || pair->size() != 2) fail(item, key, "holds what is no pair", remedy);
    const auto number = pair->get(0)->value<double>();
    if (!pair->get(0)->is_number() || !(*number >= low && *number <= high))
      fail(*pair->get(0), key, "holds a pair whose first is no number within bounds", remedy);
    out.emplace_back(*number, quantity_of(*pair->get(1), key, dimension, low_si, high_si));
  }
  return out;
}

std::vector<double> SceneTable::numbers(std::string_view key, std::size_t count, double low,
                                        double high) {
  std::vector<double> out;
  const toml::node* value = node(key);
  if (!value) return out;
  const std::string remedy =
      fmt::format("Write a list of {} plain numbers from {} to {}.", count, low, high);
  for (const toml::node& item :
       items_of(value, key, count, fmt::format("a list of {} numbers", count), remedy))
    out.push_back(number_of(item, key, "holds", low, high, remedy));
  return out;
}

Vec3 SceneTable::point_of(const toml::node& value, std::string_view key) const {
  const toml::array& list =
      items_of(&value, key, 3, "a list of three lengths", "Write [\"10 mm\", \"0 mm\", \"5 mm\"].");
  Vec3 point;
  for (std::size_t k = 0; k < 3; ++k)
    point[k] = quantity_of(*list.get(k), key, Dimension::length, -1e6, 1e6);
  return point;
}

Vec3 SceneTable::point(std::string_view key) {
  const toml::node* value = node(key);
  if (!value)
    throw Error(where_table(), fmt::format("{} has no {}", name_, key),
                fmt::format("Add {} = [x, y, z].", key));
  return point_of(*value, key);
}

Points SceneTable::points(std::string_view key) {
  const toml::array& list =
      items_of(node(key), key, 0, "a list of places",
               fmt::format("Write {} = [[\"0 mm\", \"0 mm\", \"5 mm\"]].", key));
  Points out(static_cast<Eigen::Index>(list.size()), 3);
  for (std::size_t i = 0; i < list.size(); ++i) out.row(i) = point_of(*list.get(i), key);
  return out;
}

Vec3 SceneTable::direction(std::string_view key) {
  const toml::node* value = node(key);
  const std::string what = "a list of three numbers",
                    remedy = fmt::format("Write {} = [1, 0, 0].", key);
  const toml::array& list = items_of(value, key, 3, what, remedy);
  Vec3 direction;
  for (std::size_t k = 0; k < 3; ++k) {
    if (!list.get(k)->is_number()) fail(*value, key, "is not " + what, remedy);
    direction[k] = *list.get(k)->value<double>();
  }
  return direction;
}

double SceneTable::length_unit() {
  note("length_unit", "", "required");
  if (!has("length_unit"))
    throw Error(where_table(), name_ + " has no length_unit",
                "Mesh files carry no unit. Add length_unit = \"mm\" (or " +
                    known_units(Dimension::length) + ").");
  const std::string unit = text("length_unit", "");
  note("length_unit", "length unit", "");
  return mesh_unit_m(unit, where("length_unit") + ": length_unit of " + name_);
}

std::pair<Vec3, Vec3> SceneTable::corners(std::string_view key) {
  const toml::array& list = items_of(node(key), key, 2, "a pair of corners",
                                     "Write [[x, y, z], [x, y, z]], the lower corner first.");
  return {point_of(*list.get(0), key), point_of(*list.get(1), key)};
}

SceneTable SceneTable::table(std::string_view key, std::string name) {
  static const toml::table kEmpty;
  const toml::node* value = node(key);
  note(key, "table", "none");
  if (!value) return SceneTable(kEmpty, std::move(name), file_, log_);
  if (!value->is_table())
    fail(*value, key, "is " + kind_of(*value) + ", not a table",
         fmt::format("Write {} = {{ ... }} or a section.", key));
  return SceneTable(*value->as_table(), std::move(name), file_, log_);
}

std::vector<SceneTable> SceneTable::tables(std::string_view key, std::string name) {
  note(key, "tables", "none");
  std::vector<SceneTable> out;
  const toml::node* value = node(key);
  if (!value) return out;
  if (value->is_table()) {
    out.emplace_back(*value->as_table(), std::move(name), file_, log_);
    return out;
  }
  if (!value->is_array())
    fail(*value, key, "is " + kind_of(*value) + ", not a list of tables",
         fmt::format("Write {} = [ {{ ... }} ].", key));
  for (const toml::node& item : *value->as_array()) {
    if (!item.is_table())
      fail(item, key, "holds " + kind_of(item) + ", not a table",
           fmt::format("Write {} = [ {{ ... }} ].", key));
    out.emplace_back(*item.as_table(), name, file_, log_);
  }
  return out;
}

void SceneTable::finish() const {
  for (const auto& [key, value] : *table_) {
    if (asked_.count(std::string(key.str()))) continue;
    std::vector<std::string_view> known(asked_.begin(), asked_.end());
    throw Error(fmt::format("{}:{}:{}", file_, key.source().begin.line, key.source().begin.column),
                fmt::format("{} has no key \"{}\"", name_, key.str()),
                suggestion(key.str(), known));
  }
}

}  // namespace palpate::tools
