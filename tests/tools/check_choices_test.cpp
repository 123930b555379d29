// What a scene may ask for at once.

#include "tools/stages/check_choices.hpp"

#include <fmt/core.h>
#include <gtest/gtest.h>

#include <array>

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

TEST(check_choices, one_material_does_one_of_the_two_and_the_simulator_is_why) {
  try {
    scene_of("relaxation = [[0.5, \"1 s\"]]\nsoftening = { r = 2, beta = 0.1 }");
    FAIL();
  } catch (const Error& e) {
    EXPECT_NE(e.fact().find("the simulator computes one of the two"), std::string::npos)
        << e.fact();
  }
}

// `keys` of [validate].
std::string answer_to_holds(const std::string& memory, const std::string& keys) {
  Scene scene = scene_of(memory);
  scene.tool.reset();
  scene.validate =
      parse_scene("[body]\nsurface = \"a\"\nlength_unit = \"mm\"\n[validate]\n" + keys, "/s/a.toml")
          .validate;
  try {
    check_choices(scene);
    return "";
  } catch (const Error& e) {
    return e.what();
  }
}

TEST(check_choices, a_hold_needs_a_body_that_relaxes_a_force_and_time) {
  const std::string relaxing = "relaxation = [[0.5, \"1 s\"]]";
  EXPECT_EQ(answer_to_holds(relaxing, "holds = 2\nhold_force = 0.5"), "");
  EXPECT_EQ(answer_to_holds("", "hold_force = 0.5"), "");
  const std::string place = "/s/a.toml: holds of [validate]: ";
  for (const auto& [memory, keys, fact] :
       {std::array<std::string, 3>{"", "holds = 2\nhold_force = 0.5",
                                   "under a force that stays a body creeps, and this one does not "
                                   "relax\n  Give [material] a relaxation, or leave holds out."},
        {relaxing, "holds = 2",
         "no force is named\n  Write hold_force = 0.5, in N: what the body bears well within the "
         "depth."},
        {relaxing, "holds = 2\nhold_force = 0.5\nhold = \"0 s\"",
         "hold_approach and hold take time\n  Give both a time above 0."}})
    EXPECT_EQ(answer_to_holds(memory, keys), place + fact);
}

}  // namespace
}  // namespace palpate::tools
