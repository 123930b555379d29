#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <tuple>

#include "libfit/recordings/contact_point/contact_point.hpp"
#include "libfit/recordings/formats/importers.hpp"
#include "tools/manifest/manifest.hpp"

namespace palpate::tools {
namespace {

using recordings::BatchItem;
using recordings::Drift;
using recordings::Tip;

template <class Value>
struct Named {
  std::string_view name;
  Value value;
};
template <class Value>  // clang 14 deduces nothing for aggregates
Named(std::string_view, Value)->Named<Value>;
constexpr std::array kKinds{
    Named{"press", ExperimentKind::press}, Named{"drag", ExperimentKind::drag},
    Named{"path", ExperimentKind::path}, Named{"scan", ExperimentKind::scan}};
constexpr std::array kDrifts{Named{"none", Drift::none}, Named{"bias", Drift::bias},
                             Named{"line", Drift::line}};
constexpr std::array kTips{Named{"sphere", Tip::sphere}, Named{"flat", Tip::flat},
                           Named{"cone", Tip::cone}};
constexpr std::array kSeparators{Named{"comma", ','}, Named{"semicolon", ';'}, Named{"tab", '\t'},
                                 Named{"blank", ' '}};
constexpr std::array kPositions{Named{"contact", false}, Named{"center", true}};
constexpr std::array kNormals{Named{"inward", false}, Named{"outward", true}};

// The value that a key's word names; stays as it is where the table has no such key.
template <class Value, std::size_t N>
void read_named(SceneTable& table, std::string_view key, const std::array<Named<Value>, N>& all,
                Value& value) {
  const auto now = std::ranges::find(all, value, &Named<Value>::value);
  if (now == all.end() && !table.has(key)) return;
  std::vector<std::string_view> names;
  for (const auto& row : all) names.push_back(row.name);
  const std::string name = table.choice(key, std::string(now == all.end() ? "" : now->name), names);
  value = std::ranges::find(all, name, &Named<Value>::name)->value;
}

// A word, or the number of a press.
void read_cycle(SceneTable& table, recordings::SignalSettings& s) {
  const toml::node* node = table.node("cycle");
  if (!node) return;
  if (node->is_integer()) {
    s.cycle = static_cast<int>(table.integer("cycle", 1, 1, 100000));
    s.use = recordings::Use::approach;
    return;
  }
  const std::string name = table.choice("cycle", "", {"deepest", "first", "last", "mean"});
  s.cycle = name == "first"  ? 1
            : name == "last" ? recordings::kLastCycle
                             : recordings::kDeepestCycle;
  s.use = name == "mean" ? recordings::Use::mean : recordings::Use::approach;
}

void read_position(SceneTable& table, ManifestEntry& entry) {
  const toml::node* node = table.node("position");
  if (!node) return;
  const toml::array* list = node->as_array();
  if (list && list->size() == 3 && list->get(0)->is_string()) {
    const Vec3 position = table.point("position");
    entry.item.position_m = position;
    entry.position.reset();
  } else {
    entry.position = table.numbers("position", 3, -kAnyNumber, kAnyNumber);
    entry.item.position_m.reset();
  }
}

void read_normal(SceneTable& table, BatchItem& item) {
  if (!table.has("normal")) return;
  const auto n = table.numbers("normal", 3, -kAnyNumber, kAnyNumber);
  const Vec3 normal(n[0], n[1], n[2]);
  if (!(normal.norm() > 1e-12))
    fail(table, "normal", "normal has no direction",
         "Give the direction into the body, such as [0, 0, -1].");
  item.normal = normal.normalized();
}

void read_text_keys(SceneTable& table, importers::ReadSettings& read) {
  std::vector<std::string_view> formats{"auto"};
  for (const auto& row : importers::importers()) formats.push_back(row.name);
  read.format = table.choice("format", read.format, formats);
  read_named(table, "separator", kSeparators, read.separator);
  if (table.has("decimal")) read.decimal = table.choice("decimal", "", {".", ","})[0];
  read.encoding = table.choice("encoding", read.encoding, {"utf-8", "latin-1"});
  read.comment = table.text("comment", read.comment);
  read_named(table, "normals", kNormals, read.is_normal_outward);
  read.max_bytes = static_cast<std::uintmax_t>(table.number(
                       "largest_file", static_cast<double>(read.max_bytes >> 20), 1, 1 << 20))
                   << 20;
}

void read_columns_of(SceneTable& table, std::string_view key, std::vector<std::string>& target,
                     bool may_be_one) {
  const toml::node* node = table.node(key);
  if (!node) return;
  target.clear();
  if (const toml::array* list = node->as_array())
    for (const toml::node& name : *list) target.push_back(column(table, key, &name));
  else
    target.push_back(column(table, key, node));
  if (target.size() != 3 && !(may_be_one && target.size() == 1))
    fail(table, key, fmt::format("{} of columns has {} names", key, target.size()),
         may_be_one ? "Give one name, or three: [\"x\", \"y\", \"z\"]."
                    : "Give three: [\"x\", \"y\", \"z\"].");
}

void read_columns(SceneTable table, importers::ColumnNames& names) {
  for (const auto& [key, name] :
       {std::pair{"time", &names.time}, {"force_time", &names.force_time}, {"depth", &names.depth}})
    if (const toml::node* node = table.node(key)) *name = column(table, key, node);
  for (const auto& [key, axes] :
       {std::pair{"position", &names.position}, {"force", &names.force}, {"torque", &names.torque}})
    read_columns_of(table, key, *axes, true);
  for (const auto& [key, axes] : {std::pair{"contact", &names.contact}, {"normal", &names.normal}})
    read_columns_of(table, key, *axes, false);
  table.finish();
}

void read_units(SceneTable table, importers::UnitNames& units) {
  for (const auto& [key, dimension, unit] : {std::tuple{"time", Dimension::time, &units.time},
                                             {"position", Dimension::length, &units.position},
                                             {"force", Dimension::force, &units.force},
                                             {"torque", Dimension::torque, &units.torque}}) {
    *unit = table.text(key, *unit);
    if (!unit->empty() &&
        !unit_factor(importers::split_unit(fmt::format("({})", *unit)).second, dimension))
      fail(table, key,
           fmt::format("{} of units is \"{}\", which is no unit of {}", key, *unit,
                       dimension_name(dimension)),
           "Known: " + known_units(dimension) + ".");
  }
  table.finish();
}

// An estimator, or where the contact is.
void read_contact(SceneTable& table, recordings::SignalSettings& s) {
  const toml::node* node = table.node("contact");
  if (!node) return;
  const auto text = node->value<std::string>();
  s.known_contact.reset();
  if (node->is_number() || (text && parse_quantity(*text, Dimension::length))) {
    s.known_contact = {table.quantity("contact", Dimension::length, 0, -10, 10), 0};
  } else {
    std::vector<std::string_view> names;
    for (const auto& row : recordings::contact_estimators()) names.push_back(row.name);
    s.contact = table.choice("contact", "", names);
  }
}

void read_signal_keys(SceneTable& table, ManifestEntry& entry) {
  recordings::SignalSettings& s = entry.item.signal;
  read_named(table, "kind", kKinds, s.kind);
  read_contact(table, s);
  read_named(table, "positions", kPositions, s.is_position_of_center);
  read_named(table, "drift", kDrifts, s.drift);
  s.smooth_s = table.quantity("smooth", Dimension::time, s.smooth_s, 0, 1e3);
  s.force_delay_s = table.quantity("force_delay", Dimension::time, s.force_delay_s, -1e3, 1e3);
  s.compliance_m_N = table.number("compliance", s.compliance_m_N, 0, 1e3);
  if (table.has("force_limit"))
    s.force_limit_N = table.quantity("force_limit", Dimension::force, 0, 0, 1e9);
  read_cycle(table, s);
  s.rows = static_cast<int>(table.integer("rows", s.rows, 3, 100000));
  s.poisson = table.number("poisson", s.poisson, 0, 0.5);
  if (table.has("plausible")) {
    const auto range = table.quantities("plausible", Dimension::pressure, 0, 1e15);
    if (range.size() != 2 || !(range[0] < range[1]))
      fail(table, "plausible", "plausible is not a range of two moduli",
           "Write [\"10 Pa\", \"5 MPa\"].");
    s.min_young_Pa = range[0];
    s.max_young_Pa = range[1];
    s.is_range_given = true;
  }
  if (table.has("probe")) {
    SceneTable probe = table.table("probe", "probe");
    read_named(probe, "shape", kTips, s.tip);
    // A ball of metres presses as a plane: "5 m" for "5 mm".
    s.radius_m = probe.quantity("radius", Dimension::length, s.radius_m, 0, 1);
    s.half_angle_rad = probe.quantity("half_angle", Dimension::angle, s.half_angle_rad, 0, 1.57);
    if (probe.has("friction")) entry.friction = probe.number("friction", 0, 0, 100);
    probe.finish();
  }
  if (s.is_position_of_center && s.tip != Tip::sphere)
    fail(table, "positions", "positions are of the center of a tip that is no ball",
         "Say positions = \"contact\", and the place of the tip's end.");
}

// The keys of the table and of its columns that some formats do not read.
std::vector<importers::SaidKey> said_keys(const SceneTable& table, const SceneTable& columns) {
  std::vector<importers::SaidKey> said;
  for (const importers::FormatKey& key : importers::format_keys()) {
    const bool is_column = key.name.starts_with("columns.");
    const SceneTable& holder = is_column ? columns : table;
    const std::string_view name = is_column ? key.name.substr(8) : key.name;
    if (holder.holds(name)) said.push_back({std::string(key.name), holder.where(name)});
  }
  return said;
}

}  // namespace

[[noreturn]] void fail(const SceneTable& table, std::string_view key, const std::string& what,
                       const std::string& remedy) {
  throw Error(table.where(key), what, remedy);
}

std::string column(const SceneTable& table, std::string_view key, const toml::node* node) {
  if (node && node->is_string()) return node->as_string()->get();
  if (node && node->is_integer() && node->as_integer()->get() > 0)
    return fmt::format("#{}", node->as_integer()->get());
  fail(table, key, fmt::format("{} of {} is no column", key, table.name()),
       "Give a name of the header in quotes, or a number counted from 1.");
}

void read_keys(SceneTable& table, ManifestEntry& entry) {
  entry.file = table.text("file", entry.file);
  entry.item.point = table.text("point", entry.item.point);
  if (table.has_only({"file", "point", "position", "normal"})) {  // most of a long manifest
    read_position(table, entry);
    read_normal(table, entry.item);
    return;
  }
  SceneTable columns = table.table("columns", "columns");
  entry.item.read.said = said_keys(table, columns);
  read_columns(std::move(columns), entry.item.read.columns);
  read_units(table.table("units", "units"), entry.item.read.units);
  if (table.has("force_on"))
    entry.item.read.is_force_on_tool = table.choice("force_on", "", {"tool", "body"}) == "tool";
  read_position(table, entry);
  read_normal(table, entry.item);
  read_text_keys(table, entry.item.read);
  read_signal_keys(table, entry);
  table.finish();
}

}  // namespace palpate::tools
