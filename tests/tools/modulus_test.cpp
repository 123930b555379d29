// `palpate modulus` as a user runs it.

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "tests/support/shared_data.hpp"
#include "tests/tools/command_line.hpp"
#include "tools/report/packed.hpp"

namespace palpate::tools {
namespace {

using namespace testing_support;

// A press of a paraboloid of 5 mm on E = 10 kPa (F = 4/3 E / 0.75 sqrt(R) d^1.5) after 2 mm, 4 mm
// deep; or of a body that pushes back as the tenth power of depth.
std::string press(double young_Pa, bool is_odd = false) {
  std::string text = "t,d,F\n";
  for (int i = 0; i < 300; ++i) {
    const double depth_mm = std::max(0.0, 0.02 * i - 2);
    const double force_N =
        is_odd ? 0.5 * std::pow(depth_mm / 4, 10)
               : young_Pa * 4 / 2.25 * std::sqrt(5e-3) * std::pow(1e-3 * depth_mm, 1.5);
    text += std::to_string(0.01 * i) + "," + std::to_string(0.02 * i) + "," +
            std::to_string(force_N + 1e-4 * ((i * 7919) % 11 - 5)) + "\n";
  }
  return text;
}

const std::string kManifest = R"([defaults]
columns = { time = "t", depth = "d", force = "F" }
units = { time = "s", position = "mm", force = "N" }
force_on = "body"
normal = [0, 0, -1]
probe = { shape = "sphere", radius = "5 mm" }
[[recording]]
file = "a.csv"
point = "soft"
position = [0, 0, 40]
[[recording]]
file = "b.csv"
point = "stiff"
position = [10, 5, 40]
)";

struct Answer {
  Outcome outcome;
  std::string table, models;
  nlohmann::json pictures;  // of the page; null where no page is built
};

Answer answer(const Folder& folder, const std::string& more = "") {
  Answer out;
  out.outcome = palpate(folder, "modulus " + (folder / "manifest.toml").string() + " -o " +
                                    (folder / "m.csv").string() + " " + more);
  if (!fs::exists(folder / "m.csv")) return out;
  out.table = content_of(folder / "m.csv"), out.models = content_of(folder / "m.models.csv");
  if (!fs::exists(folder / "m.html")) return out;
  const std::string page = content_of(folder / "m.html"), begin = "id=\"contents\">";
  const std::size_t first = page.find(begin) + begin.size();
  out.pictures = nlohmann::json::parse(page.substr(first, page.find("</script>", first) - first))
                     .at("pictures");
  return out;
}

// A field of the row of a point.
std::string field(const std::string& table, const std::string& point, int column) {
  const std::size_t begin = table.rfind('\n', table.find("," + point + ","));
  std::istringstream fields(table.substr(begin + 1));
  std::string value;
  for (int k = 0; k <= column; ++k) std::getline(fields, value, ',');
  return value;
}

TEST(modulus, is_that_of_the_law_with_a_map_a_cloud_and_a_page) {
  const Folder folder;
  folder.write("manifest.toml", kManifest), folder.write("a.csv", press(1e4)),
      folder.write("b.csv", press(3e4));
  const Answer got = answer(folder, "--models hertz,power");
  ASSERT_EQ(got.outcome.status, 0) << got.outcome.err;
  EXPECT_NEAR(std::stod(field(got.table, "soft", 6)), 1e4, 50) << got.table;
  EXPECT_NEAR(std::stod(field(got.table, "stiff", 6)), 3e4, 150) << got.table;
  EXPECT_EQ(field(got.table, "stiff", 2), "0.01");
  EXPECT_NEAR(std::stod(field(got.table, "soft", 8)), 2e-3, 5e-6);
  EXPECT_NEAR(std::stod(field(got.table, "soft", 14)), 1.5, 0.01);
  const std::string cloud = content_of(folder / "m.vtu");
  EXPECT_NE(cloud.find("NumberOfPoints=\"2\" NumberOfCells=\"2\""), std::string::npos);
  EXPECT_NE(cloud.find("young_Pa"), std::string::npos);
  if (!got.pictures.is_null()) {
    EXPECT_EQ(got.pictures.at("point"), (nlohmann::json{"soft", "stiff"}));
    EXPECT_EQ(got.pictures.at("model"), (nlohmann::json{"hertz", "hertz"}));
    const auto young = unpacked<float>(got.pictures.at("young_Pa")),
               fitted = unpacked<float>(got.pictures.at("fitted_N")),
               push = unpacked<float>(got.pictures.at("push_N")),
               bias = unpacked<float>(got.pictures.at("bias_N")),
               place = unpacked<float>(got.pictures.at("position_m"));
    EXPECT_NEAR(young.at(1), 3e4, 150);
    EXPECT_FLOAT_EQ(place.at(4), 0.005f);
    const auto readings = got.pictures.at("readings")[0].get<std::size_t>();
    for (std::size_t i = 0; i < readings; ++i)
      EXPECT_NEAR(push.at(i), bias[0] + fitted.at(i), 2e-3) << "reading " << i;
  }
  const Answer again = answer(folder, "--models hertz,power --jobs 1");
  EXPECT_EQ(again.table, got.table);
}

TEST(modulus, what_has_none_is_listed_and_shown_first) {
  const Folder folder;
  folder.write("manifest.toml", kManifest), folder.write("a.csv", press(1e4)),
      folder.write("b.csv", "t,d,F\n0,0,0\n0,x,1\n");
  const Answer got = answer(folder);
  EXPECT_EQ(got.outcome.status, 3) << got.outcome.err;
  EXPECT_NE(got.outcome.err.find("`x` is not a number"), std::string::npos) << got.outcome.err;
  if (!got.pictures.is_null()) {
    EXPECT_EQ(got.pictures.at("file"), (nlohmann::json{"b.csv", "a.csv"}));
    EXPECT_EQ(got.pictures.at("grade")[0], 3);
    EXPECT_EQ(got.pictures.at("readings")[0], 0);
  }
  EXPECT_EQ(field(got.table, "stiff", 16), "refused");
  // Readings of a paraboloid: a ball is none so deep, and what its model leaves says so.
  EXPECT_EQ(field(got.table, "soft", 5), "sphere") << got.table;
  EXPECT_NE(got.table.find("what the model leaves goes with depth"), std::string::npos)
      << got.table;
}

std::string with(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

// Once a ball pressed 400 radii deep was "fair".
TEST(modulus, a_ball_that_went_in_by_many_radii_is_poor) {
  const Folder folder;
  folder.write("a.csv", press(1e4)), folder.write("b.csv", press(2e4));
  folder.write("manifest.toml", with(kManifest, "5 mm", "10 um"));
  const Answer got = answer(folder);
  EXPECT_EQ(field(got.table, "soft", 16), "poor") << got.table;
  EXPECT_NE(got.table.find("of its radii: is `probe` right?"), std::string::npos) << got.table;
}

// Once mN taken for N were 10 MPa and mm taken for um 300 MPa, both "good"; `import` refused them.
TEST(modulus, a_unit_that_is_wrong_by_a_prefix_is_refused_as_import_refuses_it) {
  struct Slip {
    const char *from, *to, *remedy;
  };
  const Folder folder;
  folder.write("a.csv", press(1e4)), folder.write("b.csv", press(2e4));
  for (const Slip& slip : {Slip{"force = \"N\"", "force = \"kN\"", "units.force"},
                           Slip{"position = \"mm\"", "position = \"um\"", "units.position"}}) {
    folder.write("manifest.toml", with(kManifest, slip.from, slip.to));
    const Answer got = answer(folder);
    EXPECT_EQ(got.outcome.status, 1) << got.outcome.err;
    EXPECT_EQ(field(got.table, "soft", 16), "refused") << got.table;
    EXPECT_EQ(field(got.table, "stiff", 16), "refused") << got.table;
    const Outcome import = palpate(folder, "import " + (folder / "manifest.toml").string() +
                                               " -o " + (folder / "s.h5").string());
    EXPECT_EQ(import.status, 1) << import.err;
    for (const std::string& err : {got.outcome.err, import.err}) {
      EXPECT_NE(err.find("which no soft body is made of: is a unit wrong?"), std::string::npos)
          << err;
      EXPECT_NE(err.find(std::string(slip.remedy) + " should probably be"), std::string::npos)
          << err;
    }
    folder.write("manifest.toml", with(with(kManifest, slip.from, slip.to), "[defaults]\n",
                                       "[defaults]\nplausible = [\"1 Pa\", \"1000 GPa\"]\n"));
    EXPECT_EQ(answer(folder).outcome.status, 0) << "where the manifest says that it is right";
  }
}

TEST(modulus, a_curve_that_no_model_describes_is_poor_and_a_tip_without_angle_is_asked_for) {
  const Folder folder;
  folder.write("manifest.toml", kManifest), folder.write("a.csv", press(1e4, true)),
      folder.write("b.csv", press(1e4));
  const Answer odd = answer(folder);
  EXPECT_EQ(field(odd.table, "soft", 16), "poor") << odd.table;
  EXPECT_NE(odd.table.find("the tip's models have 1.5"), std::string::npos) << odd.table;
  std::string text = kManifest;
  folder.write("manifest.toml", text.replace(text.find("\"sphere\""), 8, "\"cone\""));
  const Answer cone = answer(folder);
  EXPECT_EQ(cone.outcome.status, 1) << cone.outcome.err;
  EXPECT_NE(cone.outcome.err.find("no model speaks of a tip without half_angle"), std::string::npos)
      << cone.outcome.err;
}

TEST(modulus, of_the_nanoindenter_is_the_instruments_by_its_model) {
  PALPATE_NEEDS_DATA("data/indentation");
  const Folder folder;
  folder.write(
      "manifest.toml",
      "[[recording]]\nfile = \"" +
          fs::canonical(palpate::testing_support::shared_data("data/indentation")).string() +
          "/fmt-chiaro*.txt\"\npoint = \"gel\"\n");
  const Answer got = answer(folder);
  ASSERT_EQ(got.outcome.status, 0) << got.outcome.err;
  const std::size_t hertz = got.models.find(",hertz,");
  EXPECT_NEAR(std::stod(got.models.substr(hertz + 7)), 117.007, 0.5);
  // 12 um into a ball of 27: the paraboloid is 6 % softer than the ball.
  EXPECT_NEAR(std::stod(field(got.table, "gel", 6)), 124.1, 0.5);
}

}  // namespace
}  // namespace palpate::tools
