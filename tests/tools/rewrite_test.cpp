// Values written back into a scene's text.

#include "tools/scene/canonical.hpp"

#include <gtest/gtest.h>

namespace palpate::tools {
namespace {

const std::string kText = R"(# Gewebe: weich (±5 %)
title = "µ"   # kept
[material]    # ours
law = "yeoh" # of Yeoh
c10 = "2 kPa" # first
c20 = 15     # a plain number
[body]
surface = "leber.stl"
)";

TEST(Rewrite, replaces_values_alone) {
  const std::string found =
      rewritten(kText, "scene.toml",
                {{"material", "c20", "\"31.5 Pa\""}, {"material", "c10", "\"1.75 kPa\""}});
  std::string expected = kText;
  expected.replace(expected.find("15 "), 2, "\"31.5 Pa\"");
  expected.replace(expected.find("\"2 kPa\""), 7, "\"1.75 kPa\"");
  EXPECT_EQ(found, expected);
}

TEST(Rewrite, adds_a_key_that_is_missing_behind_its_section) {
  const std::string found = rewritten(kText, "scene.toml", {{"material", "c30", "4"}});
  std::string expected = kText;
  const std::string last = "# a plain number\n";
  expected.insert(expected.find(last) + last.size(), "c30 = 4\n");
  EXPECT_EQ(found, expected);
  EXPECT_EQ(rewritten("material = { young = 3 } # x\n", "s", {{"material", "poisson", "0.4"}}),
            "material = { young = 3, poisson = 0.4 } # x\n");
  EXPECT_EQ(rewritten("[material]\nyoung = 3", "s", {{"material", "poisson", "0.4"}}),
            "[material]\nyoung = 3\npoisson = 0.4");
}

TEST(Rewrite, names_files_of_a_scene_absolutely) {
  const auto files = absolute_files(
      "[body]\nsurface = \"a/b.stl\"\n[experiments]\ntest_points = 4\n", "/data/scene.toml");
  ASSERT_EQ(files.size(), 1u);
  EXPECT_EQ(files[0].section + "." + files[0].key, "body.surface");
  EXPECT_EQ(files[0].value, "/data/a/b.stl");
  EXPECT_EQ(quoted("a\"b\\c"), "\"a\\\"b\\\\c\"");
}

}  // namespace
}  // namespace palpate::tools
