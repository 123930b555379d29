#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <sstream>

#include "libfit/core/error.hpp"
#include "libfit/core/text.hpp"
#include "libfit/io/atomic_file.hpp"
#include "libfit/io/csv/csv.hpp"
#include "tools/scene/canonical.hpp"
#include "tools/scene/toml_table.hpp"
#include "tools/stages/fingerprint.hpp"
#include "tools/stages/stage_table.hpp"
#include "tools/study/study_folder.hpp"

namespace palpate::tools {
namespace {

namespace fs = std::filesystem;

toml::table parse_study(const fs::path& path) {
  return parse_toml(read_whole_file(path), path.string(),
                    "Write it as docs/formats/study.md shows a study.");
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
  for (const auto& [section, key] : kSceneFiles) {
    toml::table* table = scene[section].as_table();
    const auto text = table ? (*table)[key].value<std::string>() : std::nullopt;
    if (!text || text->starts_with('$') ||
        (std::string_view(key) == "test_points" && !text->ends_with(".csv")))
      continue;
    table->insert_or_assign(key, fs::weakly_canonical(folder / *text).string());
  }
}

class StudyReader {
 public:
  StudyReader(const fs::path& path, KeyLog* log)
      : path_(fs::absolute(path)), table_(parse_study(path_)), log_(log) {}

  Study read() {
    SceneTable top(table_, "the study", path_.string(), log_);
    Study study;
    study.path = path_;
    read_cluster(top, study.cluster);
    const fs::path base =
        path_.parent_path() / top.required_text("scene", "names no scene that its cases start from",
                                                "Add scene = \"scene.toml\".");
    base_ = parse_study(base);
    anchor(base_, base.parent_path());
    Axes varied = read_axes(top, path_.string());
    axes_ = std::move(varied.axis);
    study.inputs = std::move(varied.inputs);
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
    cluster.command = table.text("command", "");
    if (const toml::node* options = table.node("options"); options && options->is_array())
      for (const toml::node& option : *options->as_array())
        cluster.options.push_back(option.value_or<std::string>(""));
    table.finish();
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
    one.name = ContentHash().add(one.scene).add(import_fingerprint()).hex().substr(0, 12);
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
        words.insert(words.end(), choices.back()->words.begin(), choices.back()->words.end());
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
          const Axis& entries = axes_[axis - named.begin()];
          const auto entry =
              std::find_if(entries.begin(), entries.end(),
                           [&](const CaseChange& choice) { return choice.words.front() == word; });
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

  // Reads every scene; finds bodies that cases share.
  void finish(Study& study) {
    std::map<std::string, int> bodies, seen;
    for (std::size_t i = 0; i < study.cases.size(); ++i) {
      StudyCase& one = study.cases[i];
      const auto [twin, is_new] = seen.emplace(one.name, i);
      if (!is_new)
        throw Error(path_.string(),
                    fmt::format("cases {} and {} are the same scene: {}", twin->second + 1, i + 1,
                                listed(one.inputs)),
                    "Remove one of them.");
      try {
        const Scene scene = parse_scene(one.scene, fs::path("scene.toml"));
        check_choices(scene);
        one.body = bodies.emplace(body_fingerprint(scene), bodies.size()).first->second;
      } catch (const Error& e) {
        throw Error(fmt::format("{}: case {} ({}): {}", path_.string(), i + 1, listed(one.inputs),
                                e.where()),
                    e.fact(), e.remedy());
      }
    }
  }

  fs::path path_;
  toml::table table_, base_;
  KeyLog* log_;
  std::vector<Axis> axes_;
};

}  // namespace

Study read_study(const fs::path& path, KeyLog* log) { return StudyReader(path, log).read(); }

}  // namespace palpate::tools
