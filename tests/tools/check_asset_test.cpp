// `palpate check asset.palp`: the object that others read, the map, the exit status.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/tools/command_line.hpp"

namespace palpate::tools {
namespace {

using testing_support::content_of;
using testing_support::Folder;
using testing_support::Outcome;
using testing_support::palpate;

const std::string kGolden = std::string(PALPATE_SOURCE_DIR) + "/tests/libfit/runtime/golden/";

TEST(check_asset, prints_one_object_with_the_keys_that_others_read) {
  const Folder folder;
  const auto devices = folder.write(
      "devices.toml", "[[device]]\nname = \"mine\"\nmax_force = \"1 mN\"\nmass = 0.05\n");
  const Outcome outcome =
      palpate(folder, "check " + kGolden + "rings.palp --json --devices " + devices.string() +
                          " --vtu " + (folder / "map.vtu").string());
  const auto json = nlohmann::json::parse(outcome.out);
  for (const char* key :
       {"certified", "passive_fixed", "passive_sliding", "mu_required", "k_max_N_m", "b_min_Ns_m",
        "edge_jump_N", "failed_elements", "certified_interior", "skirt_elements", "skirt_area"})
    EXPECT_TRUE(json.contains(key)) << key;
  EXPECT_FALSE(json["certified"]);  // a coarse ball
  EXPECT_EQ(outcome.status, 3) << outcome.err;
  EXPECT_GT(json["failed_elements"], 0);
  EXPECT_FALSE(json["gross_slip"]["witnesses"].empty());
  const double stiffness = json["k_max_N_m"];
  for (const int rate : {1000, 2000, 4000, 10000})
    EXPECT_NEAR(json["b_min_Ns_m"][std::to_string(rate)], 0.5 * stiffness / rate, 1e-9 * stiffness);
  EXPECT_EQ(json["devices"].back()["name"], "mine");
  EXPECT_FALSE(json["devices"].back()["force_fits"]);
  EXPECT_EQ(json["devices"].back()["hands"], 24);
  EXPECT_NE(content_of(folder / "map.vtu").find("friction_factor"), std::string::npos);
}

TEST(check_asset, says_that_sliding_is_certified_for_rings_alone) {
  const Folder folder;
  const Outcome outcome = palpate(folder, "check " + kGolden + "version_1.palp");
  EXPECT_EQ(outcome.status, 3);
  EXPECT_NE(outcome.out.find("Sliding is not certified for the family"), std::string::npos)
      << outcome.out;
}

TEST(check_asset, refuses_a_table_of_devices_with_a_bad_key) {
  const Folder folder;
  const auto devices = folder.write("devices.toml", "[[device]]\nmax_farce = \"1 N\"\n");
  const Outcome outcome =
      palpate(folder, "check " + kGolden + "rings.palp --devices " + devices.string());
  EXPECT_EQ(outcome.status, 1);
  EXPECT_NE(outcome.err.find("max_force"), std::string::npos) << outcome.err;
}

}  // namespace
}  // namespace palpate::tools
