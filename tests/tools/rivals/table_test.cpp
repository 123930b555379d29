// What rivals did, as a table.

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "libfit/experiments/draw.hpp"
#include "libfit/io/files/files.hpp"
#include "tests/tools/rivals/plate.hpp"
#include "tools/workshop/rivals/measure.hpp"

namespace palpate::tools {
namespace {

using namespace testing_rivals;

// Springs of which the force of a tool that stays comes nearer to its end by a third a tick.
Rival settling_rival(const char* name, int rest_ticks) {
  Rival rival;
  rival.name = name;
  rival.rest_ticks = rest_ticks;
  rival.start = [](const Vec3&) {};
  rival.force = [off = 1.0, at = Vec3(Vec3::Zero())](const Vec3& tip) mutable -> Vec3 {
    off = at == tip ? off / 1.5 : 1;
    at = tip;
    return {0, 0, (1 + off) * kStiffness_N_m * std::min(0.0, tip.z())};
  };
  return rival;
}

TEST(Rest, ends_when_the_force_is_steady_or_its_ticks_are_over) {
  for (const int rest_ticks : {15, 60}) {
    const Rival rival = settling_rival("settling", rest_ticks);
    int ticks = 0;
    RestCount count;
    const auto tick = [&] { return ++ticks, rival.force({0, 0, -1e-3}); };
    tick();
    come_to_rest(rival, tick, count);
    EXPECT_EQ(count.rows, 1);
    EXPECT_EQ(count.rested, rest_ticks > 30);
    EXPECT_LT(ticks, 40);
    EXPECT_NEAR(tick().z(), -1e-3 * kStiffness_N_m, 0.01 * 1e-3 * kStiffness_N_m);
  }
}

TEST_F(Proxies, that_do_not_rest_are_left_out_by_name) {
  body_.paths = body_.samples;
  body_.depth_m = 4e-3;
  const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "rivals_rest";
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  RivalsTable table(folder, "plate", "a", true);
  const auto prepare = [](const RivalBody&) -> std::vector<Rival> {
    Rival at_presses = settling_rival("no rest at presses", 40);
    at_presses.rest = {.rows = 20, .rested = 9};
    return {at_presses, settling_rival("no rest on paths", 15), settling_rival("rests", 40)};
  };
  measure_part({"explicit", "bodies that settle", prepare}, body_, 1, table);
  table.write(0.01);
  const auto json = nlohmann::json::parse(read_whole_file(folder / "rivals.json")).at("plate");
  ASSERT_EQ(json.at("rivals").size(), 1U);
  EXPECT_EQ(json.at("rivals")[0].at("rival"), "rests");
  EXPECT_NEAR(json.at("rivals")[0].at("p95_rel"), 0, 0.3);
  ASSERT_EQ(json.at("left_out").size(), 2U);
  EXPECT_EQ(json.at("left_out")[0].at("why"),
            "9 of the 20 rows of its presses came to rest in 40 ticks");
  EXPECT_EQ(json.at("left_out")[1].at("why"),
            "0 of the 10 rows of its paths came to rest in 15 ticks");
  EXPECT_EQ(read_whole_file(folder / "rivals.csv").find("no rest"), std::string::npos);
}

}  // namespace
}  // namespace palpate::tools
