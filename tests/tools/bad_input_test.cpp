// Bad input: a clear error with its place and remedy, exit status 1, and nothing written.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include <ostream>

#include "tests/tools/command_line.hpp"

namespace palpate::tools {
namespace {

using namespace testing_support;

const std::string kBody = R"([body]
surface = "body.off"
length_unit = "mm"
fixed = [ { below = { axis = "z", at = "1 mm" } } ]
)";
const std::string kMaterial = R"([material]
young = "5 kPa"
poisson = 0.45
)";
const std::string kRest = R"([probe]
radius = "5 mm"
[experiments]
test_points = 4
region = { above = { axis = "z", at = "30 mm" } }
depth = "4 mm"
)";

struct BadInput {
  const char* name;
  std::string scene, mesh;
  std::vector<std::string> expected;  ///< pieces of the message, the remedy among them
};

void PrintTo(const BadInput& input, std::ostream* out) { *out << input.name; }

std::vector<BadInput> bad_inputs() {
  const std::string block = box_off(100, 100, 40), good = kBody + kMaterial + kRest;
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    const auto at = text.find(from);
    return text.replace(at, from.size(), to);
  };
  const std::string sheet = "OFF\n4 2 0\n0 0 0\n100 0 0\n100 100 0\n0 100 0\n3 0 1 2\n3 0 2 3\n";
  return {
      {"unreadable_mesh", with("body.off", "missing.off"), block, {"missing.off"}},
      {"empty_mesh", good, "", {"body.off"}},
      {"mesh_without_triangles", good, "OFF\n0 0 0\n", {"body.off"}},
      {"mesh_of_garbage",
       good,
       "OFF\n8 12 0\nnot numbers\n",
       {"body.off:2", "announces 8 vertices"}},
      {"surface_open_beyond_mending", good, sheet, {"body.off"}},
      {"no_fixed_region",
       with("fixed = [ { below = { axis = \"z\", at = \"1 mm\" } } ]\n", ""),
       block,
       {"scene.toml: [body]: nothing is fixed", "Add fixed = "}},
      {"fixed_region_beside_the_body",
       with("at = \"1 mm\"", "at = \"-100 mm\""),
       block,
       {"[body]: fixed holds 0 of", "The body spans"}},
      {"unknown_key",
       with("depth =", "detph ="),
       block,
       {"scene.toml:13:1", "no key \"detph\"", "Did you mean \"depth\"?"}},
      {"wrong_unit", with("\"5 kPa\"", "\"5 mm\""), block, {"scene.toml:6:9", "is not a pressure"}},
      {"negative_stiffness",
       with("\"5 kPa\"", "\"-5 kPa\""),
       block,
       {"scene.toml:6:9", "young of [material]"}},
      {"incompressible", with("0.45", "0.5"), block, {"scene.toml:7:11", "below 0.5"}},
      {"unknown_law",
       with("young", "law = \"jelly\"\nyoung"),
       block,
       {"scene.toml:6:7", "jelly", "neo-hookean"}},
      {"unknown_probe",
       with("radius = \"5 mm\"", "shape = \"spheer\""),
       block,
       {"spheer", "sphere"}},
      {"probe_larger_than_the_body",
       with("radius = \"5 mm\"", "radius = \"400 mm\""),
       block,
       {"probe", "larger"}},
      {"depth_beyond_the_body",
       with("depth = \"4 mm\"", "depth = \"60 mm\""),
       block,
       {"depth", "thick"}},
      {"region_off_the_surface",
       with("at = \"30 mm\"", "at = \"130 mm\""),
       block,
       {"scene.toml: [experiments] region: 0 of 8"}},
  };
}

class BadInputTest : public testing::TestWithParam<BadInput> {};

INSTANTIATE_TEST_SUITE_P(Every, BadInputTest, testing::ValuesIn(bad_inputs()),
                         [](const auto& tested) { return std::string(tested.param.name); });

TEST_P(BadInputTest, is_refused_with_place_and_remedy_and_nothing_is_written) {
  const Folder folder;
  const auto scene = folder.write("scene.toml", GetParam().scene);
  folder.write("body.off", GetParam().mesh);
  const Outcome outcome =
      palpate(folder, "run " + scene.string() + " -o " + (folder / "out").string());
  EXPECT_EQ(outcome.status, 1) << outcome.err;
  EXPECT_NE(outcome.err.find("palpate: error: "), std::string::npos) << outcome.err;
  for (const std::string& piece : GetParam().expected)
    EXPECT_NE(outcome.err.find(piece), std::string::npos) << "no \"" << piece << "\" in\n"
                                                          << outcome.err;
  const auto at = outcome.err.find("palpate: error: ");
  EXPECT_NE(outcome.err.find("\n  ", at), std::string::npos) << "no remedy in\n" << outcome.err;
  EXPECT_FALSE(fs::exists(folder / "out")) << "something was written";
}

TEST(usage, wrong_usage_has_status_2_and_help_0) {
  const Folder folder;
  EXPECT_EQ(palpate(folder, "").status, 2);
  EXPECT_EQ(palpate(folder, "fly").status, 2);
  EXPECT_EQ(palpate(folder, "run").status, 2);
  EXPECT_EQ(palpate(folder, "run a.toml -o x --fast").status, 2);
  EXPECT_EQ(palpate(folder, "--help").status, 0);
  EXPECT_EQ(palpate(folder, "simulate --help").status, 0);
  EXPECT_EQ(palpate(folder, "--version").out, "palpate 0.2.0\n");
  EXPECT_EQ(palpate(folder, "-V").out, "palpate 0.2.0\n");
}

TEST(usage, wrong_usage_is_an_object_with_json) {
  const Folder folder;
  for (const auto& [line, command] : {std::pair{"fly --json", ""},
                                      {"run a.toml -o x --fast --json", "run"},
                                      {"run --json", "run"}}) {
    SCOPED_TRACE(line);
    const Outcome outcome = palpate(folder, line);
    EXPECT_EQ(outcome.status, 2);
    const auto json = nlohmann::json::parse(outcome.out, nullptr, false);
    ASSERT_TRUE(json.is_object()) << outcome.out;
    EXPECT_EQ(json.at("command"), command);
    EXPECT_NE(outcome.err.find(json.at("errors").at(0).at("what")), std::string::npos);
  }
}

TEST(usage, help_lists_commands_by_group_with_an_example_each) {
  const Folder folder;
  const std::string list = palpate(folder, "--help").out;
  std::size_t at = 0;
  for (const char* group :
       {"Start:", "Stages of a run:", "Recordings:", "Assets and files:", "Studies:"}) {
    const std::size_t found = list.find(group);
    EXPECT_GT(found, at) << group;
    at = found;
  }
  EXPECT_NE(list.find("palpate help COMMAND"), std::string::npos);
  EXPECT_NE(palpate(folder, "help new").out.find("Example:\n  palpate new organ.stl"),
            std::string::npos);
}

TEST(usage, help_of_a_command_is_asked_for_either_way) {
  const Folder folder;
  for (const std::string command : {"", "fit", "study"}) {
    const Outcome asked = palpate(folder, "help " + command);
    EXPECT_EQ(asked.status, 0) << asked.err;
    EXPECT_EQ(asked.out, palpate(folder, command + " --help").out);
  }
  const Outcome misspelt = palpate(folder, "help simulat");
  EXPECT_EQ(misspelt.status, 2);
  EXPECT_NE(misspelt.err.find("Did you mean \"simulate\"?"), std::string::npos) << misspelt.err;
}

TEST(usage, a_missing_file_is_bad_input) {
  const Folder folder;
  for (const char* line : {"run none.toml -o out", "fit none.h5 -o c.h5", "inspect none.h5",
                           "tabulate none.h5 -o t.csv", "replay none.palp none.csv -o f.csv"}) {
    const Outcome outcome = palpate(folder, line);
    EXPECT_EQ(outcome.status, 1) << line;
    EXPECT_NE(outcome.err.find("palpate: error: none."), std::string::npos) << outcome.err;
  }
}

}  // namespace
}  // namespace palpate::tools
