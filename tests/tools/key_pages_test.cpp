// The keys of a manifest and a study in docs/formats are those that the program
// reads, with their values and defaults. PALPATE_WRITE_DOCS=1 writes the tables anew.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/generated_page.hpp"
#include "tests/tools/block_scene.hpp"
#include "tools/manifest/manifest.hpp"
#include "tools/study/study_folder.hpp"

namespace palpate::tools {
namespace {

using palpate::testing_support::expect_tables;
using palpate::testing_support::PageTable;

// A table of the file: its name there, and what its keys begin with in the page.
struct ReadTable {
  std::string_view name, prefix = "";
};

std::optional<std::string> cell(const std::string& text) {
  const bool is_code = text.starts_with('"') || text.starts_with("true") || text == "false";
  if (text.empty()) return std::nullopt;
  return is_code ? fmt::format("`{}`", text) : text;
}

// The rows of some tables; keys whose value is a table have rows of their own.
PageTable keys_of(const KeyLog& log, const std::vector<ReadTable>& tables) {
  PageTable out{{"key", "value", "default", "meaning"}, {}};
  for (const ReadTable& table : tables)
    for (const KeyRead& read : log)
      if (read.table == table.name && read.value != "table" && read.value != "tables")
        out.rows.push_back({fmt::format("`{}{}`", table.prefix, read.key), cell(read.value),
                            cell(read.fallback), std::nullopt});
  EXPECT_FALSE(out.rows.empty()) << tables.front().name;
  return out;
}

TEST(key_pages, manifest_lists_every_key) {
  const testing_support::Folder folder;
  KeyLog log;
  read_manifest(folder.write("manifest.toml", R"(
surface = "phantom.obj"
length_unit = "mm"
[validate]
hold_out = 5
[registration]
landmarks = [ { rig = [0, 0, 0], body = [0, 0, 0] } ]
[defaults]
force_on = "tool"
separator = "comma"
decimal = "."
force_limit = "10 N"
plausible = ["10 Pa", "5 MPa"]
probe = { shape = "sphere", friction = 0.3 }
[[recording]]
file = "press.csv"
)"),
                &log);
  expect_tables(
      "formats/manifest.md",
      {{"manifest", keys_of(log, {{"the manifest"},
                                  {"[validate]", "validate."},
                                  {"[registration]", "registration."},
                                  {"landmarks of [registration]", "registration.landmarks."}})},
       {"recording",
        keys_of(
            log,
            {{"[defaults]"}, {"columns", "columns."}, {"units", "units."}, {"probe", "probe."}})}});
}

TEST(key_pages, study_lists_every_key) {
  const testing_support::BlockFolder folder;
  KeyLog log;
  read_study(folder.write("study.toml", R"(
scene = "scene.toml"
[vary]
"material.young" = ["1 kPa", "2 kPa"]
[cluster]
command = "palpate"
)"),
             &log);
  expect_tables("formats/study.md",
                {{"study", keys_of(log, {{"the study"}, {"[cluster]", "cluster."}})}});
}

}  // namespace
}  // namespace palpate::tools
