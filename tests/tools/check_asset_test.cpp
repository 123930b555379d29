// `palpate check asset.palp`: the object that others read, the paragraph, the exit status.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/tools/command_line.hpp"

namespace palpate::tools {
namespace {

using testing_support::Folder;
using testing_support::holds;
using testing_support::Outcome;
using testing_support::palpate;

const std::string kGolden = std::string(PALPATE_SOURCE_DIR) + "/tests/libfit/runtime/golden/";

TEST(check_asset, prints_one_object_with_the_keys_that_others_read) {
  const Folder folder;
  const auto devices =
      folder.write("devices.toml", "[[device]]\nname = \"mine\"\nmax_force = \"1 mN\"\n");
  const Outcome outcome =
      palpate(folder, "check " + kGolden + "rings.palp --json --devices " + devices.string());
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  const auto json = nlohmann::json::parse(outcome.out);
  for (const char* key : {"passive_fixed", "k_max_N_m", "b_min_Ns_m", "edge_jump_N",
                          "edge_jump_at_m", "guard", "continuity", "devices"})
    EXPECT_TRUE(json.contains(key)) << key;
  EXPECT_TRUE(json["passive_fixed"]);
  for (const char* key : {"held_ticks", "refused_J", "work_J"})  // a coarse ball
    EXPECT_GT(json["guard"][key], 0) << key;
  const double stiffness = json["k_max_N_m"];
  for (const int rate : {1000, 2000, 4000, 10000})
    EXPECT_NEAR(json["b_min_Ns_m"][std::to_string(rate)], 0.5 * stiffness / rate, 1e-9 * stiffness);
  EXPECT_EQ(json["devices"].back()["name"], "mine");
  EXPECT_FALSE(json["devices"].back()["force_fits"]);
}

TEST(check_asset, says_how_often_the_guard_acted_and_where_the_force_jumped) {
  const Folder folder;
  const Outcome outcome = palpate(folder, "check " + kGolden + "rings.palp");
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  for (const char* words : {"never pulled the tool in", "The guard held", "over edges", "Devices:"})
    EXPECT_TRUE(holds(outcome.out, words));
}

TEST(check_asset, refuses_options_of_scenes) {
  const Folder folder;
  const Outcome outcome = palpate(folder, "check " + kGolden + "rings.palp --page map.html");
  EXPECT_EQ(outcome.status, 1);
  EXPECT_TRUE(holds(outcome.err, "--page: is of scenes"));
}

TEST(check_asset, refuses_a_table_of_devices_with_a_bad_key) {
  const Folder folder;
  const auto devices = folder.write("devices.toml", "[[device]]\nmax_farce = \"1 N\"\n");
  const Outcome outcome =
      palpate(folder, "check " + kGolden + "rings.palp --devices " + devices.string());
  EXPECT_EQ(outcome.status, 1);
  EXPECT_TRUE(holds(outcome.err, "max_force"));
}

}  // namespace
}  // namespace palpate::tools
