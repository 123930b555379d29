// Canonical texts: every member of every section counts, and a scene comes back from a body.

#include "tools/scene/canonical.hpp"

#include <gtest/gtest.h>

#include "libfem/probes/probes.hpp"
#include "tests/support/error_of.hpp"
#include "tools/scene/fields.hpp"

namespace palpate::tools {
namespace {

// Changes the one member that it is told to, and knows its key and stage.
class Changer {
 public:
  explicit Changer(int wanted) : wanted_(wanted) {}

  template <class Value, class Kind>
  void operator()(Stage stage, std::string_view key, Value& value, const Kind&) {
    if constexpr (std::is_same_v<Value, std::optional<PlacementSection>>) {
      if (value) visit(*value, *this);  // a member of its own only where there is none
    }
    if (count_++ != wanted_) return;
    change(value);
    changed_ = {std::string(key), stage};
  }

  int count() const { return count_; }
  const std::optional<std::pair<std::string, Stage>>& changed() const { return changed_; }

 private:
  static void change(double& value) { value += 0.125; }
  static void change(int& value) { ++value; }
  static void change(bool& value) { value = !value; }
  static void change(std::string& value) { value = value == "yeoh" ? "fung" : value + "x"; }
  static void change(std::filesystem::path& value) { value += "x"; }
  static void change(std::vector<double>& value) { value.push_back(0.125); }
  static void change(Vec3& value) { value[1] += 0.125; }
  static void change(HalfSpace& value) { value.is_below = !value.is_below; }
  static void change(Region& value) { value = Ball{Vec3::Ones(), 0.125}; }
  static void change(std::vector<Region>& value) { value.emplace_back(Box{}); }
  static void change(fem::MaterialParameters& value) { value.values.front() += 1; }
  static void change(std::map<std::string, std::vector<double>, std::less<>>& value) {
    value["radius"].front() += 0.125;
  }
  static void change(Surface& value) { value.vertices.setOnes(1, 3); }
  template <class Value>
  static void change(std::optional<Value>& value) {
    if (value)
      value.reset();
    else
      value.emplace();
  }

  int wanted_, count_ = 0;
  std::optional<std::pair<std::string, Stage>> changed_;
};

constexpr Stage kStages[] = {Stage::prepare, Stage::simulate, Stage::place, Stage::fit,
                             Stage::validate};

const std::string kFull = R"([body]
surface = "liver.obj"
length_unit = "mm"
mesh_size = "9 mm"
fixed = [ { below = { axis = "y", at = "2 mm" } }, { box = [[0, 0, 0], [1, 1, 1]] } ]
[material]
law = "ogden"
mu1 = "2 kPa"
alpha1 = 3
relaxation = [[0.5, "100 ms"], [0.2, "2 s"]]
[[inclusion]]
sphere = { center = [0, 0, 0.01], radius = "5 mm" }
material = { young = "60 kPa" }
[[inclusion]]
above = { axis = "z", at = "40 mm" }
material = { law = "holzapfel-gasser-ogden", shear = "2 kPa", k1 = "1 kPa", k2 = 3, fibre = [1, 0, 2] }
[[bed]]
below = { axis = "z", at = "-10 mm" }
material = { young = "2 kPa", poisson = 0.4 }
thickness = "12 mm"
slides = true
[probe]
shape = "capsule"
radius = "4 mm"
length = "30 mm"
orientation = "lying"
friction = 0.8
[experiments]
test_points = "auto"
budget = 30
region = { sphere = { center = [0, 0, 0.1], radius = "3 cm" } }
drag_depths = ["3 mm"]
[fit]
family = "separable"
)";

template <class Section>
int expect_every_member_counts(const Scene& scene, Section& (*section_of)(Scene&)) {
  Changer counter(-1);
  Scene copy = scene;
  visit(section_of(copy), counter);
  for (int member = 0; member < counter.count(); ++member) {
    Scene changed = scene;
    Changer changer(member);
    visit(section_of(changed), changer);
    if (!changer.changed()) {
      ADD_FAILURE() << "member " << member << " was not changed";
      continue;
    }
    for (const Stage stage : kStages)
      EXPECT_EQ(canonical(scene, stage) != canonical(changed, stage),
                stage == changer.changed()->second)
          << changer.changed()->first << " and stage " << static_cast<int>(stage);
  }
  return counter.count();
}

TEST(canonical, every_member_of_every_section_changes_the_text_of_its_stage_and_of_no_other) {
  const Scene full = parse_scene(kFull, "/s/a.toml");
  for (const Scene& scene :
       {full,
        parse_scene(
            "[body]\ntetmesh = \"a.msh\"\nlength_unit = \"m\"\n"
            "[material]\nyoung = 1\n[[inclusion]]\nbelow = { at = 0 }\n"
            "material = { young = 2 }\n[[bed]]\nabove = { at = 1 }\n"
            "material = { young = 2 }\nthickness = 1\n[experiments]\ntest_points = \"p.csv\"\n",
            "/s/b.toml")}) {
    int members = 0;
    members += expect_every_member_counts<BodySection>(
        scene, [](Scene& s) -> BodySection& { return s.body; });
    members += expect_every_member_counts<std::optional<fem::MaterialParameters>>(
        scene, [](Scene& s) -> std::optional<fem::MaterialParameters>& { return s.material; });
    members += expect_every_member_counts<InclusionSection>(
        scene, [](Scene& s) -> InclusionSection& { return s.inclusions.front(); });
    members += expect_every_member_counts<BedSection>(
        scene, [](Scene& s) -> BedSection& { return s.beds.front(); });
    members += expect_every_member_counts<ProbeSpec>(
        scene, [](Scene& s) -> ProbeSpec& { return s.probe.spec; });
    members += expect_every_member_counts<FitSection>(
        scene, [](Scene& s) -> FitSection& { return s.fit; });
    members += expect_every_member_counts<ValidateSection>(
        scene, [](Scene& s) -> ValidateSection& { return s.validate; });
    members += expect_every_member_counts<ExperimentsSection>(
        scene, [](Scene& s) -> ExperimentsSection& { return s.experiments; });
    EXPECT_GT(members, 35);
  }
}

TEST(canonical, a_scene_comes_back_from_a_body_with_the_same_fingerprints) {
  for (const std::string& text :
       {kFull,
        std::string("[body]\nsurface = \"a.off\"\nlength_unit = \"mm\"\n"
                    "[experiments]\ntest_points = \"vertices\"\n"),
        std::string("[body]\nsurface = \"a.off\"\nlength_unit = \"mm\"\n[material]\nyoung = 1\n"
                    "[[layer]]\nthickness = 0.1\nmaterial = { young = 2 }\n"
                    "[[layer]]\nthickness = 0.2\nmaterial = { young = 3 }\n")}) {
    const Scene scene = parse_scene(text, "/s/a.toml");
    Body body;
    store_scene(scene, body);
    const Scene back = scene_of(body, "body.h5");
    for (const Stage stage : {Stage::prepare, Stage::simulate, Stage::place, Stage::fit})
      EXPECT_EQ(canonical(scene, stage), canonical(back, stage));
    EXPECT_EQ(canonical(scene.fit), canonical(back.fit));
    EXPECT_EQ(back.material.has_value(), scene.material.has_value());
    if (scene.material) {
      EXPECT_EQ(back.material->relaxation.time_s, scene.material->relaxation.time_s);
    }
    ASSERT_EQ(back.inclusions.size(), scene.inclusions.size());
    ASSERT_EQ(back.beds.size(), scene.beds.size());
  }
}

// The stage commands read body.h5 alone and make what `run` makes of the scene.
TEST(canonical, a_tool_comes_back_from_a_body) {
  const std::string body =
      "[body]\nsurface = \"a.obj\"\nlength_unit = \"mm\"\n"
      "fixed = [ { below = { axis = \"y\", at = \"2 mm\" } } ]\n"
      "[material]\nyoung = \"2 kPa\"\npoisson = 0.4\n";
  const std::string row =
      "[tool]\nshape = \"capsule\"\nradius = \"5 mm\"\nlength = \"20 mm\"\n"
      "orientation = \"lying\"\nballs = 3\ntilt = \"20 deg\"\npaths = 7\n";
  const std::string places =
      "[tool]\nshape = \"cone\"\nhalf_angle = \"40 deg\"\ntip_radius = \"1 mm\"\n"
      "balls = [[0, 0, 0.001], [0.001, 0, 0.004]]\n";
  for (const std::string& tool : {row, places}) {
    const Scene scene = parse_scene(body + tool, "/s/a.toml");
    Body prepared;
    store_scene(scene, prepared);
    const Scene back = scene_of(prepared, "body.h5");
    ASSERT_TRUE(back.tool) << tool;
    EXPECT_EQ(canonical(back.tool->probe.spec), canonical(scene.tool->probe.spec));
    EXPECT_EQ(back.tool->row, scene.tool->row);
    EXPECT_EQ(back.tool->balls_m, scene.tool->balls_m);
    EXPECT_EQ(back.tool->tilt_rad, scene.tool->tilt_rad);
    EXPECT_EQ(back.tool->paths, scene.tool->paths);
    EXPECT_FALSE(store_scene(back, prepared));
  }
  Body without;
  store_scene(parse_scene(body, "/s/a.toml"), without);
  EXPECT_FALSE(scene_of(without, "body.h5").tool);
}

TEST(canonical, marked_parts_come_back_from_a_body_as_the_same_part_of_space) {
  Points nodes(4, 3);
  nodes << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1;
  Triangles faces(2, 3);
  faces << 0, 2, 1, 0, 1, 3;
  Tets tets(1, 4);
  tets << 0, 1, 2, 3;
  Scene scene = parse_scene(kFull, "/s/a.toml");
  const std::vector<Region> regions{
      Marked{{},
             std::make_shared<const PaintedPart>(Surface{nodes, faces}, std::vector<char>{1, 0})},
      Marked{{},
             std::make_shared<const PaintedPart>(TetMesh{nodes, tets, {}}, std::vector<char>{1})}};
  scene.body.fixed = regions;
  scene.experiments.region = regions[0];
  Body body;
  store_scene(scene, body);
  const Scene back = scene_of(body, "body.h5");
  EXPECT_EQ(canonical(scene, Stage::prepare), canonical(back, Stage::prepare));
  ASSERT_EQ(back.body.fixed.size(), 2u);
  for (const Vec3& at : {Vec3(0.1, 0.1, -0.1), Vec3(0.3, 0, 0.3), Vec3(0, 0, 0.9), Vec3(2, 0, 0)})
    for (std::size_t i = 0; i < 2; ++i)
      EXPECT_EQ(contains(back.body.fixed[i], at), contains(regions[i], at)) << at.transpose();
  EXPECT_TRUE(any_contains(back.body.fixed, Vec3(0.3, 0.3, 0), true));
  EXPECT_FALSE(any_contains({regions[0]}, Vec3(0.3, 0.3, 0), false));
}

TEST(canonical, a_body_without_a_mesh_that_its_scene_names_is_refused) {
  Body body;
  store_scene(parse_scene("[body]\nsurface = 'a.obj'\nlength_unit = 'mm'\n"
                          "fixed = [ { inside = 'held.stl' } ]\n",
                          "/s/a.toml"),
              body);
  body.scene_meshes.clear();
  EXPECT_EQ(palpate::testing_support::error_of([&] { scene_of(body, "out/body.h5"); }),
            "out/body.h5: scene: lacks a mesh that its text names\n"
            "  Make the body again with `palpate prepare`.");
}

TEST(canonical, keys_of_probes_have_the_dimension_their_name_says) {
  for (const fem::ShapeRow& row : fem::probe_shapes())
    for (const fem::ProbeParameter& parameter : row.parameters)
      EXPECT_EQ(parameter.dimension, probe_dimension(parameter.key)) << parameter.key;
}

}  // namespace
}  // namespace palpate::tools
