// `palpate calibrate` as a user runs it.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "tests/tools/block_scene.hpp"
#include "tools/commands/calibration_answer.hpp"

namespace palpate::tools {
namespace {

using namespace testing_support;
using Json = nlohmann::json;

TEST(calibrate, writes_the_scene_back_with_the_material_of_its_presses) {
  const std::string scene = replaced(kScene, "drag_directions = 1", "drag_directions = 0");
  const BlockFolder block(scene);
  block.write("p.csv", "x_m,y_m,z_m\n0.04,0.04,0.03\n");
  const Outcome simulated = palpate(block, "simulate scene.toml --points p.csv -o s.h5");
  ASSERT_EQ(simulated.status, 0) << simulated.err;
  const std::string other = replaced(scene, "\"10 kPa\"", "\"55 kPa\" # a guess");
  block.write("other.toml", other);
  const Outcome outcome =
      palpate(block, "calibrate --json -o found.toml other.toml --samples s.h5");
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const Json json = Json::parse(outcome.out);
  EXPECT_EQ(json.at("simulated"), 1) << "one press, one modulus";
  EXPECT_NEAR(json.at("parameters")[0].at("value").get<double>(), 10e3, 20);
  EXPECT_LE(json.at("parameters")[0].at("low").get<double>(), 10e3);
  EXPECT_GE(json.at("parameters")[0].at("high").get<double>(), 10e3);
  std::string written = content_of(block / "found.toml");
  EXPECT_TRUE(written.starts_with("# Calibrated by palpate: young = ")) << written;
  written.erase(0, written.find('\n') + 1);
  const std::size_t deviation = written.find("\nyoung_deviation = ");
  ASSERT_NE(deviation, std::string::npos) << written;
  EXPECT_NEAR(std::stod(written.substr(deviation + 19)),
              json.at("parameters")[0].at("deviation").get<double>() / 10e3, 1e-3);
  written.erase(deviation, written.find('\n', deviation + 1) - deviation);
  const std::size_t at = written.find("young = ") + 8, end = written.find(" # a guess");
  written.replace(at, end - at, "\"55 kPa\"");
  EXPECT_EQ(written, other) << "all but the value is kept";
  EXPECT_FALSE(fs::exists(block / "found.toml.partial"));
}

TEST(calibrate, a_modulus_that_nothing_determines_has_a_deviation_that_a_scene_can_hold) {
  fem::Identification found;
  found.material.values = {1e3, 0.45};
  found.free = {0};
  for (const double variance : {1e16, std::numeric_limits<double>::infinity(), std::nan("")}) {
    found.covariance = Eigen::MatrixXd::Constant(1, 1, variance);
    const auto values = CalibrationAnswer(found, 3, false).values();
    ASSERT_EQ(values.size(), 2u);
    EXPECT_EQ(values[1].key, "young_deviation");
    EXPECT_EQ(values[1].value, "10");
  }
}

// A part of the body's own material has no border, and would be searched with it.
TEST(calibrate, refuses_a_part_with_the_material_that_the_search_starts_from) {
  const BlockFolder folder(
      kScene +
      "[[inclusion]]\nsphere = { center = [0.04, 0.04, 0.02], radius = 0.005 }\n"
      "material = { young = \"10 kPa\", poisson = 0.45 }\n");
  folder.write("samples.h5", "");
  const Outcome outcome = palpate(folder, "calibrate scene.toml --samples samples.h5 -o out.toml");
  EXPECT_EQ(outcome.status, 1);
  EXPECT_TRUE(holds(outcome.err, "[[inclusion]] 1: has the material of the body"));
}

}  // namespace
}  // namespace palpate::tools
