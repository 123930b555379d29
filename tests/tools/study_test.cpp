// Studies: how cases are made, what they share, and what is left when one fails.

#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "libfit/io/files/files.hpp"
#include "tests/support/error_of.hpp"
#include "tests/tools/block_scene.hpp"
#include "tools/study/study_folder.hpp"

namespace palpate::tools {
namespace {

using namespace testing_support;
using palpate::testing_support::error_of;

std::string press_scene(const std::string& test_points = "4") {
  std::string text = replaced(kScene, "test_points = 4", "test_points = " + test_points);
  text = replaced(text, "drag_depths = [\"3 mm\"]", "drag_depths = []\nsurface = false");
  text = replaced(text, "press_steps = 5", "press_steps = 2");
  return replaced(text, "points = 2\n", "points = 1\n");
}

class StudyOfBlocks : public testing::Test {
 protected:
  Study read(const std::string& text) {
    return read_study(folder.write("study.toml", "scene = \"scene.toml\"\n" + text));
  }
  std::string refusal(const std::string& text) {
    return error_of([&] { read(text); });
  }
  std::string in(const std::string& name) const { return (folder / name).string(); }
  BlockFolder folder{press_scene()};
};

TEST_F(StudyOfBlocks, all_combinations_of_tables_and_lists_are_cases) {
  const Study study = read(R"(
[materials.soft]
young = "2 kPa"
[materials.rubber]
law = "yeoh"
c10 = "2 kPa"
[probes.small]
radius = "6 mm"
[vary]
"experiments.depth" = ["3 mm", "4 mm"]
"probe.friction" = [0.1, 0.3, 0.5]
)");
  EXPECT_EQ(study.inputs,
            (std::vector<std::string>{"material", "probe", "experiments.depth", "probe.friction"}));
  ASSERT_EQ(study.cases.size(), 2 * 1 * 2 * 3);
  std::set<std::string> names;
  for (const StudyCase& one : study.cases) names.insert(one.name);
  EXPECT_EQ(names.size(), study.cases.size());
  const Scene last = parse_scene(study.cases.back().scene, folder / "s.toml");
  EXPECT_DOUBLE_EQ(last.experiments.each.depth_m, 0.004);
  EXPECT_DOUBLE_EQ(last.probe.spec.friction, 0.5);
  EXPECT_EQ(last.body.surface, folder / "block.off");
}

TEST_F(StudyOfBlocks, a_body_below_the_folder_of_data_stays_there) {
  folder.write("scene.toml", replaced(press_scene(), "block.off", "$PALPATE_DATA/block.off"));
  ::setenv("PALPATE_DATA", folder.path().c_str(), 1);
  const Study study = read("[vary]\n\"probe.friction\" = [0.2]\n");
  ::unsetenv("PALPATE_DATA");
  ASSERT_EQ(study.cases.size(), 1u);
  EXPECT_TRUE(holds(study.cases[0].scene, "'$PALPATE_DATA/block.off'")) << study.cases[0].scene;
}

TEST_F(StudyOfBlocks, rows_of_a_table_are_cases) {
  folder.write("cases.csv", "material,experiments.depth,validate.seed\nsoft,3 mm,1\nfirm,4 mm,2\n");
  const Study study = read(
      "cases = \"cases.csv\"\n[materials.soft]\nyoung = \"2 kPa\"\n[materials.firm]\n"
      "young = \"9 kPa\"\n");
  ASSERT_EQ(study.cases.size(), 2);
  const Scene second = parse_scene(study.cases[1].scene, folder / "s.toml");
  EXPECT_DOUBLE_EQ(second.material->values.front(), 9000);
  EXPECT_EQ(second.validate.seed, 2);
}

TEST_F(StudyOfBlocks, a_study_runs_here_and_again_does_nothing) {
  folder.write("study.toml",
               "scene = \"scene.toml\"\n[vary]\n\"material.young\" = [\"5 kPa\", \"10 kPa\"]\n");
  const Outcome first = palpate(folder, "study study.toml -o out");
  EXPECT_EQ(first.status, 0) << first.err;
  EXPECT_TRUE(holds(first.out, "2 cases: 2 done"));
  const std::string table = content_of(folder / "out" / "results.csv");
  EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 3);
  EXPECT_TRUE(holds(table, "stiffness_N_m"));
  const Outcome again = palpate(folder, "study resume out");
  EXPECT_EQ(again.status, 0) << again.err;
  EXPECT_FALSE(holds(again.said(), "simulate"));
  EXPECT_EQ(content_of(folder / "out" / "results.csv"), table);
  const Outcome report = palpate(folder, "report out -o out/report.html");
  EXPECT_EQ(report.status, 1);
  EXPECT_TRUE(holds(report.said(), "results.csv"));
  // What `run` would say of a case's folder.
  for (const auto& entry : fs::directory_iterator(folder / "out" / "cases")) {
    const Outcome run = palpate(
        folder, "run " + (entry.path() / "scene.toml").string() + " -o " + entry.path().string());
    EXPECT_TRUE(holds(run.said(), "nothing to do"));
  }
}

TEST_F(StudyOfBlocks, a_case_that_fails_is_told_and_the_others_are_done) {
  folder.write("study.toml",
               "scene = \"scene.toml\"\n[vary]\n\"probe.radius\" = [\"400 mm\", \"8 mm\"]\n");
  const Outcome outcome = palpate(folder, "study study.toml -o out");
  EXPECT_EQ(outcome.status, 3) << outcome.err;
  EXPECT_TRUE(holds(outcome.out, "1 done, 1 failed"));
  EXPECT_TRUE(holds(outcome.said(), "case 1 (400 mm)"));
}

TEST_F(StudyOfBlocks, without_slurm_a_script_and_this_machine_remain) {
  folder.write("study.toml", "scene = \"scene.toml\"\n[cluster]\noptions = [\"--mem=1G\"]\n");
  const Outcome none = shell(
      folder, "PATH=/nowhere " PALPATE_PROGRAM " study study.toml -o out --on slurm >/dev/null");
  EXPECT_EQ(none.status, 1);
  EXPECT_TRUE(holds(none.said(), "this machine has no Slurm"));
  EXPECT_TRUE(holds(none.said(), "--on script"));
  const Outcome script = palpate(folder, "study study.toml -o out --on script");
  ASSERT_EQ(script.status, 0) << script.err;
  EXPECT_TRUE(holds(script.out, "#SBATCH --array=0\n"));
  // The script does it, in another shell, as another scheduler would.
  folder.write("script.sh", script.out);
  const Outcome done = shell(folder, "SLURM_ARRAY_TASK_ID=0 bash script.sh");
  EXPECT_EQ(done.status, 0) << done.err;
  const Outcome status = palpate(folder, "study status out");
  EXPECT_TRUE(holds(status.out, "1 cases: 1 done"));
}

TEST_F(StudyOfBlocks, mistakes_are_named_with_their_place) {
  EXPECT_TRUE(holds(refusal("[vary]\nyoung = [1]\n"), "names no section"));
  EXPECT_TRUE(holds(refusal("[vary]\n\"material.young\" = \"1 kPa\"\n"), "is no list of values"));
  EXPECT_TRUE(holds(refusal("[materials]\n"), "is no table of named tables"));
  EXPECT_TRUE(holds(refusal("bodis = 1\n"), "bodies"));
  EXPECT_TRUE(
      holds(refusal("[vary]\n\"material.young\" = [\"1 kPa\", \"1 mm\"]\n"), "case 2 (1 mm)"));
  EXPECT_TRUE(
      holds(refusal("[vary]\n\"material.young\" = [\"1 kPa\", \"1 kPa\"]\n"), "same scene"));
}

}  // namespace
}  // namespace palpate::tools
