// What commands on a finished run say: `inspect` as a page, `replay` of paths that feel nothing,
// `export` by the name of the file.

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "libfit/io/files/files.hpp"
#include "tests/tools/kept_run.hpp"

namespace palpate::tools {
namespace {

using namespace testing_support;

class AssetCommands : public KeptRun {
 protected:
  static Outcome replay(const std::string& rows) {
    std::ofstream(path("path.csv")) << "t_s,x_m,y_m,z_m\n" << rows;
    return palpate(*folder_, "replay --json out/asset.palp path.csv -o f.csv");
  }
};

TEST_F(AssetCommands, inspect_is_a_page_that_a_person_reads) {
  const Outcome outcome = palpate(*folder_, "inspect out/asset.palp");
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  for (const char* line :
       {"\n  body        80 x 80 x 30 mm, closed surface, 386 vertices and 768 triangles\n",
        "\n              x 0 to 80, y 0 to 80, z 0 to 30 mm\n", "\n  window      ",
        "\n  probe       sphere, friction 0.3, radius 8 mm, played as a ball\n",
        "\n  curves      family ", "fitted to a depth of ", "\n  certificate ",
        ": 19 of 20 forces are within ", "\n  size        ", "\n  made by     palpate "})
    EXPECT_TRUE(holds(outcome.out, line));
  EXPECT_EQ(outcome.out.find('{'), std::string::npos) << outcome.out;
  EXPECT_LE(std::ranges::count(outcome.out, '\n'), 24) << "lines of a screen: " << outcome.out;
  std::istringstream lines(outcome.out.substr(outcome.out.find("\n  body")));
  for (std::string line; std::getline(lines, line);)
    EXPECT_TRUE(line.size() <= 100 || line.find("palpate check") != std::string::npos) << line;
}

TEST_F(AssetCommands, a_replay_that_feels_nothing_says_why) {
  const Outcome good = replay("0,0.04,0.04,0.031\n0.1,0.04,0.04,0.028\n");
  EXPECT_EQ(good.status, 0) << good.err;
  EXPECT_EQ(nlohmann::json::parse(good.out).at("in_contact"), 1);
  EXPECT_FALSE(holds(good.err, "the path"));
  const Outcome inside = replay("0,0.04,0.04,0.027\n0.1,0.04,0.04,0.026\n");
  EXPECT_TRUE(holds(inside.err, "begins 3 mm inside the body"));
  EXPECT_TRUE(holds(inside.err, "never touches the body"));
  const Outcome away = replay("0,0.04,0.04,0.045\n0.1,0.04,0.04,0.042\n");
  EXPECT_FALSE(holds(away.err, "inside"));
  EXPECT_TRUE(holds(away.err, "never touches the body"));
  EXPECT_TRUE(holds(away.err, "its nearest row is 12 mm from"));
  EXPECT_EQ(nlohmann::json::parse(away.out).at("warnings").size(), 1u) << away.out;
  std::ofstream(path("scene.toml")) << kScene;  // whose ball ends in the path's point
  std::ofstream(path("ball.csv")) << "t_s,x_m,y_m,z_m\n0,0.04,0.04,0.027\n0.1,0.04,0.04,0.026\n";
  const Outcome ball =
      palpate(*folder_, "replay out/asset.palp ball.csv --tool scene.toml -o f.csv");
  EXPECT_TRUE(holds(ball.err, "begins 3 mm inside the body")) << ball.err;
}

TEST_F(AssetCommands, a_replay_beyond_the_curves_says_so) {
  const Outcome outcome = replay("0,0.04,0.04,0.031\n0.1,0.04,0.04,0.028\n0.2,0.04,0.04,0.02\n");
  EXPECT_TRUE(holds(outcome.err, "1 of 2 ticks in contact go beyond the curves"));
}

TEST_F(AssetCommands, a_replay_by_the_clock_writes_the_bytes_of_a_plain_one) {
  std::ofstream file(path("path.csv"));
  file << "t_s,x_m,y_m,z_m\n";
  for (int i = 0; i < 400; ++i)
    file << 0.001 * i << ',' << 0.04 + 1e-5 * std::max(i - 150, 0) << ",0.04,"
         << 0.0305 - 0.0025 * std::min({i, 100, 500 - i}) / 100 << '\n';
  file.close();
  std::ofstream(path("scene.toml")) << kScene;
  for (const std::string tool : {"", " --tool scene.toml"}) {
    const std::string line = "replay out/asset.palp path.csv" + tool;
    const Outcome plain = palpate(*folder_, line + " -o plain.csv");
    ASSERT_EQ(plain.status, 0) << plain.err;
    const Outcome live = palpate(*folder_, line + " -o live.csv --realtime 1000");
    ASSERT_EQ(live.status, 0) << live.err;
    EXPECT_TRUE(holds(live.said(), "400 ticks at 1000 Hz")) << live.said();
    EXPECT_EQ(content_of(path("live.csv")), content_of(path("plain.csv"))) << tool;
  }
}

TEST_F(AssetCommands, columns_that_say_nothing_are_named) {
  std::ofstream(path("path.csv"))
      << "t_s,x_m,y_m,z_m,vx,vy\n0,0.04,0.04,0.031,1,0\n0.1,0.04,0.04,0.028,1,0\n";
  const Outcome outcome = palpate(*folder_, "replay out/asset.palp path.csv -o f.csv");
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_TRUE(holds(outcome.err, "path.csv: columns are not used: vx, vy"));
  std::ofstream(path("points.csv")) << "x_m,y_m,z_m,depth_m\n0.04,0.04,0.03,0.002\n";
  std::ofstream(path("paths.csv"))
      << "t_s,path,x_m,y_m,z_m,dx_m,dy_m,dz_m\n0,a,0.04,0.04,0.03,0,0,-0.001\n";
  for (const auto& [option, column] : {std::pair{"points", "depth_m"}, {"paths", "t_s"}}) {
    const std::string file = std::string(option) + ".csv";
    const Outcome simulated =
        palpate(*folder_, std::string("simulate out/body.h5 -o s.h5 --") + option + " " + file);
    EXPECT_EQ(simulated.status, 0) << simulated.err;
    EXPECT_TRUE(holds(simulated.err, file + ": a column is not used: " + column));
  }
  const Samples followed = read_samples(path("s.h5"));
  ASSERT_EQ(followed.rows(), 1);
  EXPECT_EQ(followed.kind[0], ExperimentKind::path);
  EXPECT_EQ(followed.deflection(0, 2), -0.001);
}

TEST_F(AssetCommands, curves_of_another_body_are_no_model) {
  FittedCurves curves = read_curves(path("out/curves.h5"));
  curves.position.col(2).array() += 0.1;
  write_curves(path("far.h5"), curves, {});
  const Outcome outcome = palpate(*folder_, "refine far.h5 --body out/body.h5 -o m.h5");
  EXPECT_EQ(outcome.status, 1) << outcome.err;
  EXPECT_TRUE(holds(outcome.err, "lies on this body"));
  EXPECT_FALSE(std::filesystem::exists(path("m.h5")));
}

TEST_F(AssetCommands, an_export_is_scaled_to_a_recorded_press) {
  const auto force_N = [](const std::string& asset) {
    const Outcome outcome = palpate(*folder_, "replay " + asset + " press.csv -o f.csv");
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    std::istringstream last(content_of(path("f.csv")));
    std::string line, force;
    while (std::getline(last, line) && !line.empty()) force = line;
    for (int comma = 0; comma < 3; ++comma) force = force.substr(force.find(',') + 1);
    return std::stod(force);
  };
  const std::string rows[] = {"0,0.04,0.04,0.031", "0.1,0.04,0.04,0.029", "0.2,0.04,0.04,0.028"};
  std::ofstream(path("press.csv")) << "t_s,x_m,y_m,z_m\n" << rows[0] << '\n' << rows[2] << '\n';
  const double before_N = force_N("out/asset.palp");
  std::ofstream(path("recorded.csv")) << "t_s,x_m,y_m,z_m,force_N\n"
                                      << rows[0] << ",0\n"
                                      << rows[2] << "," << 2 * before_N << '\n';
  const Outcome scaled = palpate(
      *folder_, "export out/model.h5 -o scaled.palp --friction 0.2 --scale-to recorded.csv --json");
  ASSERT_EQ(scaled.status, 0) << scaled.err;
  EXPECT_TRUE(holds(scaled.err, "forces times 2 +- ")) << scaled.err;
  const auto changed = nlohmann::json::parse(scaled.out).at("changed");
  EXPECT_NEAR(changed.at("stiffness").get<double>(), 2, 1e-4);
  EXPECT_EQ(changed.at("friction"), 0.2);
  EXPECT_NEAR(force_N("scaled.palp"), 2 * before_N, 1e-4 * before_N);
  const Outcome named = palpate(*folder_, "inspect scaled.palp --json");
  EXPECT_EQ(nlohmann::json::parse(named.out).at("meta").at("changed"), changed);
  for (const char* options :
       {"--scale-stiffness 0", "--scale-stiffness soft", "--friction -1", "--scale-to press.csv",
        "--scale-to recorded.csv --scale-stiffness 2"}) {
    const Outcome refused =
        palpate(*folder_, std::string("export out/model.h5 -o no.palp ") + options);
    EXPECT_EQ(refused.status, 1) << options;
    EXPECT_FALSE(std::filesystem::exists(path("no.palp"))) << options;
  }
}

// It pressed from +z on the middle of the box, beside this window, and printed zeros.
TEST_F(AssetCommands, the_example_in_c_presses_where_curves_were_measured) {
  const std::string out = path("loop.txt");
  ASSERT_EQ(std::system((PALPATE_LOOP " " + path("out/asset.palp") + " > " + out).c_str()), 0);
  EXPECT_TRUE(holds(content_of(out), "stick"));
}

// The block is 80 x 80 x 30 mm; its top is z 30.
TEST_F(AssetCommands, an_asset_moves_a_mesh_of_the_users_own) {
  std::ofstream(path("mine.obj")) << "v 10 10 31\nvt 0 0\nv 0 0 0\nv 80 80 30\nv 40 40 29.5\n";
  const Outcome outcome =
      palpate(*folder_, "export out/asset.palp --visual mine.obj -o mine.palp --json");
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const auto visual = nlohmann::json::parse(outcome.out).at("visual");
  EXPECT_EQ(visual.at("vertices"), 4);
  EXPECT_EQ(visual.at("unit"), "mm");
  EXPECT_NEAR(visual.at("max_m").get<double>(), 0.001, 1e-8);
  const Outcome page = palpate(*folder_, "inspect mine.palp");
  EXPECT_TRUE(holds(page.out, "19 of 20 forces")) << page.out;
  EXPECT_TRUE(holds(page.out, "moves a mesh of 4 vertices")) << page.out;
  EXPECT_EQ(
      palpate(*folder_, "export out/model.h5 --friction 0.2 --visual mine.obj -o m.palp").status,
      0);
  std::ofstream(path("off.obj")) << "v 10 10 35\nv 40 40 36\nv 60 40 35\n";
  EXPECT_TRUE(holds(palpate(*folder_, "export out/asset.palp --visual off.obj -o off.palp").err,
                    "half of off.obj is more than 5 mm off the surface"));
  std::ofstream(path("far.obj")) << "v 0 0 130\nv 80 80 100\n";
  std::ofstream(path("empty.obj")) << "# nothing\n";
  for (const auto& [words, says] :
       {std::pair{"out/asset.palp --visual far.obj -o no.palp",
                  "far.obj: vertex 1, taken in mm, is 100 mm from the surface of the body"},
        {"out/asset.palp --visual empty.obj -o no.palp", "empty.obj"},
        {"out/asset.palp --visual none.obj -o no.palp", "none.obj"},
        {"out/asset.palp --visual mine.obj --friction 0.2 -o no.palp", "takes --visual alone"}}) {
    const Outcome refused = palpate(*folder_, std::string("export ") + words);
    EXPECT_EQ(refused.status, 1) << words;
    EXPECT_TRUE(holds(refused.err, says)) << refused.err;
    EXPECT_FALSE(std::filesystem::exists(path("no.palp"))) << words;
  }
}

}  // namespace
}  // namespace palpate::tools
