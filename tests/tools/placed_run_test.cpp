// Points that place themselves, and the statement an asset carries, as a user runs it.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/tools/block_scene.hpp"
#include "tests/tools/command_line.hpp"

namespace palpate::tools {
namespace {

using namespace testing_support;

class PlacedRun : public BlockRun {};

// A round adds half as many points, at most to the budget; a tolerance of 0 spends it.
std::string automatic_scene(int budget) {
  std::string text =
      replaced(kScene, "test_points = 4",
               "test_points = \"auto\"\ntolerance = 0\nbudget = " + std::to_string(budget));
  text = replaced(text, "drag_depths = [\"3 mm\"]", "drag_depths = []");
  text = replaced(text, "press_steps = 5", "press_steps = 3");
  return replaced(text, "[[\"20 mm\", \"20 mm\"", "[[\"9 mm\", \"9 mm\"");
}

TEST_F(PlacedRun, automatic_points_are_added_to_and_never_simulated_again) {
  folder.write("scene.toml", automatic_scene(16));
  const Outcome sixteen = run("out", "--jobs 1");
  ASSERT_EQ(sixteen.status, 0) << sixteen.err;
  EXPECT_TRUE(holds(sixteen.said(), "12 points predict 4 new ones"));
  EXPECT_TRUE(holds(sixteen.said(), "others are pressed so"));
  const Outcome again = run("out");
  EXPECT_TRUE(holds(again.said(), "nothing to do"));

  folder.write("scene.toml", automatic_scene(18) +
                                 "[[validate.tool]]\nshape = \"sphere\"\n"
                                 "radius = \"5 mm\"\npoints = 1\n");
  const Outcome more = run("out", "--jobs 1");
  EXPECT_TRUE(holds(more.said(), "and the other 1 tool by theory alone"));
  ASSERT_EQ(more.status, 0) << more.err;
  EXPECT_TRUE(holds(more.said(), "12 points predict 6 new ones"));
  EXPECT_TRUE(holds(more.said(), "simulate 18/18"));
  EXPECT_FALSE(holds(more.said(), "simulate 16/")) << "simulated again: ";

  const Outcome at_once = run("fresh", "--jobs 2");
  ASSERT_EQ(at_once.status, 0) << at_once.err;
  for (const char* file : {"placement.csv", "validation.csv"})
    EXPECT_TRUE(content_of(folder / "out" / file) == content_of(folder / "fresh" / file)) << file;
}

// A window of 36 vertices 2.5 mm apart, of which less than 24 are half a contact's radius apart:
// points go nearer where the tolerance is not met.
TEST_F(PlacedRun, points_go_nearer_to_each_other_where_the_tolerance_is_not_met) {
  folder.write("block.off", block_off(32));
  const std::string small =
      replaced(automatic_scene(24), "[[\"9 mm\", \"9 mm\"", "[[\"32 mm\", \"32 mm\"");
  folder.write("scene.toml", replaced(small, "\"60 mm\", \"60 mm\"", "\"46 mm\", \"46 mm\""));
  const Outcome placed = palpate(folder, "simulate scene.toml -o samples.h5");
  ASSERT_EQ(placed.status, 0) << placed.err;
  EXPECT_TRUE(holds(placed.said(), "12 on 36 reachable"));
  EXPECT_TRUE(holds(placed.said(), "the budget of 24 points is spent"));
}

TEST_F(PlacedRun, rounds_of_shards_have_the_bytes_of_one_process) {
  folder.write("scene.toml", automatic_scene(20));
  fs::create_directories(folder / "one");
  const Outcome one = palpate(folder, "simulate scene.toml -o one/samples.h5");
  ASSERT_EQ(one.status, 0) << one.err;
  int rounds = 0;
  for (; rounds < 9 && !fs::exists(folder / "shards" / "samples.h5"); ++rounds) {
    for (const char* shard : {"1/3", "2/3", "3/3"}) {
      const Outcome done =
          palpate(folder, std::string("simulate scene.toml -o shards --shard ") + shard);
      ASSERT_EQ(done.status, 0) << done.err;
    }
    const Outcome merged = palpate(folder, "merge shards -o shards/samples.h5");
    ASSERT_EQ(merged.status, 0) << merged.err;
  }
  EXPECT_GE(rounds, 3);
  folder.write("study.toml", "scene = \"scene.toml\"\n");
  const Outcome study = palpate(folder, "study study.toml -o study");
  EXPECT_TRUE(holds(study.out, "1 cases: 1 done"));
  for (const auto& entry : fs::directory_iterator(folder / "study" / "cases"))
    EXPECT_TRUE(content_of(entry.path() / "samples.h5") ==
                content_of(folder / "one" / "samples.h5"));
  for (const char* file : {"samples.h5", "samples.surface.h5", "placed.h5", "placement.csv"})
    EXPECT_TRUE(content_of(folder / "one" / file) == content_of(folder / "shards" / file)) << file;
}

TEST_F(PlacedRun, the_asset_carries_the_statement_and_what_it_is_made_of) {
  folder.write("scene.toml", replaced(kScene, "causes = false", "causes = true"));
  ASSERT_EQ(run("out").status, 0);
  const auto statement = nlohmann::json::parse(content_of(folder / "out" / "statement.json"));
  for (const char* cause : {"interpolation", "curve_fit", "curve_family", "friction_law"})
    EXPECT_TRUE(statement.at("causes").at(cause).at("p95_rel").is_number()) << cause;
  EXPECT_TRUE(statement.at("baselines").at("one_response").at("p95_rel").is_number());
  const std::string asset = content_of(folder / "out" / "asset.palp");
  EXPECT_EQ(statement.at("asset_bytes").get<std::size_t>(), asset.size());
  const auto meta_at = asset.rfind("{\"program\"");
  ASSERT_NE(meta_at, std::string::npos);
  const auto meta =
      nlohmann::json::parse(asset.substr(meta_at, asset.find('\0', meta_at) - meta_at));
  EXPECT_EQ(meta.at("statement").at("causes"), statement.at("causes"));
  EXPECT_EQ(meta.at("statement").at("force_error"), statement.at("force_error"));
}

}  // namespace
}  // namespace palpate::tools
