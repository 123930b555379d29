// Bad input: a clear error with its place and remedy, exit status 1, and nothing written.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include <ostream>

#include "tests/tools/command_line.hpp"

namespace palpate::tools {
namespace {

using namespace testing_support;

TEST(usage, help_and_version_have_status_0) {
  const Folder folder;
  EXPECT_EQ(palpate(folder, "--help").status, 0);
  EXPECT_EQ(palpate(folder, "simulate --help").status, 0);
  EXPECT_EQ(palpate(folder, "--version").out, "palpate 0.2.0\n");
  EXPECT_EQ(palpate(folder, "-V").out, "palpate 0.2.0\n");
}

TEST(usage, wrong_usage_is_an_object_with_json) {
  const Folder folder;
  for (const auto& [line, command] : {std::pair{"fly --json", ""},
                                      {"run a.toml -o x --fast --json", "run"},
                                      {"run --json", "run"}}) {
    SCOPED_TRACE(line);
    const Outcome outcome = palpate(folder, line);
    EXPECT_EQ(outcome.status, 2);
    const auto json = nlohmann::json::parse(outcome.out, nullptr, false);
    ASSERT_TRUE(json.is_object()) << outcome.out;
    EXPECT_EQ(json.at("command"), command);
    EXPECT_TRUE(holds(outcome.err, json.at("errors").at(0).at("what")));
  }
}

TEST(usage, help_lists_commands_by_group_with_an_example_each) {
  const Folder folder;
  const std::string list = palpate(folder, "--help").out;
  std::size_t at = 0;
  for (const char* group :
       {"Start:", "Stages of a run:", "Recordings:", "Assets and files:", "Studies:"}) {
    const std::size_t found = list.find(group);
    EXPECT_GT(found, at) << group;
    at = found;
  }
  EXPECT_TRUE(holds(list, "palpate help COMMAND"));
  EXPECT_TRUE(holds(palpate(folder, "help new").out, "Example:\n  palpate new organ.stl"));
}

TEST(usage, help_of_a_command_is_asked_for_either_way) {
  const Folder folder;
  for (const std::string command : {"", "fit", "study"}) {
    const Outcome asked = palpate(folder, "help " + command);
    EXPECT_EQ(asked.status, 0) << asked.err;
    EXPECT_EQ(asked.out, palpate(folder, command + " --help").out);
  }
  const Outcome misspelt = palpate(folder, "help simulat");
  EXPECT_EQ(misspelt.status, 2);
  EXPECT_TRUE(holds(misspelt.err, "Did you mean \"simulate\"?"));
}

}  // namespace
}  // namespace palpate::tools
