// From a mesh to a scene (`new`), and what `check` says of it.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "libfit/core/error.hpp"
#include "tests/tools/block_scene.hpp"
#include "tools/scene/scene.hpp"
#include "tools/scene/tissues.hpp"
#include "tools/setup/check.hpp"
#include "tools/setup/propose.hpp"

namespace palpate::tools {
namespace {

using namespace testing_support;

// 80 x 80 x 30 in the file's unit, each side a grid.
Surface block(int cells) {
  const BlockMesh mesh = block_mesh(cells);
  return {Points::Map(mesh.vertices[0].data(), Eigen::Index(mesh.vertices.size()), 3),
          Triangles::Map(mesh.faces[0].data(), Eigen::Index(mesh.faces.size()), 3)};
}

TEST(new_scene, the_likely_unit_makes_an_organ_of_a_mesh) {
  EXPECT_EQ(likely_unit({194, 154, 156}), "mm");
  EXPECT_EQ(likely_unit({19, 15, 15}), "cm");
  EXPECT_EQ(likely_unit({0.19, 0.15, 0.15}), "m");
  EXPECT_EQ(likely_unit({194000, 154000, 156000}), "um");
  EXPECT_EQ(likely_unit({1.9, 1.5, 1.5}), "dm");
}

TEST(new_scene, of_a_block_rests_on_one_broad_side_and_is_pressed_on_the_other) {
  const ProposedScene proposed = propose_scene("block.off", block(8), {});
  const Scene scene = parse_scene(proposed.text, "scene.toml");
  ASSERT_EQ(scene.body.fixed.size(), 1u);
  const auto& held = std::get<HalfSpace>(scene.body.fixed[0]);
  EXPECT_EQ(held.axis, 2);
  EXPECT_TRUE(held.is_below);
  const auto& window = std::get<Ball>(*scene.experiments.region);
  EXPECT_NEAR((window.center_m - Vec3(0.04, 0.04, 0.03)).norm(), 0, 1e-9);
  EXPECT_LT(scene.experiments.each.depth_m, 0.03 / 4);
  EXPECT_GT(window.radius_m, 3 * scene.experiments.each.depth_m);
}

TEST(new_scene, writes_0_for_what_is_0_within_rounding) {
  Surface centred = block(8);
  centred.vertices.leftCols(2).array() -= 40 * (1 + 1e-13);
  EXPECT_TRUE(
      holds(propose_scene("block.off", centred, {}).text, "center = [\"0 mm\", \"0 mm\", "));
}

TEST(new_scene, takes_the_choices_it_is_given) {
  const ProposedScene proposed =
      propose_scene("block.off", block(24), {.unit = "cm", .tissue = "spleen", .held = "+z"});
  const Scene scene = parse_scene(proposed.text, "scene.toml");
  EXPECT_FALSE(std::get<HalfSpace>(scene.body.fixed[0]).is_below);
  EXPECT_EQ(scene.body.length_unit_m, 0.01);
  EXPECT_DOUBLE_EQ(scene.material->values[0], 2900);
}

TEST(new_scene, reads_back_the_name_of_a_mesh_whatever_it_holds) {
  for (const char* name : {"block.off", "C:\\tmp\\new.off", "o'brien \"left\" \\1.off"}) {
    const ProposedScene proposed = propose_scene(name, block(24), {});
    EXPECT_EQ(parse_scene(proposed.text, "scene.toml").body.surface->filename(), name);
  }
}

// Brain, stomach and prostate had the stiffness of liver, and nothing said so.
TEST(tissues, are_what_the_name_of_a_file_means) {
  const std::pair<const char*, const char*> names[] = {
      {"liver", "liver"},
      {"left_kidney_01", "kidney-cortex"},
      {"Kidneys-2", "kidney-cortex"},
      {"renal_pelvis", "kidney-pelvis"},
      {"case12.liver_tumors", "liver-tumour"},
      {"hepatic_artery", "hepatic-artery-wall"},
      {"LeftLungUpperLobe", "lung"},
      {"PROSTATE", "prostate"},
      {"brain", "brain-grey"},
      {"gall_bladder", "gallbladder-wall"},
      {"small_intestines", "bowel-wall"},
      {"stomach", "stomach-wall"},
      {"hearts", "heart"},
      {"uterus3", "uterus"},
      {"pancreas", "pancreas"},
      {"skin_patch", "skin"},
  };
  for (const auto& [name, tissue] : names) {
    const Tissue* meant = tissue_of_name(name);
    ASSERT_NE(meant, nullptr) << name;
    EXPECT_EQ(meant->name, tissue) << name;
  }
  // Parts of words, and words of the table that name no organ.
  for (const char* name : {"deliverable", "skinny", "urinary_bladder", "tumour", "wall", "", "42"})
    EXPECT_EQ(tissue_of_name(name), nullptr) << name;
}

TEST(new_scene, says_in_its_first_line_which_tissue_it_took) {
  const auto first_line = [](const ProposedScene& scene) {
    return scene.text.substr(0, scene.text.find('\n'));
  };
  const ProposedScene named = propose_scene("prostate.stl", block(24), {});
  EXPECT_EQ(named.tissue, "prostate");
  EXPECT_DOUBLE_EQ(parse_scene(named.text, "s.toml").material->values[0], 17000);
  EXPECT_EQ(first_line(named),
            "# tissue: prostate (17 kPa), by the name prostate.stl: --tissue gives another");
  const ProposedScene unknown = propose_scene("block.off", block(24), {});
  EXPECT_EQ(first_line(unknown),
            "# tissue: liver (5.4 kPa), since neither --tissue nor the name block.off says which");
  ASSERT_FALSE(unknown.warnings.empty());
  EXPECT_EQ("# " + unknown.warnings[0], first_line(unknown));
  EXPECT_EQ(first_line(propose_scene("bladder.stl", block(24), {})),
            "# tissue: liver (5.4 kPa), as for anything that the table of tissues does not have, "
            "and it has no bladder: --tissue gives another");
  const ProposedScene filled = propose_scene("hepatic_artery.stl", block(24), {});
  ASSERT_FALSE(filled.warnings.empty());
  EXPECT_TRUE(holds(filled.warnings[0], "the whole mesh is filled with it"));
  const ProposedScene asked = propose_scene("prostate.stl", block(24), {.tissue = "spleen"});
  EXPECT_EQ(first_line(asked), "# tissue: spleen (2.9 kPa), as asked for");
  EXPECT_EQ("# " + asked.notes[0], first_line(asked));
}

TEST(new_scene, lays_a_liver_on_its_neighbours_and_a_block_of_liver_on_a_plate) {
  const ProposedScene named = propose_scene("left_liver.stl", block(24), {});
  const Scene liver = parse_scene(named.text, "s.toml");
  ASSERT_EQ(liver.beds.size(), 1u);
  EXPECT_TRUE(liver.body.fixed.empty());
  const auto& ground = std::get<HalfSpace>(liver.beds[0].region);
  EXPECT_EQ(ground.axis, 2);
  EXPECT_TRUE(ground.is_below);
  const ProposedScene asked = propose_scene("block.stl", block(24), {.tissue = "liver"});
  EXPECT_TRUE(parse_scene(asked.text, "s.toml").beds.empty());
}

// A stomach was jelly through and through, without a word.
TEST(new_scene, hollows_out_what_its_name_says_is_hollow) {
  const ProposedScene stomach = propose_scene("stomach.stl", block(24), {.unit = "mm"});
  ASSERT_FALSE(stomach.warnings.empty());
  EXPECT_TRUE(holds(stomach.warnings[0], "a stomach is hollow: it gets a wall of 2.9 mm"));
  EXPECT_EQ(parse_scene(stomach.text, "s.toml").body.wall_m, 0.0029);
  // As deep as the organ allows, not its wall.
  const ProposedScene solid =
      propose_scene("block.stl", block(24), {.unit = "mm", .tissue = "stomach-wall"});
  EXPECT_EQ(parse_scene(stomach.text, "s.toml").experiments.each.depth_m,
            parse_scene(solid.text, "s.toml").experiments.each.depth_m);
  const ProposedScene thin = propose_scene("bladder.stl", block(24), {.unit = "100 um"});
  ASSERT_FALSE(thin.warnings.empty());
  EXPECT_TRUE(holds(thin.warnings[0], "leaves no lumen in this mesh"));
  EXPECT_EQ(parse_scene(thin.text, "s.toml").body.wall_m, std::nullopt);
}

TEST(tissues, each_has_a_source_and_makes_a_scene) {
  ASSERT_GE(tissues().size(), 33u);
  for (const Tissue& tissue : tissues()) {
    EXPECT_FALSE(tissue.source.empty()) << tissue.name;
    EXPECT_TRUE(tissue.doi.empty() || tissue.doi.starts_with("10.")) << tissue.name;
    EXPECT_LT(tissue.deviation_Pa, tissue.young_Pa) << tissue.name;
    const ProposedScene proposed = propose_scene("block.off", block(4), {.tissue = tissue.name});
    EXPECT_NO_THROW(parse_scene(proposed.text, "scene.toml")) << tissue.name;
  }
}

TEST(scenes, a_mesh_below_PALPATE_DATA_needs_the_variable) {
  const std::string text = replaced(kScene, "block.off", "$PALPATE_DATA/block.off");
  ::unsetenv("PALPATE_DATA");
  EXPECT_THROW(parse_scene(text, "scene.toml"), Error);
  ::setenv("PALPATE_DATA", "/organs", 1);
  EXPECT_EQ(*parse_scene(text, "scene.toml").body.surface, "/organs/block.off");
  ::unsetenv("PALPATE_DATA");
}

TEST(quick, asks_for_less_of_everything_and_nothing_more) {
  Scene scene = parse_scene(kScene, "scene.toml");
  scene.experiments.test_points = 400;
  scene.experiments.each.drag_depths_m = {0.001, 0.003, 0.002};
  make_quick(scene);
  EXPECT_FALSE(scene.experiments.placement);
  EXPECT_EQ(scene.experiments.test_points, 12);
  EXPECT_EQ(scene.experiments.each.drag_depths_m, std::vector<double>{0.003});
  EXPECT_EQ(scene.experiments.each.drag_steps, 5);
  EXPECT_EQ(scene.validate.points, 2);
  EXPECT_FALSE(scene.validate.causes);
}

TEST(quick, places_fewer_points_where_they_are_pressed_alone) {
  Scene scene = parse_scene(kScene, "scene.toml");
  scene.experiments.placement.emplace();
  scene.experiments.test_points = 12;
  scene.experiments.each.drag_depths_m = {0.001, 0.003};
  make_quick(scene);
  ASSERT_TRUE(scene.experiments.placement);
  EXPECT_EQ(scene.experiments.placement->budget, 60);
  EXPECT_EQ(scene.experiments.each.drag_depths_m.size(), 2u);
  EXPECT_EQ(scene.experiments.each.press_steps, 5);
}

TEST(check, says_all_that_is_wrong_at_once) {
  const std::string text = replaced(kScene, "depth =", "detph =");
  const BlockFolder folder(
      replaced(replaced(text, "\"10 kPa\"", "\"10 mm\""), "radius = ", "raduis = "));
  const Outcome outcome = palpate(folder, "check scene.toml --json");
  EXPECT_EQ(outcome.status, 1);
  const auto report = nlohmann::json::parse(outcome.out);
  ASSERT_EQ(report.at("errors").size(), 3u) << outcome.out;
  for (const auto& error : report.at("errors"))
    EXPECT_TRUE(holds(error.at("where").get<std::string>(), "scene.toml:"));
}

TEST(check, tries_a_point_and_tells_what_a_run_costs) {
  const BlockFolder folder;
  const Outcome outcome = palpate(folder, "check scene.toml --json");
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  const auto report = nlohmann::json::parse(outcome.out);
  EXPECT_TRUE(report.at("errors").empty());
  const auto& trial = report.at("trial");
  EXPECT_EQ(trial.at("good"), trial.at("rows"));
  EXPECT_GT(trial.at("force_N"), 0);
  EXPECT_GT(trial.at("sticking").get<int>() + trial.at("slipping").get<int>(), 5);
  EXPECT_EQ(report.at("run").at("points_at_most"), 6);  // 4 test points, 2 held out, no causes
}

TEST(check, fails_where_no_row_of_the_trial_is_good) {
  const BlockFolder folder(replaced(kScene, "test_points = 4", "test_points = \"p.csv\""));
  folder.write("p.csv", "x_m,y_m,z_m\n0.04,0.04,0\n");  // where the body is held
  const Outcome outcome = palpate(folder, "check scene.toml");
  EXPECT_EQ(outcome.status, 3) << outcome.out;
  EXPECT_TRUE(holds(outcome.err, "scene.toml: no row of the trial is good"));
}

TEST(check, advises_what_to_change) {
  const Scene scene = parse_scene(kScene, "scene.toml");
  Trial trial;
  trial.force_N = trial.half_space_N = 1;
  trial.depth_m = 0.002;
  trial.sway_m = 0.001;
  trial.rows = trial.good = 14;
  trial.sticking = 4;
  trial.slipping = 5;
  EXPECT_TRUE(advice(scene, trial).empty());
  const auto says = [&](auto Trial::*field, auto value, const std::string& key) {
    Trial changed = trial;
    changed.*field = value;
    const auto sentences = advice(scene, changed);
    ASSERT_EQ(sentences.size(), 1u) << key;
    EXPECT_TRUE(holds(sentences[0], key));
  };
  says(&Trial::slipping, 0, "drag_distance");
  says(&Trial::sticking, 1, "drag_steps");
  says(&Trial::force_N, 0.1, "the organ sways");
  says(&Trial::sway_m, 0.028,
       "the force of the press, sideways, moves the body as a whole by 28 mm");
  says(&Trial::held_share, 0.12, "12 % of a press's force comes from where the body is held");
  says(&Trial::force_error, 0.2, "force_tolerance");
  says(&Trial::good, 9, "press less deep");
}

}  // namespace
}  // namespace palpate::tools
