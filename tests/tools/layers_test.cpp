// Includes point only downward through the layers (docs/architecture.md).

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;

// Which layers a layer may include; its own always, nested folders with their parents.
const std::map<std::string, std::set<std::string>> kAllowed{
    {"libfit/runtime", {}},
    {"libfit/core", {"libfit/runtime"}},
    {"libfit/io", {"libfit/core", "libfit/runtime"}},
    {"libfit/fit", {"libfit/core", "libfit/runtime"}},
    {"libfit/refine", {"libfit/core", "libfit/runtime"}},
    {"libfit/assets", {"libfit/core", "libfit/runtime", "libfit/io"}},
    {"libfit/recordings", {"libfit/core", "libfit/io", "libfit/refine"}},
    {"libfem/probes", {"libfit/core"}},
    {"libfem/mesh", {"libfit/core"}},
    {"libfem/materials", {"libfit/core"}},
    {"libfem/contact", {"libfit/core", "libfem/probes"}},
    {"libfem/solve",
     {"libfit/core", "libfem/probes", "libfem/mesh", "libfem/materials", "libfem/contact"}},
    {"tools",
     {"libfit/core", "libfit/runtime", "libfit/io", "libfit/fit", "libfit/refine", "libfit/assets",
      "libfit/recordings", "libfem/probes", "libfem/mesh", "libfem/materials", "libfem/contact",
      "libfem/solve"}},
    {"data", {"libfit/core", "libfem/mesh"}},
};

std::string layer_of(const std::string& path) {
  for (const auto& [layer, allowed] : kAllowed)
    if (path.rfind(layer + "/", 0) == 0) return layer;
  return {};
}

struct Include {
  std::string file, layer, target;
};

std::vector<Include> all_includes() {
  static const std::regex pattern(R"re(^\s*#\s*include\s*["<]([^">]+)[">])re");
  std::vector<Include> includes;
  for (const char* top : {"libfit", "libfem", "tools", "data"}) {
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(PALPATE_SOURCE_DIR) / top)) {
      const auto extension = entry.path().extension();
      if (extension != ".cpp" && extension != ".hpp" && extension != ".h") continue;
      const std::string file = fs::relative(entry.path(), PALPATE_SOURCE_DIR).generic_string();
      std::ifstream stream(entry.path());
      for (std::string line; std::getline(stream, line);) {
        std::smatch match;
        if (std::regex_search(line, match, pattern))
          includes.push_back({file, layer_of(file), match[1]});
      }
    }
  }
  return includes;
}

TEST(layers, every_source_file_belongs_to_a_layer) {
  for (const Include& include : all_includes()) EXPECT_NE(include.layer, "") << include.file;
}

TEST(layers, includes_point_only_downward) {
  for (const Include& include : all_includes()) {
    const std::string target = layer_of(include.target);
    if (target.empty() || target == include.layer) continue;
    EXPECT_TRUE(kAllowed.at(include.layer).count(target))
        << include.file << " includes " << include.target;
  }
}

TEST(layers, the_engine_includes_nothing_but_itself_and_the_standard_library) {
  static const std::set<std::string> kStandard{"cstddef",     "cstdint",  "cstring", "cmath",
                                               "type_traits", "cstdio",   "vector",  "limits",
                                               "cstdlib",     "stddef.h", "stdint.h"};
  for (const Include& include : all_includes()) {
    if (include.layer != "libfit/runtime") continue;
    const bool is_here = include.target.find('/') == std::string::npos ||
                         include.target.starts_with("families/") ||
                         include.target.starts_with("../");
    const bool is_own =
        is_here && (include.target.ends_with(".hpp") || include.target.ends_with(".h"));
    EXPECT_TRUE(is_own || kStandard.count(include.target) ||
                include.target.rfind("libfit/runtime/", 0) == 0)
        << include.file << " includes " << include.target;
  }
}

TEST(layers, includes_start_at_the_repository_root) {
  for (const Include& include : all_includes()) {
    if (include.layer == "libfit/runtime") continue;  // copied out as a folder, so relative there
    const bool is_relative = include.target.rfind(".", 0) == 0;
    EXPECT_FALSE(is_relative) << include.file << " includes " << include.target;
  }
}

}  // namespace
