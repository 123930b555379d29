#include "tools/study/study_folder.hpp"

#include <fmt/format.h>

#include <boost/random/sobol.hpp>
#include <cmath>
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

// "2 kPa", 0.3: a number and what follows it.
struct Amount {
  double number = 0;
  std::string unit;
};

Amount amount_of(const toml::node* node, const std::string& where) {
  if (node && node->is_number()) return {*node->value<double>(), ""};
  const auto text = node ? node->value<std::string>() : std::nullopt;
  std::size_t end = 0;
  try {
    if (text) return {std::stod(*text, &end), text->substr(end)};
  } catch (const std::exception&) {
  }
  throw Error(where, "has no number as from or to", "Write { from = \"2 kPa\", to = \"20 kPa\" }.");
}

// A key that goes from one amount to another.
struct VariedRange {
  std::string key;
  Amount from, to;
  bool is_log = false;
  int count = 0;

  CaseChange at(double share) const {
    const double x = is_log ? from.number * std::pow(to.number / from.number, share)
                            : from.number + share * (to.number - from.number);
    const std::string number = fmt::format("{:.6g}", x);
    CaseChange choice;
    choice.words = {number + from.unit};
    toml::table box;
    if (from.unit.empty())
      box.insert_or_assign("value", std::stod(number));
    else
      box.insert_or_assign("value", choice.words.front());
    choice.changes.emplace_back(key, std::move(box));
    return choice;
  }
};

VariedRange read_range(const std::string& key, const toml::table& table, const std::string& where) {
  VariedRange range{key, amount_of(table.get("from"), where), amount_of(table.get("to"), where),
                    false, static_cast<int>(table["count"].value_or<int64_t>(0))};
  const std::string spacing = table["spacing"].value_or<std::string>("linear");
  range.is_log = spacing == "log";
  for (const auto& [name, _] : table)
    if (name.str() != "from" && name.str() != "to" && name.str() != "count" &&
        name.str() != "spacing")
      throw Error(where, fmt::format("{} is no key of a range", name.str()),
                  "Its keys are from, to, count and spacing.");
  if (range.from.unit != range.to.unit)
    throw Error(where, "goes from one unit to another", "Write from and to in the same unit.");
  if (spacing != "linear" && !range.is_log)
    throw Error(where, fmt::format("spacing \"{}\" is not known", spacing), "Use linear or log.");
  if (range.is_log && !(range.from.number > 0 && range.to.number > 0))
    throw Error(where, "has no logarithm", "Give positive ends, or spacing = \"linear\".");
  return range;
}

Axis sampled(SceneTable table, const std::vector<VariedRange>& ranges) {
  const long count = table.integer("count", 0, 1, kMaxCases);
  table.finish();
  if (ranges.empty())
    throw Error(table.where_table(), "there is no range to sample", "Give ranges in [vary].");
  // The first points of the sequence after 0.
  boost::random::sobol_engine<std::uint32_t, 32> sequence(ranges.size());
  Axis axis;
  for (long i = 0; i < count; ++i) {
    CaseChange all;
    for (const VariedRange& range : ranges) {
      CaseChange one = range.at(sequence() / 0x1p32);
      all.words.push_back(one.words.front());
      all.changes.push_back(std::move(one.changes.front()));
    }
    axis.push_back(std::move(all));
  }
  return axis;
}

// Lists make axes of their own, ranges too unless they are sampled together.
void read_vary(SceneTable& top, const std::string& file, Axes& out) {
  std::vector<VariedRange> ranges;
  std::vector<std::string> range_inputs;
  if (const toml::node* node = top.node("vary")) {
    if (!node->is_table())
      throw Error(top.where("vary"), "is no table", "Write [vary] with keys of the scene.");
    for (const auto& [name, value] : *node->as_table()) {
      const std::string key(name.str());
      const std::string where = fmt::format("{}:{}:{}: {}", file, value.source().begin.line,
                                            value.source().begin.column, key);
      if (key.find('.') == std::string::npos)
        throw Error(where, "names no section of the scene",
                    "Write section and key, such as \"material.young\".");
      if (const toml::array* list = value.as_array()) {
        Axis axis;
        for (const toml::node& item : *list) {
          CaseChange choice{{in_words(item)}, {}, {}};
          choice.changes.emplace_back(key, boxed(item));
          axis.push_back(std::move(choice));
        }
        if (axis.empty()) throw Error(where, "is an empty list", "Give one value at least.");
        out.inputs.push_back(key);
        out.axis.push_back(std::move(axis));
      } else if (const toml::table* range = value.as_table()) {
        ranges.push_back(read_range(key, *range, where));
        range_inputs.push_back(key);
      } else {
        throw Error(where, "is neither a list nor a range",
                    "Write [a, b, c] or { from = a, to = b, count = n }.");
      }
    }
  }
  out.inputs.insert(out.inputs.end(), range_inputs.begin(), range_inputs.end());
  if (top.has("sample"))
    out.axis.push_back(sampled(top.table("sample", "[sample]"), ranges));
  else
    for (const VariedRange& range : ranges) {
      if (range.count < 1)
        throw Error(file, fmt::format("{} says no count", range.key),
                    "Add count = n, or a [sample] of all ranges.");
      Axis axis;
      for (int i = 0; i < range.count; ++i)
        axis.push_back(range.at(range.count == 1 ? 0 : double(i) / (range.count - 1)));
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
