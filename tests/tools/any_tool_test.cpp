// One asset and tools that its curves were not measured with: stated, validated, replayed, checked.

#include <nlohmann/json.hpp>
#include <sstream>

#include "libfit/io/atomic_file.hpp"
#include "libfit/io/files/files.hpp"
#include "tests/tools/block_scene.hpp"
#include "tests/tools/stopped.hpp"

namespace palpate::tools {
namespace {

using namespace testing_support;

std::string scene_with(const std::string& probe, const std::string& more = "") {
  return replaced(kScene, "radius = \"8 mm\"\nfriction = 0.3\n", probe + "friction = 0.3\n") + more;
}

// The block with a top that is bulged by 15 mm, whose triangles a region divides.
std::string bulged_off() {
  std::istringstream in(block_off(8));
  std::string line, text;
  for (int number = 0; std::getline(in, line); ++number) {
    double x = 0, y = 0, z = 0;
    const bool is_vertex =
        number > 1 && line[0] != '3' && std::sscanf(line.c_str(), "%lf %lf %lf", &x, &y, &z) == 3;
    const auto arch = [](double at) { return 1 - (at / 40 - 1) * (at / 40 - 1); };
    text += !is_vertex ? line
                       : std::to_string(x) + " " + std::to_string(y) + " " +
                             std::to_string(z * (1 + 0.5 * arch(x) * arch(y)));
    text += "\n";
  }
  return text;
}

class AnyTool : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new BlockFolder(scene_with("radius = \"8 mm\"\n",
                                         "[[experiments.probe]]\nradius = \"5 mm\"\npoints = 2\n"
                                         "[[validate.tool]]\nname = \"cone\"\nshape = \"cone\"\n"
                                         "half_angle = \"60 deg\"\ntip_radius = \"1 mm\"\n"
                                         "points = 2\n"));
    folder_->write("small.toml", scene_with("radius = \"5 mm\"\n"));
    folder_->write("lying.toml", scene_with("shape = \"capsule\"\nradius = \"4 mm\"\n"
                                            "length = \"20 mm\"\norientation = \"lying\"\n"));
    const Outcome run = palpate(*folder_, "run scene.toml -o out");
    ASSERT_EQ(run.status, 0) << run.err;
    ASSERT_TRUE(holds(run.said(), "  radius   "));
  }
  static void TearDownTestSuite() { delete folder_; }
  static double p95_of(const nlohmann::json& lines, const std::string& name) {
    return lines.at(name).at("p95_rel").get<double>();
  }

  static Folder* folder_;
};
Folder* AnyTool::folder_ = nullptr;

TEST_F(AnyTool, statement_has_a_section_for_each_tool) {
  const auto json = nlohmann::json::parse(read_whole_file(*folder_ / "out/statement.json"));
  ASSERT_TRUE(json.contains("tool:cone")) << json.dump();
  const auto& lines = json.at("tool:cone");
  EXPECT_LT(p95_of(lines, "all"), 0.15);
  EXPECT_GT(p95_of(lines, "as_the_assets_ball"), 2 * p95_of(lines, "all"));
  EXPECT_FALSE(lines.contains("times_root_of_radius"));  // it is no ball
  const Samples samples = read_samples(*folder_ / "out/samples.h5");
  ASSERT_EQ(samples.other_probes.size(), 1U);
  EXPECT_EQ(ball_radius_m(samples.other_probes[0]), 0.005);
}

TEST_F(AnyTool, validate_states_another_probe_of_the_scene) {
  const Outcome own = palpate(*folder_, "validate --json out/asset.palp scene.toml");
  const Outcome small = palpate(*folder_, "validate --json out/asset.palp small.toml");
  ASSERT_EQ(small.status, 0) << small.err;
  EXPECT_TRUE(holds(small.said(), "was measured with another probe"));
  const auto json = nlohmann::json::parse(small.out);
  EXPECT_GT(p95_of(json.at("baselines"), "as_the_assets_ball"), 0.2);
  EXPECT_LT(p95_of(json.at("baselines"), "times_root_of_radius"),
            p95_of(json.at("baselines"), "as_the_assets_ball"));
  EXPECT_LT(json.at("force_error").at("p95_rel").get<double>(), 0.1);
}

TEST_F(AnyTool, replay_plays_the_round_end_of_a_scenes_probe) {
  folder_->write("path.csv", "t_s,x_m,y_m,z_m\n0,0.04,0.04,0.031\n0.1,0.04,0.04,0.0285\n");
  double force_N[2];
  for (const int i : {0, 1}) {
    const std::string tool = i == 0 ? "scene.toml" : "small.toml";
    const Outcome outcome =
        palpate(*folder_, "replay out/asset.palp path.csv -o f.csv --tool " + tool);
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const std::string table = read_whole_file(*folder_ / "f.csv");
    const std::string last = table.substr(table.rfind('\n', table.size() - 2) + 1);
    double t = 0, x = 0, y = 0;
    ASSERT_EQ(std::sscanf(last.c_str(), "%lf,%lf,%lf,%lf", &t, &x, &y, &force_N[i]), 4) << last;
  }
  EXPECT_NEAR(force_N[1] / force_N[0], std::sqrt(5.0 / 8), 0.06);  // Hertz: sqrt(R)
  const Outcome lying =
      palpate(*folder_, "replay out/asset.palp path.csv -o f.csv --tool lying.toml");
  EXPECT_EQ(lying.status, 1);
  EXPECT_TRUE(holds(lying.said(), "not round along its press"));
}

TEST_F(AnyTool, check_slides_it_and_inspect_describes_it) {
  double stiffness_N_m[2];
  for (const int i : {0, 1}) {
    const Outcome check = palpate(*folder_, std::string("check --json out/asset.palp") +
                                                (i == 0 ? "" : " --tool small.toml"));
    EXPECT_EQ(check.status, 0) << check.err;
    stiffness_N_m[i] = nlohmann::json::parse(check.out).at("k_max_N_m");
  }
  EXPECT_LT(stiffness_N_m[1], stiffness_N_m[0]);
  const Outcome inspect = palpate(*folder_, "inspect --json out/asset.palp --tool small.toml");
  ASSERT_EQ(inspect.status, 0) << inspect.err;
  EXPECT_EQ(nlohmann::json::parse(inspect.out).at("round_end_m"), 0.005);
}

TEST_F(AnyTool, of_a_scene_without_a_ball_is_refused) {
  folder_->write("flat.toml", scene_with("shape = \"flat\"\nradius = \"6 mm\"\n",
                                         "[[validate.tool]]\nradius = \"5 mm\"\n"));
  const Outcome flat = palpate(*folder_, "run flat.toml -o out_of_flat");
  EXPECT_EQ(flat.status, 1);
  EXPECT_TRUE(holds(flat.said(), "is played by what a ball identifies"));
  folder_->write("round.toml", scene_with("radius = \"8 mm\"\n",
                                          "[[validate.tool]]\nshape = \"capsule\"\nradius = "
                                          "\"4 mm\"\nlength = \"20 mm\"\norientation = "
                                          "\"lying\"\n"));
  const Outcome round = palpate(*folder_, "run round.toml -o out_of_round");
  EXPECT_EQ(round.status, 1);
  EXPECT_TRUE(holds(round.said(), "Say what it is played as"));
}

// A smaller ball and another depth divide the region otherwise, and that was an error.
TEST(Validate, states_a_scene_that_divides_the_surface_otherwise_and_resumes_where_it_was_stopped) {
  const Folder folder;
  folder.write("block.off", bulged_off());
  std::string text = replaced(kScene, "\"29 mm\"], [\"60 mm\", \"60 mm\", \"31 mm\"]",
                              "\"29 mm\"], [\"60 mm\", \"60 mm\", \"50 mm\"]");
  folder.write("scene.toml", text);
  text = replaced(text, "radius = \"8 mm\"", "radius = \"3 mm\"");
  text = replaced(text, "depth = \"4 mm\"", "depth = \"2 mm\"");
  text = replaced(text, "drag_depths = [\"3 mm\"]", "drag_depths = [\"1.5 mm\"]");
  text = replaced(text, "points = 2\n", "points = 5\n");
  folder.write("small.toml", text);
  ASSERT_NE(palpate(folder, "run scene.toml -o out").status, 1);
  const fs::path kept = folder / "out/asset.small.reference/reference.h5";
  const int raw = stopped(
      SIGINT,
      {"validate", folder / "out/asset.palp", folder / "small.toml", "--jobs", "1", "--quiet"},
      [&] { return fs::exists(kept.string() + ".partial"); });
  ASSERT_EQ(exit_status(raw), 130) << "it ended before the interrupt";

  const auto force_error = [&](const std::string& more, std::string* said) {
    const Outcome outcome = palpate(folder, "validate --json out/asset.palp small.toml" + more);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    if (said != nullptr) *said = outcome.said();
    return nlohmann::json::parse(outcome.out).at("force_error");
  };
  std::string said;
  const auto resumed = force_error("", &said);
  EXPECT_TRUE(holds(said, "divided as the asset's"));
  EXPECT_TRUE(holds(said, "resuming"));
  EXPECT_LT(resumed.at("p95_rel").get<double>(), 0.2);
  EXPECT_TRUE(fs::exists(kept));
  fs::create_directory(folder / "other");
  EXPECT_EQ(force_error(" --reference other", nullptr), resumed);

  folder.write("refused.toml", text);
  EXPECT_EQ(palpate(folder, "validate out/asset.palp refused.toml --curves c.h5").status, 1);
  EXPECT_FALSE(fs::exists(folder / "out/asset.refused.reference"));
}

}  // namespace
}  // namespace palpate::tools
