#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "tests/support/error_of.hpp"
#include "tools/scene/canonical.hpp"
#include "tools/scene/scene.hpp"
#include "tools/scene/toml_table.hpp"

namespace palpate::tools {
namespace {

std::string with_material(const std::string& lines) {
  return "[body]\nsurface = \"a.obj\"\nlength_unit = \"mm\"\n[material]\n" + lines;
}

fem::MaterialParameters material_of(const std::string& lines) {
  return *parse_scene(with_material(lines), "s.toml").material;
}

std::string error_of(const std::string& lines) {
  return palpate::testing_support::error_of([&] { parse_scene(with_material(lines), "s.toml"); });
}

struct Given {
  const char* lines;
  std::vector<double> values;  ///< NaN: left out
};

constexpr const char* kFibres = "law = 'holzapfel-gasser-ogden'\nshear = 1\nk1 = 1\nk2 = 1\n";
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

const std::vector<Given> kGiven{
    {"law = 'neo-hookean'\nyoung = '5 kPa'\npoisson = 0.49", {5e3, 0.49}},
    {"law = 'neo-hookean-isochoric'\nyoung = 5000", {5e3, 0.45}},
    {"law = 'mooney-rivlin'\nc10 = '1 kPa'\nc01 = '0.5 kPa'\npoisson = 0.49",
     {1e3, 500, 0.49, kNaN}},
    {"law = 'yeoh'\nc10 = '1 kPa'\nc30 = '2 Pa'\nbulk = '1 MPa'", {1e3, 0, 2, 0.45, 1e6}},
    {"law = 'ogden'\nmu1 = '1 kPa'\nalpha1 = 8\nmu2 = '-20 Pa'\nalpha2 = -3",
     {1e3, 8, -20, -3, kNaN, kNaN, 0.45, kNaN}},
    {"law = 'fung'\nshear = '1 kPa'\nb = 1.5", {1e3, 1.5, 0.45, kNaN}},
    {"law = 'holzapfel-gasser-ogden'\nshear = '1 kPa'\nk1 = '3 kPa'\nk2 = 0.8\nfibre = [0, 0.6, "
     "0.8]",
     {1e3, 3e3, 0.8, 0, 0.6, 0.8, 0, 0.45, kNaN}},
};

TEST(SceneMaterial, every_law_can_be_given) {
  std::set<std::string> laws;
  for (const Given& given : kGiven) {
    SCOPED_TRACE(given.lines);
    const fem::MaterialParameters material = material_of(given.lines);
    laws.insert(material.law);
    ASSERT_EQ(material.values.size(), given.values.size());
    for (std::size_t i = 0; i < given.values.size(); ++i)
      EXPECT_TRUE(material.values[i] == given.values[i] ||
                  (std::isnan(material.values[i]) && std::isnan(given.values[i])))
          << i << ": " << material.values[i];
    EXPECT_NO_THROW(fem::make_material(material, "test"));
  }
  EXPECT_EQ(laws.size(), fem::material_laws().size());
}

TEST(SceneMaterial, inclusions_have_laws_of_their_own) {
  const Scene scene = parse_scene(
      with_material(
          "young = '5 kPa'\n[[inclusion]]\nsphere = { center = [0, 0, 0], radius = '1 cm' }\n"
          "material = { law = 'yeoh', c10 = '9 kPa' }\n"),
      "s.toml");
  EXPECT_EQ(scene.inclusions.at(0).material.law, "yeoh");
  EXPECT_EQ(scene.inclusions.at(0).material.values.at(0), 9e3);
}

TEST(SceneMaterial, a_material_relaxes_and_its_inclusions_with_it_unless_they_say_otherwise) {
  const std::string lump =
      "[[inclusion]]\nsphere = { center = [0, 0, 0], radius = '1 cm' }\nmaterial = { young = '9 "
      "kPa'";
  const Scene scene =
      parse_scene(with_material("young = '5 kPa'\nrelaxation = [[0.5, '100 ms'], [0.25, '2 s']]\n" +
                                lump + " }\n" + lump + ", relaxation = [] }\n" + lump +
                                ", relaxation = [[1, '1 s']] }\n"),
                  "s.toml");
  const Relaxation& body = scene.material->relaxation;
  ASSERT_EQ(body.branches(), 2);
  EXPECT_EQ(body.share, Eigen::Vector2d(0.5, 0.25));
  EXPECT_EQ(body.time_s, Eigen::Vector2d(0.1, 2));
  EXPECT_EQ(scene.inclusions.at(0).material.relaxation.share, body.share);
  EXPECT_EQ(scene.inclusions.at(1).material.relaxation.branches(), 0);
  EXPECT_EQ(scene.inclusions.at(2).material.relaxation.share[0], 1);
}

// Refusals that docs/bad-inputs.md does not show: keys of [material] and how the answer begins.
TEST(SceneMaterial, what_cannot_be_is_refused_at_its_place) {
  const std::string not_three = "s.toml:9:9: fibre of [material] is not a list of 3 numbers\n",
                    fibre = kFibres + std::string("fibre = ");
  for (const auto& [lines, answer] : {
           std::pair<std::string, std::string>{
               "young = 1\nrelaxation = [[0.5, '2 mm']]",
               "s.toml:6:21: relaxation of [material] is \"2 mm\", which is not a time"},
           {"young = 1\nrelaxation = [[1, 1], [1, 2], [1, 3], [1, 4]]",
            "s.toml:6:14: relaxation of [material] must have 3 branches or fewer"},
           {"young = 1\nsoftening = { r = 2 }",
            "s.toml:6:13: softening of [material] must have m and beta from 0"},
           {"young = 1\nsoftening = { r = 2, m = 1, gamma = 3 }",
            "s.toml:6:29: softening of [material] has no key \"gamma\""},
           {"law = 'moony-rivlin'\nc10 = 1",
            "s.toml:5:7: law of [material] is \"moony-rivlin\", which is not known\n"
            "  Did you mean \"mooney-rivlin\"? Known: neo-hookean,"},
           {"law = 'fung'\nshear = '1 kPa'",
            "s.toml:4:1: [material] has no b, which law fung needs\n  Add b = a plain number: "},
           {"law = 'fung'\nshear = 1\nb = '1 kPa'",
            "s.toml:7:5: b of [material] is a text, not a number\n"},
           {fibre + "[1, 0]", not_three},
           {fibre + "'z'", not_three},
           {fibre + "1", not_three},
           {fibre + "[1, 0, '1 mm']",
            "s.toml:9:16: fibre of [material] holds a text, not a number\n"},
           {"law = 'ogden'\nmu1 = 1\nalpha1 = 2\nmu3 = 2",
            "s.toml:4:1: alpha3 of [material] is missing beside mu3\n"},
           {"law = 'yeoh'\nc10 = 1\nbulk = 1\npoisson = 0.4",
            "s.toml:7:8: bulk of [material] is given beside poisson\n  Keep one of the two."},
       })
    EXPECT_TRUE(error_of(lines).starts_with(answer)) << error_of(lines);
}

TEST(SceneMaterial, a_material_softens_and_its_inclusions_with_it_unless_they_say_otherwise) {
  const std::string lump =
      "[[inclusion]]\nsphere = { center = [0, 0, 0], radius = '1 cm' }\nmaterial = { young = '9 "
      "kPa'";
  const Scene scene = parse_scene(
      with_material("young = '5 kPa'\nsoftening = { r = 1.5, m = '200 Pa', beta = 0.1 }\n" + lump +
                    " }\n" + lump + ", softening = { } }\n" + lump +
                    ", relaxation = [[1, '1 s']] }\n"),
      "s.toml");
  EXPECT_EQ(scene.material->softening.r, 1.5);
  EXPECT_EQ(scene.material->softening.scale_Pa, 200);
  EXPECT_EQ(scene.material->softening.beta, 0.1);
  EXPECT_EQ(scene.inclusions.at(0).material.softening.scale_Pa, 200);
  EXPECT_FALSE(scene.inclusions.at(1).material.softening.is_any());
  EXPECT_FALSE(scene.inclusions.at(2).material.softening.is_any());
  Body body;
  store_scene(scene, body);
  const Scene back = scene_of(body, "body.h5");
  EXPECT_EQ(back.material->softening.scale_Pa, 200);
  EXPECT_EQ(back.inclusions.at(0).material.softening.scale_Pa, 200);
  EXPECT_FALSE(back.inclusions.at(1).material.softening.is_any());
}

}  // namespace
}  // namespace palpate::tools
