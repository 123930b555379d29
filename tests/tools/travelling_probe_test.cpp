// The probe travels with the data: what `run` makes, the stage commands make from files alone, and
// an asset of recordings says what they were recorded with.

#include <gtest/gtest.h>

#include <cstring>
#include <nlohmann/json.hpp>

#include "libfit/io/files/files.hpp"
#include "libfit/runtime/asset/format.hpp"
#include "tests/tools/block_scene.hpp"
#include "tests/tools/command_line.hpp"

namespace palpate::tools {
namespace {

using namespace testing_support;

// An octahedron of 16 mm, outward.
const char* const kOctahedron =
    "OFF\n6 8 0\n8 0 0\n-8 0 0\n0 8 0\n0 -8 0\n0 0 8\n0 0 -8\n"
    "3 0 2 4\n3 2 1 4\n3 1 3 4\n3 3 0 4\n3 2 0 5\n3 1 2 5\n3 3 1 5\n3 0 3 5\n";

// What an asset holds but its meta, where `run` adds the error statement.
std::string without_meta(const std::string& asset) {
  runtime::Header header;
  std::memcpy(&header, asset.data(), sizeof header);
  return asset.substr(sizeof header, header.offset[runtime::kMeta] - sizeof header);
}

nlohmann::json meta_of(const std::string& asset) {
  runtime::Header header;
  std::memcpy(&header, asset.data(), sizeof header);
  return nlohmann::json::parse(asset.substr(header.offset[runtime::kMeta], header.meta_bytes));
}

class TravellingProbe : public BlockRun {
 protected:
  void do_command(const std::string& line, int status = 0) {
    const Outcome outcome = palpate(folder, line);
    ASSERT_EQ(outcome.status, status) << line << '\n' << outcome.err;
  }
};

TEST_F(TravellingProbe, stage_by_stage_from_files_alone_gives_the_bytes_of_run) {
  // A mesh probe beside the scene, and presses alone: the limit curves are the friction times the
  // normal ones, so a friction that gets lost shows.
  fs::create_directories(folder / "scenes");
  folder.write("scenes/block.off", block_off(8));
  folder.write("scenes/tool.off", kOctahedron);
  std::string text =
      replaced(kScene, "radius = \"8 mm\"\nfriction = 0.3",
               "shape = \"mesh\"\nmesh = \"tool.off\"\nlength_unit = \"mm\"\nsmoothing = \"2 mm\"\n"
               "friction = 0.8");
  text = replaced(text, "depth = \"4 mm\"\npress_steps = 5", "depth = \"2 mm\"\npress_steps = 3");
  folder.write("scenes/scene.toml", replaced(text, "drag_depths = [\"3 mm\"]", "drag_depths = []"));
  const Outcome whole = palpate(folder, "run scenes/scene.toml -o out");
  ASSERT_EQ(whole.status, 0) << whole.err;

  fs::create_directories(folder / "step");
  do_command("prepare scenes/scene.toml -o step/body.h5");
  fs::remove_all(folder / "scenes");  // nothing but files of before from here on
  do_command("simulate step/body.h5 -o step/samples.h5");
  do_command("fit step/samples.h5 -o step/curves.h5");
  do_command(
      "refine step/curves.h5 --body step/body.h5 --samples step/samples.h5 -o step/model.h5");
  do_command("export step/model.h5 -o step/asset.palp");
  for (const char* file : {"body.h5", "samples.h5", "samples.surface.h5", "curves.h5", "model.h5"})
    EXPECT_TRUE(content_of(folder / "out" / file) == content_of(folder / "step" / file)) << file;
  const std::string ran = content_of(folder / "out" / "asset.palp");
  const std::string stepped = content_of(folder / "step" / "asset.palp");
  EXPECT_TRUE(without_meta(ran) == without_meta(stepped));
  for (const auto& meta : {meta_of(ran), meta_of(stepped)}) {
    EXPECT_EQ(meta.at("probe").at("shape"), "mesh");
    EXPECT_EQ(meta.at("probe").at("friction"), 0.8);
    EXPECT_EQ(meta.at("probe").at("smoothing_m"), 0.002);
    EXPECT_EQ(meta.at("probe").at("mesh_triangles"), 8);
  }
  EXPECT_TRUE(holds(palpate(folder, "fit step/samples.h5 -o again.h5").said(),
                    "the limit of friction 0.76 of the normal force"));
}

TEST_F(TravellingProbe, another_setting_of_experiments_leaves_the_body_and_reaches_its_file) {
  ASSERT_EQ(run("out").status, 0);
  folder.write("scene.toml", replaced(kScene, "friction = 0.3", "friction = 0.4"));
  const Outcome again = run("out");
  ASSERT_EQ(again.status, 0) << again.err;
  EXPECT_TRUE(holds(again.said(), "body.h5 is up to date"));
  EXPECT_FALSE(holds(again.said(), "samples.h5 is up to date"));
  do_command("simulate out/body.h5 -o samples.h5");
  EXPECT_TRUE(content_of(folder / "samples.h5") == content_of(folder / "out" / "samples.h5"));
}

// It compared as if the probes were one: forces 22 to 100 % off, and not a word.
TEST_F(TravellingProbe, of_another_probe_than_the_assets_validate_says_so) {
  ASSERT_EQ(run("out").status, 0);
  folder.write("other.toml", replaced(kScene, "\"8 mm\"", "\"6 mm\""));
  const std::string validate = "validate out/asset.palp ",
                    options = " --points 1 --no-causes --json";
  const Outcome own = palpate(folder, validate + "scene.toml" + options);
  ASSERT_EQ(own.status, 0) << own.err;
  EXPECT_FALSE(holds(own.said(), "probe"));
  const Outcome other = palpate(folder, validate + "other.toml" + options);
  ASSERT_EQ(other.status, 0) << other.err;
  const std::string said =
      "was measured with another probe (sphere, friction 0.3, radius_m 0.008) than the scene's "
      "(sphere, friction 0.3, radius_m 0.006)";
  EXPECT_TRUE(holds(other.said(), said));
  EXPECT_TRUE(holds(nlohmann::json::parse(other.out).at("warnings").dump(), said)) << other.out;
}

std::string recordings_of(const std::string& probe) {
  std::string text = "[defaults]\n" + kPressKeys + "normal = [0, 0, -1]\n" + probe;
  for (const char* place : {"20, 20", "60, 20", "60, 60", "20, 60"})
    text += "[[recording]]\nfile = \"a.csv\"\npoint = \"" + std::string(place) +
            "\"\nposition = [" + place + ", 30]\n";
  return text;
}

TEST_F(TravellingProbe, recordings_of_a_2_mm_ball_make_an_asset_that_says_so) {
  folder.write("a.csv", press_csv(1000));
  folder.write(
      "manifest.toml",
      recordings_of("probe = { shape = \"sphere\", radius = \"2 mm\", friction = 0.6 }\n"));
  do_command("import manifest.toml -o samples.h5");
  const Outcome fitted = palpate(folder, "fit samples.h5 -o curves.h5");
  EXPECT_TRUE(holds(fitted.said(), "the limit of friction 0.57 of the normal force"));
  // The scene of the body says 8 mm and 0.3, which is none of the recordings' business.
  do_command("prepare --surface-only scene.toml -o body.h5");
  do_command("refine curves.h5 --body body.h5 -o model.h5");
  do_command("export model.h5 -o asset.palp");
  const std::string asset = content_of(folder / "asset.palp");
  runtime::Header header;
  std::memcpy(&header, asset.data(), sizeof header);
  EXPECT_EQ(header.probe_radius_m, 0.002);
  EXPECT_EQ(meta_of(asset).at("probe").at("radius_m"), 0.002);
  EXPECT_EQ(meta_of(asset).at("probe").at("friction"), 0.6);
}

TEST_F(TravellingProbe, recordings_of_two_probes_are_samples_of_both) {
  folder.write("a.csv", press_csv(1000));
  folder.write("manifest.toml",
               recordings_of("probe = { radius = \"2 mm\" }\n") +
                   "[[recording]]\nfile = \"a.csv\"\npoint = \"e\"\nposition = [40, 40, 30]\n"
                   "probe = { radius = \"3 mm\" }\n");
  const Outcome outcome = palpate(folder, "import manifest.toml -o samples.h5");
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const Samples samples = read_samples(folder / "samples.h5");
  EXPECT_EQ(ball_radius_m(samples.probe), 0.002);
  ASSERT_EQ(samples.other_probes.size(), 1U);
  EXPECT_EQ(ball_radius_m(samples.other_probes[0]), 0.003);
  for (std::size_t row = 0; row < samples.kind.size(); ++row) {
    const bool is_other = samples.point_name[static_cast<std::size_t>(samples.point[row])] == "e";
    EXPECT_EQ(samples.probe_number[row], is_other ? 1 : 0) << row;
    EXPECT_EQ(samples.kind[row], is_other ? ExperimentKind::other : ExperimentKind::press) << row;
  }
}

}  // namespace
}  // namespace palpate::tools
