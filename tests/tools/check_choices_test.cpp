// What a scene may ask for at once.

#include "tools/stages/stage_table.hpp"

#include <fmt/core.h>
#include <gtest/gtest.h>

#include "tests/support/error_of.hpp"
#include "tests/support/text.hpp"
#include "tools/stages/samples/experiment_table.hpp"

namespace palpate::tools {
namespace {

Scene scene_of(const std::string& memory) {
  return parse_scene(fmt::format(R"([body]
surface = "block.off"
length_unit = "mm"
[material]
young = "10 kPa"
poisson = 0.45
{}
[probe]
radius = "8 mm"
[tool]
shape = "capsule"
radius = "8 mm"
length = "30 mm"
orientation = "lying"
balls = 3
paths = 7
held_out = 3
[experiments]
depth = "4 mm"
pairs = 4
[validate]
pairs = 2
)",
                                 memory),
                     "/s/a.toml");
}

TEST(check_choices, contacts_feel_each_other_on_bodies_with_every_memory) {
  for (const char* memory :
       {"", "relaxation = [[0.5, \"1 s\"]]", "softening = { r = 2, beta = 0.1 }",
        "relaxation = [[0.5, \"1 s\"]]\n[[inclusion]]\nabove = { axis = \"z\", at = \"20 mm\" }\n"
        "material = { young = \"20 kPa\", poisson = 0.45, softening = { r = 2, beta = 0.1 } }"})
    EXPECT_NO_THROW(check_choices(scene_of(memory))) << memory;
}

TEST(experiment_table, a_tool_goes_along_as_many_paths_as_the_scene_says) {
  const Scene scene = scene_of("");
  for (const ExperimentRow& row : kExperimentRows)
    if (row.kind == ExperimentKind::tool) {
      EXPECT_EQ(row.count(scene, Purpose::identify), 7);
      EXPECT_EQ(row.count(scene, Purpose::hold_out), 3);
    }
}

TEST(check_choices, one_material_does_one_of_the_two_and_the_simulator_is_why) {
  EXPECT_TRUE(palpate::testing_support::holds(
      palpate::testing_support::error_of(
          [] { scene_of("relaxation = [[0.5, \"1 s\"]]\nsoftening = { r = 2, beta = 0.1 }"); }),
      "the simulator computes one of the two"));
}

}  // namespace
}  // namespace palpate::tools
