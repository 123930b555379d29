// `palpate calibrate` as a user runs it.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>

#include "tests/support/shared_data.hpp"
#include "tests/tools/block_scene.hpp"
#include "tools/commands/calibration_answer.hpp"

namespace palpate::tools {
namespace {

using namespace testing_support;
using Json = nlohmann::json;

class Calibration : public testing::Test {
 protected:
  Outcome calibrate(const std::string& arguments) {
    return palpate(folder, "calibrate --json -o found.toml " + arguments);
  }
  // Of tests in a file of their own.
  Outcome calibrate_tests(const std::string& text) {
    folder.write("tests.toml", text);
    return calibrate("tests.toml");
  }
  Folder folder;
};

TEST_F(Calibration, writes_the_scene_back_with_the_material_of_its_presses) {
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

TEST_F(Calibration, reads_specimens_by_header_by_number_and_by_unit) {
  std::string pull = "A rig; of 2026\nstretch;stress [kPa]\n", shear;
  for (int i = 1; i <= 10; ++i) {
    const double l = 1 + 0.05 * i, y = 0.05 * i;
    pull += std::to_string(l) + ";" + std::to_string(4 * (l - 1 / (l * l))) + "\n";
    shear += std::to_string(0.004 * y) + "\t" + std::to_string(y) + "\n";
  }
  folder.write("pull.csv", pull), folder.write("shear.txt", shear);
  const Outcome outcome = calibrate_tests(R"([material]
young = "1 Pa"
poisson = 0.4999
[[test]]
kind = "uniaxial"
file = "pull.csv"
stretch = "stretch"
stress = "stress"
[[test]]
kind = "simple-shear"
file = "shear.txt"
strain = 2
stress = 1
unit = "MPa"
)");
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_NEAR(Json::parse(outcome.out).at("parameters")[0].at("value").get<double>(), 12e3, 15);
  const std::string written = content_of(folder / "found.toml");
  EXPECT_TRUE(holds(written, "[material]\nlaw = \"neo-hookean\"\nyoung = \"1"));
}

// Five compressions of a silicone; published fits of the same laws are evaluated on the same rows.
TEST_F(Calibration, follows_silicones_no_worse_than_their_published_constants) {
  PALPATE_NEEDS_DATA("data/compression/hyperelastic_parameters.json");
  const fs::path data = palpate::testing_support::shared_data("data/compression");
  const Json all = Json::parse(content_of(data / "hyperelastic_parameters.json")).at("engineering");
  struct Law {
    std::string published, name;
    std::vector<std::string> keys;
    double first = 1;  ///< of their first constant in ours
  };
  const std::vector<Law> laws{{"Neo Hookean", "neo-hookean-isochoric", {"young"}, 3},
                              {"Yeoh_o3", "yeoh", {"c10", "c20", "c30"}},
                              {"Ogden_o1", "ogden", {"mu1", "alpha1"}}};
  for (const std::string silicone : {"EF10_50T", "EF10_100T"})
    for (const Law& law : laws) {
      SCOPED_TRACE(silicone + " " + law.published);
      const Json& published = all.at(silicone).at(law.published);
      std::string text = "[material]\nlaw = \"" + law.name + "\"\npoisson = 0.49999\n";
      for (std::size_t k = 0; k < law.keys.size(); ++k) {
        const double value = published.at("parameters")[k].get<double>();
        text += law.keys[k] + " = " +
                (law.keys[k] == "alpha1"
                     ? std::to_string(value)
                     : "\"" + std::to_string((k == 0 ? law.first : 1) * value) + " kPa\"") +
                "\n";
      }
      for (const std::string specimen : {"A1", "A2", "A3", "B1", "B2"})
        text += "[[test]]\nkind = \"uniaxial\"\nfile = \"" +
                (data / (silicone + "_" + specimen + ".csv")).string() +
                "\"\nstrain = \"Engineering Strain\"\nstress = \"Engineering Stress\"\n";
      const Outcome ours = calibrate_tests(text);
      ASSERT_EQ(ours.status, 0) << ours.err;
      const Json found = Json::parse(ours.out);
      const double before = found.at("sum_of_squares_at_start").get<double>(),
                   after = found.at("sum_of_squares").get<double>();
      EXPECT_LE(after, before * (1 + 1e-6));
      EXPECT_GT(after, 0.2 * before) << "the published constants are meant for these rows";
      std::printf("%s %s: sum of squares %.4g kPa^2, published %.4g\n", silicone.c_str(),
                  law.published.c_str(), after * 1e-6, before * 1e-6);
    }
}

std::string tests_of(const fs::path& data, const std::vector<std::array<std::string, 3>>& files,
                     int strain, int stress, const std::string& unit) {
  std::string text;
  for (const auto& [kind, file, of] : files)
    text += "[[test]]\nkind = \"" + kind + "\"\nfile = \"" + (data / file).string() + "\"\n" + of +
            " = " + std::to_string(strain) + "\nstress = " + std::to_string(stress) +
            "\nunit = \"" + unit + "\"\n";
  return text;
}

// Budday et al. 2017, tables 4 and 7: W = 2 mu/alpha^2 (...), of the same specimens' mean curves.
TEST_F(Calibration, finds_the_published_ogden_constants_of_human_brain) {
  PALPATE_NEEDS_DATA("data/hyperelastic/brain");
  const fs::path data = palpate::testing_support::shared_data("data/hyperelastic/brain");
  const std::map<std::string, std::array<double, 2>> published{{"cortex", {1430, -19.0}},
                                                               {"basal_ganglia", {700, -18.7}},
                                                               {"corona_radiata", {660, -24.3}},
                                                               {"corpus_callosum", {350, -25.3}}};
  for (const auto& [region, constants] : published) {
    SCOPED_TRACE(region);
    const auto [shear_Pa, alpha] = constants;
    const std::string text =
        "[material]\nlaw = \"ogden\"\npoisson = 0.49999\nmu1 = " +
        std::to_string(2 * shear_Pa / alpha) + "\nalpha1 = " + std::to_string(alpha) + "\n" +
        tests_of(data,
                 {{"uniaxial", "uniaxial_tension_" + region + ".txt", "stretch"},
                  {"uniaxial", "compression_" + region + ".txt", "stretch"},
                  {"simple-shear", "simple-shear_" + region + ".txt", "strain"}},
                 1, 2, "kPa");
    const Outcome outcome = calibrate_tests(text);
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const Json found = Json::parse(outcome.out);
    const double mu1 = found.at("parameters")[0].at("value").get<double>(),
                 alpha1 = found.at("parameters")[1].at("value").get<double>();
    EXPECT_NEAR(0.5 * mu1 * alpha1 / shear_Pa, 1, 0.1);
    EXPECT_NEAR(alpha1, alpha, 1.1);
    EXPECT_LE(found.at("sum_of_squares").get<double>(),
              found.at("sum_of_squares_at_start").get<double>());
    EXPECT_GT(found.at("sum_of_squares").get<double>(),
              0.7 * found.at("sum_of_squares_at_start").get<double>());
  }
}

// A step of this search took mu2 past the largest number, which was told as the user's mistake.
TEST_F(Calibration, a_search_that_goes_far_stays_finite) {
  PALPATE_NEEDS_DATA("data/hyperelastic/Kawabata_1981_UT.txt");
  const fs::path data = palpate::testing_support::shared_data("data/hyperelastic");
  const std::string text =
      "[material]\nlaw = \"ogden\"\npoisson = 0.49999\nmu1 = \"400 kPa\"\nalpha1 = 2\n"
      "mu2 = \"-5 kPa\"\nalpha2 = -2\n" +
      tests_of(data,
               {{"uniaxial", "Kawabata_1981_UT.txt", "stretch"},
                {"equibiaxial", "Kawabata_1981_ET.txt", "stretch"},
                {"planar", "Kawabata_1981_PS.txt", "stretch"}},
               2, 1, "MPa");
  const Outcome outcome = calibrate_tests(text);
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_NEAR(Json::parse(outcome.out).at("sum_of_squares").get<double>() * 1e-12, 0.00777, 1e-4);
}

TEST(calibrate, a_modulus_that_nothing_determines_has_a_deviation_that_a_scene_can_hold) {
  fem::Identification found;
  found.material.values = {1e3, 0.45};
  found.free = {0};
  for (const double variance : {1e16, std::numeric_limits<double>::infinity(), std::nan("")}) {
    found.covariance = Eigen::MatrixXd::Constant(1, 1, variance);
    const auto values = CalibrationAnswer(found, 3, "N", false).values();
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

// Once a table in percent gave a modulus of 104 Pa for 12 kPa, and no word.
TEST(calibrate, a_wrong_unit_or_sign_of_a_test_is_told) {
  const Folder folder;
  const auto answer = [&](double times, double sign) {
    std::string rows = "l,P\n";
    for (const double l : {1.0, 1.05, 1.1, 1.2, 1.3})
      rows += std::to_string(times * l) + "," + std::to_string(sign * 4 * (l - 1 / (l * l))) + "\n";
    folder.write("pull.csv", rows);
    folder.write("tests.toml",
                 "[material]\nyoung = \"10 kPa\"\n[[test]]\nfile = \"pull.csv\"\n"
                 "stretch = \"l\"\nstress = \"P\"\nunit = \"kPa\"\n");
    return palpate(folder, "calibrate tests.toml -o c.toml").err;
  };
  EXPECT_FALSE(holds(answer(1, 1), "warning"));
  EXPECT_TRUE(holds(answer(100, 1), "the stretch reaches 130; percent are to be divided by 100"));
  EXPECT_TRUE(holds(answer(1, -1), "a unit, a sign or a column is wrong"));
}

}  // namespace
}  // namespace palpate::tools
