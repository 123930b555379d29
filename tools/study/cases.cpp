#include "tools/study/cases.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <numeric>
#include <optional>
#include <sstream>

#include "libfit/core/error.hpp"
#include "libfit/core/text.hpp"
#include "libfit/io/atomic_file.hpp"
#include "libfit/io/content_hash.hpp"
#include "libfit/io/csv/csv.hpp"
#include "tools/scene/toml_table.hpp"
#include "tools/stages/fingerprint.hpp"
#include "tools/stages/prepare.hpp"

namespace palpate::tools {
namespace {

namespace fs = std::filesystem;

constexpr int kMaxCases = 1000000;
constexpr int kMaxSobol = 8;  // dimensions
constexpr std::size_t kNameDigits = 12;

// Tables of a study whose entries have names, and the section of a scene that each changes.
struct NamedTables {
  const char *key, *column, *section, *whole;  ///< whole: a key that replaces the section
};
constexpr NamedTables kNamed[] = {{"bodies", "body", "body", nullptr},
                                  {"materials", "material", "material", "law"},
                                  {"probes", "probe", "probe", "shape"}};

toml::table parse(const fs::path& path) {
  try {
    return toml::parse(read_whole_file(path), path.string());
  } catch (const toml::parse_error& e) {
    throw Error(
        fmt::format("{}:{}:{}", path.string(), e.source().begin.line, e.source().begin.column),
        std::string(e.description()), "Write it as docs/formats.md shows a study.");
  }
}

// Sets a key of a section of a section, "experiments.depth".
void set(toml::table& table, std::string_view dotted, const toml::node& value) {
  const std::size_t dot = dotted.find('.');
  if (dot == std::string_view::npos) {
    value.visit([&](const auto& v) { table.insert_or_assign(dotted, v); });
    return;
  }
  const std::string_view first = dotted.substr(0, dot);
  if (!table.get(first) || !table.get(first)->is_table())
    table.insert_or_assign(first, toml::table{});
  set(*table.get(first)->as_table(), dotted.substr(dot + 1), value);
}

// Keys of a scene that name files, made absolute.
void anchor(toml::table& scene, const fs::path& folder) {
  static constexpr std::pair<const char*, const char*> kFiles[] = {
      {"body", "surface"}, {"body", "tetmesh"}, {"probe", "mesh"}, {"experiments", "test_points"}};
  for (const auto& [section, key] : kFiles) {
    toml::table* table = scene[section].as_table();
    const auto text = table ? (*table)[key].value<std::string>() : std::nullopt;
    if (!text || (std::string_view(key) == "test_points" && !text->ends_with(".csv"))) continue;
    table->insert_or_assign(key, fs::weakly_canonical(folder / *text).string());
  }
}

std::string in_words(const toml::node& value) {
  if (value.is_string()) return value.as_string()->get();
  std::ostringstream text;
  value.visit([&](const auto& v) {
    if constexpr (requires { text << v; }) text << v;
  });
  return text.str();
}

// One step of making scenes: a word for the table, and what it changes.
struct CaseChange {
  std::string word;
  std::vector<std::pair<std::string, toml::table>> changes;  ///< dotted key; table: {"value": v}
  std::string replaced;                                      ///< a section that is emptied first
};
using Axis = std::vector<CaseChange>;

toml::table boxed(const toml::node& value) {
  toml::table box;
  set(box, "value", value);
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
    choice.word = number + from.unit;
    toml::table box;
    if (from.unit.empty())
      box.insert_or_assign("value", std::stod(number));
    else
      box.insert_or_assign("value", choice.word);
    choice.changes.emplace_back(key, std::move(box));
    return choice;
  }
};

class StudyReader {
 public:
  explicit StudyReader(const fs::path& path) : path_(fs::absolute(path)), table_(parse(path_)) {}

  Study read() {
    SceneTable top(table_, "the study", path_.string());
    Study study;
    study.path = path_;
    read_cluster(top, study.cluster);
    const fs::path base = path_.parent_path() / top.text("scene", "");
    if (!top.has("scene"))
      throw Error(top.where_table(), "names no scene that its cases start from",
                  "Add scene = \"scene.toml\".");
    base_ = parse(base);
    anchor(base_, base.parent_path());
    may_scale_ = top.boolean("scale", true);
    for (const NamedTables& named : kNamed) read_named(top, named, study.inputs);
    read_vary(top, study.inputs);
    const std::string rows = top.text("cases", "");
    top.finish();
    if (rows.empty())
      combine(study);
    else
      from_rows(path_.parent_path() / rows, study);
    finish(study);
    return study;
  }

 private:
  void read_cluster(SceneTable& top, ClusterSection& cluster) {
    if (!top.has("cluster")) return;
    SceneTable table = top.table("cluster", "[cluster]");
    cluster.task_min = table.number("task_minutes", cluster.task_min, 0.01, 1e5);
    cluster.point_min = table.number("point_minutes", 0, 0, 1e5);
    cluster.memory_MB = table.number("memory_MB", 0, 0, 1e7);
    cluster.time_factor = table.number("time_factor", cluster.time_factor, 1, 1000);
    cluster.max_array = static_cast<int>(table.integer("max_array", cluster.max_array, 1, 4000000));
    cluster.command = table.text("command", "");
    if (const toml::node* options = table.node("options"); options && options->is_array())
      for (const toml::node& option : *options->as_array())
        cluster.options.push_back(option.value_or<std::string>(""));
    table.finish();
  }

  void read_named(SceneTable& top, const NamedTables& named, std::vector<std::string>& inputs) {
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
        throw Error(top.where(named.key),
                    fmt::format("{} of {} is no table", name.str(), named.key),
                    fmt::format("Write [{}.{}].", named.key, name.str()));
      CaseChange choice{std::string(name.str()), {}, {}};
      if (named.whole && entry->get(named.whole)) choice.replaced = named.section;
      for (const auto& [key, setting] : *entry)
        choice.changes.emplace_back(key.str().find('.') == std::string_view::npos
                                        ? fmt::format("{}.{}", named.section, key.str())
                                        : std::string(key.str()),
                                    boxed(setting));
      axis.push_back(std::move(choice));
    }
    inputs.emplace_back(named.column);
    axes_.push_back(std::move(axis));
  }

  // Lists make axes of their own, ranges too unless they are sampled together.
  void read_vary(SceneTable& top, std::vector<std::string>& inputs) {
    std::vector<VariedRange> ranges;
    std::vector<std::string> range_inputs;
    if (const toml::node* node = top.node("vary")) {
      if (!node->is_table())
        throw Error(top.where("vary"), "is no table", "Write [vary] with keys of the scene.");
      for (const auto& [name, value] : *node->as_table()) {
        const std::string key(name.str());
        const std::string where =
            fmt::format("{}:{}:{}: {}", path_.string(), value.source().begin.line,
                        value.source().begin.column, key);
        if (key.find('.') == std::string::npos)
          throw Error(where, "names no section of the scene",
                      "Write section and key, such as \"material.young\".");
        if (const toml::array* list = value.as_array()) {
          Axis axis;
          for (const toml::node& item : *list) {
            CaseChange choice{in_words(item), {}, {}};
            choice.changes.emplace_back(key, boxed(item));
            axis.push_back(std::move(choice));
          }
          if (axis.empty()) throw Error(where, "is an empty list", "Give one value at least.");
          inputs.push_back(key);
          axes_.push_back(std::move(axis));
        } else if (const toml::table* range = value.as_table()) {
          ranges.push_back(read_range(key, *range, where));
          range_inputs.push_back(key);
        } else {
          throw Error(where, "is neither a list nor a range",
                      "Write [a, b, c] or { from = a, to = b, count = n }.");
        }
      }
    }
    inputs.insert(inputs.end(), range_inputs.begin(), range_inputs.end());
    if (top.has("sample"))
      sample(top.table("sample", "[sample]"), ranges);
    else
      for (const VariedRange& range : ranges) {
        if (range.count < 1)
          throw Error(path_.string(), fmt::format("{} says no count", range.key),
                      "Add count = n, or a [sample] of all ranges.");
        Axis axis;
        for (int i = 0; i < range.count; ++i)
          axis.push_back(range.at(range.count == 1 ? 0 : double(i) / (range.count - 1)));
        axes_.push_back(std::move(axis));
      }
  }

  VariedRange read_range(const std::string& key, const toml::table& table,
                         const std::string& where) {
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

  void sample(SceneTable table, const std::vector<VariedRange>& ranges) {
    const std::string method = table.choice("method", "sobol", {"sobol", "latin-hypercube"});
    const int count = static_cast<int>(table.integer("count", 0, 1, kMaxCases));
    const auto seed = static_cast<unsigned>(table.integer("seed", 1, 0, 1 << 30));
    table.finish();
    const int dimensions = static_cast<int>(ranges.size());
    if (dimensions == 0 || (method == "sobol" && dimensions > kMaxSobol))
      throw Error(table.where_table(), fmt::format("there are {} ranges to sample", dimensions),
                  fmt::format("Give 1 to {} ranges in [vary]{}.", kMaxSobol,
                              dimensions > 0 ? ", or method = \"latin-hypercube\"" : ""));
    Axis axis;
    for (const auto& point : method == "sobol" ? sobol_points(count, dimensions)
                                               : latin_hypercube(count, dimensions, seed)) {
      CaseChange all;
      for (std::size_t d = 0; d < ranges.size(); ++d) {
        CaseChange one = ranges[d].at(point[d]);
        all.word += (d ? "\t" : "") + one.word;
        all.changes.push_back(std::move(one.changes.front()));
      }
      axis.push_back(std::move(all));
    }
    axes_.push_back(std::move(axis));
  }

  void add_case(const std::vector<const CaseChange*>& choices, std::vector<std::string> inputs,
                Study& study) {
    toml::table scene = base_;
    for (const CaseChange* choice : choices) {
      if (!choice->replaced.empty()) scene.insert_or_assign(choice->replaced, toml::table{});
      for (const auto& [key, box] : choice->changes) {
        if (key == "body.tetmesh" || key == "body.surface")
          for (const char* other : {"surface", "tetmesh"}) scene["body"].as_table()->erase(other);
        set(scene, key, *box.get("value"));
      }
    }
    anchor(scene, path_.parent_path());
    std::ostringstream text;
    text << scene << "\n";
    StudyCase one;
    one.inputs = std::move(inputs);
    one.scene = text.str();
    one.name = ContentHash().add(one.scene).add(import_fingerprint()).hex().substr(0, kNameDigits);
    study.cases.push_back(std::move(one));
  }

  void combine(Study& study) {
    double total = 1;
    for (const Axis& axis : axes_) total *= static_cast<double>(axis.size());
    if (total > kMaxCases)
      throw Error(path_.string(), fmt::format("has {:.3g} cases", total),
                  fmt::format("Cut it into studies of at most {} cases.", kMaxCases));
    std::vector<std::size_t> at(axes_.size(), 0);
    for (bool is_done = false; !is_done;) {
      std::vector<const CaseChange*> choices;
      std::vector<std::string> words;
      for (std::size_t a = 0; a < axes_.size(); ++a) {
        choices.push_back(&axes_[a][at[a]]);
        std::stringstream word(choices.back()->word);  // of several sampled together: several
        for (std::string one; std::getline(word, one, '\t');) words.push_back(one);
      }
      add_case(choices, std::move(words), study);
      std::size_t a = axes_.size();
      while (a > 0 && ++at[a - 1] == axes_[a - 1].size()) at[--a] = 0;
      is_done = a == 0;
    }
  }

  // Rows of a table: named bodies, materials and probes, and other keys by their dotted names.
  void from_rows(const fs::path& path, Study& study) {
    std::ifstream file(path);
    std::string header;
    std::getline(file, header);
    std::vector<std::string> names;
    std::stringstream fields(header);
    for (std::string name; std::getline(fields, name, ',');) {
      name.erase(0, name.find_first_not_of(" \r\xef\xbb\xbf"));
      name.erase(name.find_last_not_of(" \r") + 1);
      names.push_back(name);
    }
    std::vector<CsvColumnRule> rules;
    for (const std::string& name : names) rules.push_back({name, true, true});
    const CsvTable table = read_csv(path, rules);
    const std::vector<std::string> named = std::move(study.inputs);
    study.inputs = names;
    for (std::size_t row = 0; row < table.rows(); ++row) {
      std::vector<CaseChange> own(names.size());
      std::vector<const CaseChange*> choices;
      std::vector<std::string> words;
      for (std::size_t c = 0; c < names.size(); ++c) {
        const std::string& word = words.emplace_back(table.text(names[c])[row]);
        const auto axis = std::find(named.begin(), named.end(), names[c]);
        const std::string where = file_line(path.string(), table.line[row]);
        if (axis != named.end()) {
          const Axis& entries = axes_[static_cast<std::size_t>(axis - named.begin())];
          const auto entry =
              std::find_if(entries.begin(), entries.end(),
                           [&](const CaseChange& choice) { return choice.word == word; });
          if (entry == entries.end())
            throw Error(where, fmt::format("{} \"{}\" is not in the study", names[c], word),
                        "Name one of its tables.");
          choices.push_back(&*entry);
          continue;
        }
        if (names[c].find('.') == std::string::npos)
          throw Error(where, fmt::format("column {} is no key of a scene", names[c]),
                      "Write section and key, such as material.young.");
        own[c].changes.emplace_back(names[c], value_of(word));
        choices.push_back(&own[c]);
      }
      add_case(choices, std::move(words), study);
    }
  }

  // A field of a table as TOML would have it: a number, true, false or a text.
  static toml::table value_of(const std::string& word) {
    toml::table box;
    char* end = nullptr;
    const double number = std::strtod(word.c_str(), &end);
    if (word == "true" || word == "false")
      box.insert_or_assign("value", word == "true");
    else if (word.empty() || *end != '\0')
      box.insert_or_assign("value", word);
    else if (word.find_first_not_of("-0123456789") == std::string::npos)
      box.insert_or_assign("value", static_cast<int64_t>(number));
    else
      box.insert_or_assign("value", number);
    return box;
  }

  // Reads every scene; finds bodies and samples that cases share.
  void finish(Study& study) {
    std::map<std::string, int> bodies, scaled, seen;
    std::vector<std::optional<Scene>> sources;
    for (std::size_t i = 0; i < study.cases.size(); ++i) {
      StudyCase& one = study.cases[i];
      const auto [twin, is_new] = seen.emplace(one.name, i);
      if (!is_new)
        throw Error(path_.string(),
                    fmt::format("cases {} and {} are the same scene: {}", twin->second + 1, i + 1,
                                listed(one.inputs)),
                    "Remove one of them.");
      try {
        Scene scene = parse_scene(one.scene, fs::path("scene.toml"));
        check_choices(scene);
        one.body = bodies.emplace(body_fingerprint(scene), bodies.size()).first->second;
        one.source = static_cast<int>(i);
        sources.emplace_back();
        if (!may_scale_ || scene.experiments.placement || !scene.material) continue;
        const auto [source, is_first] =
            scaled.emplace(unscaled(scene) + std::to_string(one.body), i);
        if (is_first) {
          sources.back() = std::move(scene);
          continue;
        }
        one.source = source->second;
        one.factor = force_factor(*sources[static_cast<std::size_t>(one.source)], scene);
      } catch (const Error& e) {
        throw Error(fmt::format("{}: case {} ({}): {}", path_.string(), i + 1, listed(one.inputs),
                                e.where()),
                    e.fact(), e.remedy());
      }
    }
  }

  fs::path path_;
  toml::table table_, base_;
  std::vector<Axis> axes_;
  bool may_scale_ = true;
};

}  // namespace

Study read_study(const fs::path& path) { return StudyReader(path).read(); }

}  // namespace palpate::tools
