// Includes point only downward, between layers and between the rooms of a layer
// (docs/architecture.md).

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/sources.hpp"

namespace {

namespace fs = std::filesystem;

/// A folder, or a file by its name without extension, and what it may include besides itself. A row
/// names only rows above it, so that the table has no circle.
struct Row {
  std::string name;
  std::vector<std::string> below;
};

const std::vector<Row> kLayers{
    {"libfit/runtime", {}},
    {"libfit/core", {"libfit/runtime/base", "libfit/runtime/law"}},
    {"libfit/io", {"libfit/core", "libfit/runtime"}},
    {"libfit/fit", {"libfit/core", "libfit/experiments", "libfit/runtime"}},
    {"libfit/refine", {"libfit/core", "libfit/runtime"}},
    {"libfit/assets", {"libfit/core", "libfit/runtime", "libfit/io", "libfit/shape"}},
    {"libfit/shape", {"libfit/core", "libfit/experiments", "libfit/runtime"}},
    {"libfit/recordings", {"libfit/core", "libfit/io", "libfit/refine"}},
    {"libfit/experiments", {"libfit/core", "libfit/runtime"}},
    {"libfit/validation",
     {"libfit/core", "libfit/experiments", "libfit/runtime", "libfit/io", "libfit/fit",
      "libfit/refine", "libfit/assets", "libfit/shape"}},
    {"libfit/scan", {"libfit/core", "libfit/runtime", "libfit/experiments", "libfit/assets"}},
    {"libfit/certify", {"libfit/runtime"}},
    {"libfem/probes", {"libfit/core", "libfem/mesh"}},
    {"libfem/materials", {"libfit/core"}},
    {"libfem/mesh", {"libfit/core"}},
    {"libfem/contact", {"libfit/core", "libfem/probes"}},
    {"libfem/elements", {"libfit/core", "libfem/materials", "libfem/mesh"}},
    {"libfem/solve",
     {"libfit/core", "libfem/probes", "libfem/materials", "libfem/mesh", "libfem/contact",
      "libfem/elements"}},
    {"libfem/calibrate", {"libfit/core", "libfem/probes", "libfem/materials", "libfem/solve"}},
    {"data/generators", {"libfit/core", "libfem/mesh"}},
    {"tools", {"libfit/core",       "libfit/experiments", "libfit/runtime",    "libfit/io",
               "libfit/fit",        "libfit/refine",      "libfit/assets",     "libfit/shape",
               "libfit/recordings", "libfit/scan",        "libfit/validation", "libfit/certify",
               "libfem/probes",     "libfem/materials",   "libfem/mesh",       "libfem/contact",
               "libfem/elements",   "libfem/solve",       "libfem/calibrate",  "data/generators"}},
};

const std::vector<Row> kRooms{
    {"tools/build_identity", {}},
    {"tools/console", {}},
    {"tools/outputs", {}},
    {"tools/scene", {}},
    {"tools/command", {"tools/build_identity", "tools/console", "tools/outputs", "tools/scene"}},
    {"tools/manifest", {"tools/scene"}},
    {"tools/stages/fingerprint", {"tools/build_identity", "tools/scene"}},
    {"tools/stages/fit", {"tools/console", "tools/scene"}},
    {"tools/stages/body", {"tools/console", "tools/scene"}},
    {"tools/stages/samples",
     {"tools/console", "tools/outputs", "tools/scene", "tools/stages/fingerprint",
      "tools/stages/fit", "tools/stages/body"}},
    {"tools/stages",
     {"tools/console", "tools/outputs", "tools/scene", "tools/manifest", "tools/stages/fingerprint",
      "tools/stages/fit", "tools/stages/body", "tools/stages/samples"}},
    {"tools/setup",
     {"tools/console", "tools/scene", "tools/manifest", "tools/stages/body", "tools/stages/samples",
      "tools/stages"}},
    {"tools/study",
     {"tools/build_identity", "tools/console", "tools/outputs", "tools/scene",
      "tools/stages/fingerprint", "tools/stages/body", "tools/stages/samples", "tools/stages",
      "tools/setup"}},
    {"tools/realtime", {"tools/console"}},
    {"tools/report", {"tools/scene"}},
    {"tools/page", {}},
    {"tools/python", {}},
    {"tools/commands",
     {"tools/command", "tools/console", "tools/scene", "tools/manifest", "tools/stages/fingerprint",
      "tools/stages/fit", "tools/stages/body", "tools/stages/samples", "tools/stages",
      "tools/setup", "tools/study", "tools/realtime", "tools/report", "tools/outputs"}},
    {"tools/main", {"tools/command"}},
    {"tools/workshop",
     {"tools/command", "tools/console", "tools/scene", "tools/stages/fit", "tools/stages/body",
      "tools/report", "tools/page"}},

    {"libfit/runtime/palpate.h", {}},
    {"libfit/runtime/base", {}},
    {"libfit/runtime/law", {"libfit/runtime/base"}},
    {"libfit/runtime/asset", {"libfit/runtime/base", "libfit/runtime/law"}},
    {"libfit/runtime/surface",
     {"libfit/runtime/base", "libfit/runtime/law", "libfit/runtime/asset",
      "libfit/runtime/palpate.h"}},
    {"libfit/runtime/contact",
     {"libfit/runtime/base", "libfit/runtime/law", "libfit/runtime/asset",
      "libfit/runtime/surface"}},
    {"libfit/runtime/series",
     {"libfit/runtime/base", "libfit/runtime/law", "libfit/runtime/asset", "libfit/runtime/surface",
      "libfit/runtime/contact"}},
    {"libfit/runtime/tool",
     {"libfit/runtime/base", "libfit/runtime/law", "libfit/runtime/asset", "libfit/runtime/surface",
      "libfit/runtime/contact", "libfit/runtime/series"}},
    {"libfit/runtime/asset.hpp", {"libfit/runtime/asset", "libfit/runtime/series"}},
    {"libfit/runtime/engine",
     {"libfit/runtime/asset", "libfit/runtime/contact", "libfit/runtime/series",
      "libfit/runtime/tool", "libfit/runtime/asset.hpp"}},
    {"libfit/runtime/example", {"libfit/runtime/engine"}},
    {"libfit/runtime/once", {"libfit/runtime/engine"}},
    {"libfit/runtime/palpate", {"libfit/runtime/engine", "libfit/runtime/palpate.h"}},

    {"libfit/io/hdf5", {"libfit/io"}},
    {"libfit/io/csv", {"libfit/io"}},
    {"libfit/io/files", {"libfit/io", "libfit/io/hdf5"}},

    {"libfit/fit/fit_curves.hpp", {}},
    {"libfit/fit/spline", {"libfit/fit/fit_curves.hpp"}},
    {"libfit/fit/rows", {"libfit/fit/fit_curves.hpp", "libfit/fit/spline"}},
    {"libfit/fit/point", {"libfit/fit/fit_curves.hpp", "libfit/fit/spline", "libfit/fit/rows"}},
    {"libfit/fit",
     {"libfit/fit/fit_curves.hpp", "libfit/fit/spline", "libfit/fit/rows", "libfit/fit/point"}},

    {"libfit/recordings/formats", {}},
    {"libfit/recordings/signal", {"libfit/recordings/formats"}},
    {"libfit/recordings/contact_point", {"libfit/recordings/formats", "libfit/recordings/signal"}},
    {"libfit/recordings/relaxation", {"libfit/recordings/formats", "libfit/recordings/signal"}},
    {"libfit/recordings/batch",
     {"libfit/recordings/formats", "libfit/recordings/signal", "libfit/recordings/contact_point",
      "libfit/recordings/relaxation"}},
    {"libfit/recordings/placing",
     {"libfit/recordings/formats", "libfit/recordings/signal", "libfit/recordings/contact_point",
      "libfit/recordings/relaxation", "libfit/recordings/batch"}},

    {"libfem/mesh/read", {"libfem/mesh"}},
    {"libfem/mesh/repair", {"libfem/mesh"}},
    {"libfem/mesh/surface", {"libfem/mesh", "libfem/mesh/repair"}},
    {"libfem/mesh/fill", {"libfem/mesh", "libfem/mesh/repair", "libfem/mesh/surface"}},
    {"libfem/mesh/grade", {"libfem/mesh", "libfem/mesh/surface"}},

    {"libfem/solve/factor", {}},
    {"libfem/solve/equilibrium", {"libfem/solve/factor"}},
    {"libfem/solve/experiments", {"libfem/solve/factor", "libfem/solve/equilibrium"}},
};

bool is_in(const std::string& path, const std::string& room) {
  if (path.rfind(room, 0) != 0) return false;
  return path.size() == room.size() || path[room.size()] == '/' || path[room.size()] == '.';
}

// Longest name that holds the path; empty where none does.
std::string row_of(const std::vector<Row>& rows, const std::string& path) {
  std::string found;
  for (const Row& row : rows)
    if (is_in(path, row.name) && row.name.size() > found.size()) found = row.name;
  return found;
}

// A file of a layer beside its rooms stands in the layer's own folder.
std::string room_of(const std::string& path) {
  const std::string room = row_of(kRooms, path);
  return room.empty() ? row_of(kLayers, path) : room;
}

const std::vector<std::string>& below(const std::vector<Row>& rows, const std::string& name) {
  return std::find_if(rows.begin(), rows.end(), [&](const Row& row) { return row.name == name; })
      ->below;
}

// Whether a layer may include the file: those below it with all that is in them.
bool may_reach(const std::string& layer, const std::string& file) {
  const auto& names = below(kLayers, layer);
  return std::any_of(names.begin(), names.end(),
                     [&](const std::string& name) { return is_in(file, name); });
}

// Whether a room may include another: those below it without what is nested in them.
bool may_enter(const std::string& room, const std::string& other) {
  for (const Row& row : kRooms)
    if (row.name == room)
      return std::find(row.below.begin(), row.below.end(), other) != row.below.end();
  return false;  // a layer's own folder is below its rooms, unless it has a row
}

struct Include {
  std::string file, target;
  std::string place;  ///< of what it includes, from the root; the target where that is not ours
  bool is_quoted;
};

std::vector<Include> read_includes() {
  static const std::regex pattern(R"re(^\s*#\s*include\s*(["<])([^">]+)[">])re");
  std::vector<Include> includes;
  for (const auto& [file, text] : palpate::testing_support::source_files(
           {"libfit", "libfem", "tools", "data"}, {".cpp", ".hpp", ".h", ".inc"})) {
    std::istringstream stream(text);
    for (std::string line; std::getline(stream, line);) {
      std::smatch match;
      if (!std::regex_search(line, match, pattern)) continue;
      const std::string target = match[2];
      const fs::path beside = fs::path(file).parent_path() / target;
      const bool is_beside = match[1] == "\"" && fs::exists(fs::path(PALPATE_SOURCE_DIR) / beside);
      includes.push_back({file, target,
                          is_beside ? beside.lexically_normal().generic_string() : target,
                          match[1] == "\""});
    }
  }
  return includes;
}

const std::vector<Include>& all_includes() {
  static const std::vector<Include> includes = read_includes();
  return includes;
}

TEST(layers, every_source_file_belongs_to_a_layer) {
  std::set<std::string> strays;
  for (const Include& include : all_includes())
    if (row_of(kLayers, include.file).empty()) strays.insert(include.file);
  for (const std::string& file : strays) ADD_FAILURE() << file;
}

TEST(layers, tables_have_no_circle_and_no_stale_row) {
  const fs::path root(PALPATE_SOURCE_DIR);
  for (const auto* rows : {&kLayers, &kRooms}) {
    std::set<std::string> above;
    for (const Row& row : *rows) {
      for (const std::string& name : row.below) {
        const bool is_ground = row_of(kRooms, name).empty() && !row_of(kLayers, name).empty();
        const bool is_room_below = rows == &kLayers && above.count(row_of(kLayers, name)) > 0;
        EXPECT_TRUE(above.count(name) || is_ground || is_room_below)
            << row.name << " may include " << name;
      }
      above.insert(row.name);
      EXPECT_TRUE(fs::exists(root / row.name) || fs::exists(root / (row.name + ".cpp")) ||
                  fs::exists(root / (row.name + ".hpp")))
          << row.name;
    }
  }
}

TEST(layers, includes_point_only_downward) {
  for (const Include& include : all_includes()) {
    const std::string from = row_of(kLayers, include.file), to = row_of(kLayers, include.place);
    if (to.empty() || to == from) continue;
    EXPECT_TRUE(to != "data/generators" || is_in(include.file, "tools/workshop")) << include.file;
    EXPECT_TRUE(may_reach(from, include.place)) << include.file << " includes " << include.place;
  }
}

TEST(layers, includes_point_only_downward_within_a_layer) {
  for (const Include& include : all_includes()) {
    if (row_of(kLayers, include.file) != row_of(kLayers, include.place)) continue;
    const std::string from = room_of(include.file), to = room_of(include.place);
    if (to == from) continue;
    EXPECT_TRUE(may_enter(from, to)) << include.file << " includes " << include.place;
  }
}

TEST(layers, nothing_outside_the_workshop_includes_it) {
  for (const Include& include : all_includes()) {
    if (is_in(include.file, "tools/workshop")) continue;
    EXPECT_FALSE(is_in(include.place, "tools/workshop"))
        << include.file << " includes " << include.place;
  }
}

TEST(layers, the_engine_includes_nothing_but_itself_and_the_standard_library) {
  static const std::set<std::string> kStandard{
      "cstddef", "cstdint", "cstring", "cmath",    "utility",  "type_traits", "cstdio",
      "vector",  "limits",  "cstdlib", "stddef.h", "stdint.h", "new",         "concepts"};
  const fs::path root(PALPATE_SOURCE_DIR), engine = root / "libfit/runtime";
  for (const Include& include : all_includes()) {
    if (row_of(kLayers, include.file) != "libfit/runtime") continue;
    const fs::path beside = (root / include.file).parent_path() / include.target;
    const bool is_own =
        include.is_quoted && fs::exists(beside) && *fs::relative(beside, engine).begin() != "..";
    EXPECT_TRUE(is_own || kStandard.count(include.target))
        << include.file << " includes " << include.target;
  }
}

// One name for one thing. The two families' Excess is one: what a slip of theirs brings to zero.
TEST(layers, a_type_name_is_defined_once) {
  static const std::regex pattern(
      R"re(^\s*(?:struct|class|enum|enum class) (\w+)(?: final)?(?: :[^:;{(][^;{(]*)? \{)re");
  std::map<std::string, std::string> defined;
  for (const auto& [file, text] :
       palpate::testing_support::source_files({"libfit", "libfem", "tools"}, {".hpp", ".cpp"})) {
    std::istringstream stream(text);
    std::smatch match;
    for (std::string line; std::getline(stream, line);) {
      if (!std::regex_search(line, match, pattern) || match[1] == "Excess") continue;
      const auto [first, is_new] = defined.emplace(match[1], file);
      EXPECT_TRUE(is_new) << match[1] << " in " << file << " and " << first->second;
    }
  }
  EXPECT_GT(defined.size(), 300);
}

TEST(layers, includes_start_at_the_repository_root) {
  for (const Include& include : all_includes()) {
    if (row_of(kLayers, include.file) == "libfit/runtime") continue;  // copied out as a folder
    EXPECT_NE(include.target.front(), '.') << include.file << " includes " << include.target;
  }
}

}  // namespace
