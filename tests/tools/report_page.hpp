// The page of `palpate report` on a small run, in Chromium and Node where they are there.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/tools/kept_run.hpp"

namespace palpate::tools {

using namespace testing_support;

inline constexpr const char* kBegin = "<script type=\"application/json\" id=\"contents\">";

class Report : public KeptRun {
 protected:
  static Outcome report(const std::string& arguments) {
    return palpate(*folder_, "report " + arguments);
  }
  static nlohmann::json contents_of(const std::string& report) {
    const std::string page = content_of(report);
    const std::size_t begin = page.find(kBegin) + std::strlen(kBegin);
    return nlohmann::json::parse(page.substr(begin, page.find("</script>", begin) - begin));
  }
  // Where the page was built with npm's packages; "" where it was not.
  static std::string modules() {
    return fs::exists(fs::path(PALPATE_PAGE_DIR) / "page.html") ? PALPATE_PAGE_DIR : "";
  }
  static bool has_engine() { return fs::exists(fs::path(PALPATE_PAGE_DIR) / "engine.wasm"); }

  static Outcome node(const std::string& script, const std::string& arguments) {
    return shell(*folder_, "node " PALPATE_SOURCE_DIR "/tests/tools/page/" + script + " " +
                               modules() + " " + arguments + " 2>&1");
  }
  // A claim of browser.mjs about the report of a folder, the block's if none is given.
  static void expect_in_chromium(const std::string& claim, const std::string& output,
                                 const std::string& folder = "out") {
    ASSERT_EQ(report(folder + " -o report.html").status, 0);
    const Outcome seen = node("browser.mjs", claim + " " + path("report.html") + " " + output);
    EXPECT_EQ(seen.status, 0) << seen.out;
  }
  // Three numbers of each row, from the named column on.
  static std::vector<std::array<double, 3>> vectors(const fs::path& csv, const std::string& name) {
    std::istringstream rows(content_of(csv));
    std::string line;
    std::getline(rows, line);
    const auto before = line.substr(0, line.find(name));
    const auto first = std::count(before.begin(), before.end(), ',');
    std::vector<std::array<double, 3>> out;
    while (std::getline(rows, line)) {
      std::istringstream fields(line);
      std::string field;
      for (long k = 0; k < first; ++k) std::getline(fields, field, ',');
      for (double& value : out.emplace_back()) {
        std::getline(fields, field, ',');
        value = std::stod(field);
      }
    }
    return out;
  }
  // Forces that a native replay gives along a path, against those in another table.
  static void expect_native_forces(const std::string& path_csv, const fs::path& forces_csv) {
    const Outcome replay =
        palpate(*folder_, "replay out/asset.palp " + path_csv + " -o native.csv");
    ASSERT_EQ(replay.status, 0) << replay.err;
    const auto native = vectors(path("native.csv"), "fx_N"), other = vectors(forces_csv, "fx_N");
    ASSERT_EQ(native.size(), other.size());
    std::size_t touching = 0, differing = 0;
    for (std::size_t i = 0; i < native.size(); ++i) {
      touching += native[i] != std::array<double, 3>{};
      differing += native[i] != other[i];
    }
    EXPECT_GT(touching, native.size() / 10) << "of " << native.size();
    EXPECT_EQ(differing, 0u) << "of " << native.size();
  }
};

#define SKIP_WITHOUT_PAGE() \
  if (modules().empty()) GTEST_SKIP() << "no page was built (Node.js with npm's packages)"
#define SKIP_WITHOUT_ENGINE() \
  SKIP_WITHOUT_PAGE();        \
  if (!has_engine()) GTEST_SKIP() << "no engine in the page (clang++ makes no WebAssembly)"
#define SKIP_WITHOUT_CHROMIUM() \
  SKIP_WITHOUT_ENGINE();        \
  if (!fs::exists("/usr/bin/chromium")) GTEST_SKIP() << "no Chromium (package chromium)"

}  // namespace palpate::tools
