#include "tools/scene/scene.hpp"

#include <gtest/gtest.h>

#include <array>

#include "tests/support/error_of.hpp"
#include "tests/support/text.hpp"
#include "tools/scene/canonical.hpp"
#include "tools/scene/nearest_name.hpp"
#include "tools/scene/toml_table.hpp"

namespace palpate::tools {
namespace {

using palpate::testing_support::holds;
using palpate::testing_support::replaced;

const std::string kSmallest = R"([body]
surface = "liver.obj"
length_unit = "mm"
fixed = [ { below = { axis = "z", at = "2 mm" } } ]
[material]
young = "5 kPa"
)";

std::string error_of(const std::string& text) {
  return palpate::testing_support::error_of([&] { parse_scene(text, "scenes/liver.toml"); });
}

TEST(scene, fills_in_defaults_and_turns_everything_into_si) {
  const Scene scene = parse_scene(kSmallest, "/scenes/liver.toml");
  EXPECT_EQ(scene.body.surface->string(), "/scenes/liver.obj");
  EXPECT_DOUBLE_EQ(scene.body.length_unit_m, 1e-3);
  EXPECT_EQ(scene.material->law, "neo-hookean");
  EXPECT_EQ(scene.material->values, (std::vector<double>{5000, 0.45}));
  EXPECT_EQ(scene.probe.spec.shape, "sphere");
  ASSERT_EQ(scene.body.fixed.size(), 1u);
  EXPECT_TRUE(contains(scene.body.fixed[0], Vec3(1, 1, 0.0019)));
  EXPECT_FALSE(contains(scene.body.fixed[0], Vec3(1, 1, 0.0021)));
}

TEST(scene, a_probe_takes_the_keys_of_its_shape_in_units) {
  const auto probe = [](const std::string& lines) {
    return parse_scene(kSmallest + "[probe]\n" + lines, "/scenes/liver.toml").probe;
  };
  const ProbeSection flat =
      probe("shape = \"flat\"\nradius = \"6 mm\"\nedge_radius = \"0.4 mm\"\n");
  EXPECT_DOUBLE_EQ(flat.spec.values.at("edge_radius").at(0), 0.0004);
  EXPECT_EQ(ball_radius_m(flat.spec), 0);
  const ProbeSection cone =
      probe("shape = \"cone\"\nhalf_angle = \"45 deg\"\ntip_radius = 0.001\n");
  EXPECT_NEAR(cone.spec.values.at("half_angle").at(0), 0.785398163397448, 1e-15);
  const ProbeSection leaning =
      probe("shape = \"capsule\"\nradius = 0.005\nlength = 0.04\norientation = [1, 0, 1]\n");
  EXPECT_EQ(*leaning.spec.orientation, Vec3(1, 0, 1));
  EXPECT_EQ(*probe("shape = \"capsule\"\nradius = 0.005\nlength = 0.04\norientation = \"lying\"\n")
                 .spec.orientation,
            Vec3(Vec3::UnitX()));
  const ProbeSection mesh = probe("shape = \"mesh\"\nmesh = \"tool.stl\"\nlength_unit = \"mm\"\n");
  EXPECT_EQ(mesh.mesh->string(), "/scenes/tool.stl");
  EXPECT_EQ(mesh.mesh_unit_m, 1e-3);
  EXPECT_EQ(ball_radius_m(probe("").spec), 0.005);
  EXPECT_EQ(canonical(probe("").spec),
            "friction = 0.3\nradius = 0.005\n"
            "shape = \"sphere\"\n");
  EXPECT_EQ(probe("shape = \"point\"\n").spec.shape, "point");
}

TEST(scene, a_hollow_body_has_a_wall_or_a_cavity_and_a_pressure) {
  const auto with = [](const std::string& keys) {
    return replaced(kSmallest, "fixed", keys + "\nfixed");
  };
  const BodySection body =
      parse_scene(with("wall = \"4 mm\"\npressure = \"1 kPa\""), "/scenes/liver.toml").body;
  EXPECT_EQ(body.wall_m, 0.004);
  EXPECT_EQ(body.pressure_Pa, 1000);
  EXPECT_EQ(parse_scene(with("cavity = \"lumen.stl\""), "/scenes/a.toml").body.cavity->string(),
            "/scenes/lumen.stl");
  EXPECT_TRUE(
      holds(error_of(with("wall = 0.004\ncavity = \"lumen.stl\"")), "both wall and cavity"));
  EXPECT_TRUE(holds(error_of(replaced(with("wall = 0.004"), "surface", "tetmesh")),
                    "the body is a tetmesh"));
}

TEST(scene, the_mesh_unit_may_be_any_length) {
  EXPECT_DOUBLE_EQ(parse_scene("[body]\nsurface = \"a.obj\"\nlength_unit = \"110 mm\"\n", "a.toml")
                       .body.length_unit_m,
                   0.110);
}

TEST(scene, automatic_points_have_a_tolerance_and_a_budget_and_others_do_not) {
  const auto experiments = [](const std::string& lines) {
    return parse_scene(kSmallest + "[experiments]\n" + lines, "a.toml").experiments;
  };
  const ExperimentsSection automatic = experiments("test_points = \"auto\"\n");
  ASSERT_TRUE(automatic.placement.has_value());
  EXPECT_DOUBLE_EQ(automatic.placement->tolerance, 0.07);
  EXPECT_EQ(automatic.placement->budget, 200);
  EXPECT_EQ(automatic.test_points, kFirstPoints);
  EXPECT_EQ(experiments("test_points = \"auto\"\nbudget = 30\n").placement->budget, 30);
  EXPECT_FALSE(experiments("test_points = 30\n").placement.has_value());
  EXPECT_TRUE(holds(error_of(kSmallest + "[experiments]\ntest_points = 30\nbudget = 40\n"),
                    "budget of [experiments] places test points"));
  EXPECT_TRUE(
      holds(error_of(kSmallest + "[experiments]\ntest_points = \"auto\"\nbudget = 4\n"), "budget"));
}

TEST(scene, up_to_six_held_out_points_say_what_an_error_is_made_of) {
  for (const auto& [points, presses] : {std::pair(1, 1), {6, 3}, {12, 6}, {24, 6}, {36, 6}}) {
    ValidateSection validate;
    validate.points = points;
    EXPECT_EQ(validate.presses(), presses) << points;
    validate.causes = false;
    EXPECT_EQ(validate.presses(), 0);
  }
}

TEST(scene, which_points_are_chosen_does_not_change_what_one_of_them_comes_from) {
  const Scene few = parse_scene(kSmallest + "[experiments]\ntest_points = 10\n", "a.toml");
  const Scene automatic =
      parse_scene(kSmallest + "[experiments]\ntest_points = \"auto\"\n", "a.toml");
  const Scene spent =
      parse_scene(kSmallest + "[experiments]\ntest_points = \"auto\"\nbudget = 50\n", "a.toml");
  EXPECT_EQ(canonical(few, Stage::simulate), canonical(automatic, Stage::simulate));
  EXPECT_NE(canonical(automatic, Stage::place), canonical(spent, Stage::place));
  EXPECT_EQ(canonical(automatic, Stage::prepare), canonical(spent, Stage::prepare));
}

TEST(scene, canonical_texts_ignore_spelling_and_notice_values) {
  const Scene a = parse_scene(kSmallest + "[fit]\ntolerance = 0.02\n", "/s/a.toml");
  const Scene b = parse_scene(
      "# a comment\n" + kSmallest + "[experiments]\ndepth = \"1 cm\"\n[fit]\n", "/s/a.toml");
  EXPECT_EQ(canonical(a.fit), canonical(b.fit));
  EXPECT_EQ(canonical(a, Stage::simulate), canonical(b, Stage::simulate));
  EXPECT_EQ(canonical(a, Stage::prepare), canonical(b, Stage::prepare));
  const Scene c = parse_scene(kSmallest + "[fit]\ntolerance = 0.03\n", "/s/a.toml");
  EXPECT_NE(canonical(a.fit), canonical(c.fit));
  EXPECT_EQ(canonical(a, Stage::simulate), canonical(c, Stage::simulate));
  const Scene d = parse_scene(kSmallest + "[probe]\nfriction = 0.2\n", "/s/a.toml");
  EXPECT_NE(canonical(a, Stage::simulate), canonical(d, Stage::simulate));
}

// toml++ 3 is undefined where such a character stands (a fuzzer found it in a manifest).
TEST(Toml, characters_that_are_not_ascii_stand_in_quotes_and_comments_alone) {
  const auto refusal = [](const std::string& text) {
    const std::string said =
        palpate::testing_support::error_of([&] { parse_toml(text, "a.toml", ""); });
    return said.substr(0, said.find('\n'));
  };
  const std::string u = "\xC3\xBC", fact = ": a character that is not ASCII stands outside quotes";
  for (const std::string& good :
       {"# " + u + "\na = \"" + u + "\" # '" + u, "\xEF\xBB\xBF" + std::string("a = 1"),
        "a = '" + u + "\\'\nb = \"\\\"" + u + "\"", "\"" + u + "\" = 1",
        "a = \"\"\"\n" + u + " \\\" \\\n  x" + u + "\"\"\"\"\nb = '''" + u + "\n'''",
        "a = \"\" # " + u, "a.\"" + u + "\" = [ \"" + u + "\",\n '" + u + "' ]"})
    EXPECT_EQ(refusal(good), "accepted") << good;
  EXPECT_EQ(refusal("b = 1\na" + u + " = 1"), "a.toml:2:2" + fact);
  EXPECT_EQ(refusal("a\xC2\xA0= 1"), "a.toml:1:2" + fact);
  EXPECT_EQ(refusal("a = 1\xEF\xBB\xBF"), "a.toml:1:6" + fact);
  EXPECT_EQ(refusal("a = \"\"\"x \\\n " + u + "\"\"\""), "a.toml:2:2" + fact);
  EXPECT_EQ(refusal("a = \"\\" + u + "\""), "a.toml:1:7" + fact);
  for (const std::string& bad :
       {"a = 0\"t" + u + "\"", "n=9e\x1C[\"\"\"" + u, "n=9[\"\"\"" + u + "\"\"\""})
    EXPECT_EQ(refusal(bad).substr(0, 9), "a.toml:1:") << bad;
}

}  // namespace
}  // namespace palpate::tools
