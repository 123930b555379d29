// `palpate import` as a user runs it.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "tests/tools/block_scene.hpp"

namespace palpate::tools {
namespace {

using namespace testing_support;

const std::string kManifest = "[defaults]\n" + kPressKeys + R"(normal = [0, 0, -1]
probe = { shape = "flat", radius = "10 mm" }
[[recording]]
file = "a.csv"
point = "a"
position = [0, 0, 40]
[[recording]]
file = "b.csv"
point = "b"
position = [10, 0, 40]
)";

// Two presses, at a and b.
struct Imported : Folder {
  Imported() {
    write("manifest.toml", kManifest);
    write("a.csv", press_csv(1000)), write("b.csv", press_csv(2000));
  }
  Outcome import(const std::string& more = "") const {
    return palpate(*this, "import manifest.toml -o samples.h5 " + more);
  }
};

TEST(import, a_fit_frees_contact_points_and_tabulates_errors_of_curves) {
  const Imported folder;
  ASSERT_EQ(folder.import().status, 0);
  const std::string fit = "fit samples.h5 -o curves.h5";
  const Outcome wrong = palpate(folder, fit + " --free contact,slope");
  EXPECT_EQ(wrong.status, 1);
  EXPECT_TRUE(holds(wrong.err, "--free: there is nothing called \"slope\" to free"));
  const Outcome freed = palpate(folder, fit + " --free contact,bias --degree 2");
  EXPECT_TRUE(holds(freed.err, "pieces of degree 2 to"));
  EXPECT_TRUE(holds(freed.err, "experiment 1: contact "));
  const Outcome table = palpate(folder, "tabulate --band --steps 3 curves.h5 -o T.csv");
  EXPECT_EQ(table.status, 0) << table.err;
  const std::string text = content_of(folder / "T.csv");
  EXPECT_EQ(text.substr(0, text.find('\n')), "point,name,curve,at_m,value_N,slope_N_m,deviation_N");
  EXPECT_TRUE(holds(text, "\n1,b,normal,"));
  EXPECT_FALSE(holds(text, "lateral"));  // presses say nothing of it
  EXPECT_EQ(std::ranges::count(text, '\n'), 1 + 2 * 4) << text;
}

TEST(import, recordings_become_samples_that_can_be_fitted) {
  const Imported folder;
  const Outcome outcome = folder.import("--json");
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const auto json = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(json.at("imported"), 2);
  EXPECT_EQ(json.at("failed"), 0);
  const Outcome fit = palpate(folder, "fit samples.h5 -o curves.h5");
  EXPECT_EQ(fit.status, 0) << fit.err;  // what presses do not tell is assumed, not a failure
  EXPECT_TRUE(holds(fit.err, "2 good, 0 poor, 0 underdetermined"));
  EXPECT_TRUE(holds(fit.err, "assumed: no point was dragged: there"));
  EXPECT_TRUE(fs::exists(folder / "curves.h5"));
}

TEST(import, a_bad_recording_is_listed_with_status_3_and_the_rest_is_there) {
  const Imported folder;
  folder.write("b.csv", "t,d,F\n0,0,0\n0,1,1\n0,x,2\n");
  const Outcome outcome = folder.import();
  EXPECT_EQ(outcome.status, 3) << outcome.err;
  EXPECT_TRUE(holds(outcome.err, "b.csv:4: column `d`: `x` is not a number"));
  EXPECT_TRUE(fs::exists(folder / "samples.h5"));
  EXPECT_TRUE(holds(content_of(folder / "samples.import.csv"), "b.csv,4,\"\",b,refused"));
  EXPECT_EQ(nlohmann::json::parse(content_of(folder / "samples.import.json")).at("failed"), 1);
}

TEST(import, without_any_good_recording_the_old_file_stays) {
  const Imported folder;
  ASSERT_EQ(folder.import().status, 0);
  const std::string before = content_of(folder / "samples.h5");
  folder.write("a.csv", ""), fs::remove(folder / "b.csv");
  const Outcome outcome = folder.import();
  EXPECT_EQ(outcome.status, 1);
  EXPECT_TRUE(holds(outcome.err, "a.csv:1: is empty"));
  EXPECT_TRUE(holds(outcome.err, "b.csv: no such file"));
  EXPECT_TRUE(content_of(folder / "samples.h5") == before);
}

TEST(import, a_pattern_is_found_beside_a_manifest_that_is_named_without_its_folder) {
  const Imported folder;
  const std::string first = kManifest.substr(0, kManifest.rfind("[[recording]]"));
  folder.write("manifest.toml", replaced(first, "a.csv", "a*.csv"));
  const Outcome outcome = folder.import();
  EXPECT_EQ(outcome.status, 0) << outcome.err;
}

TEST(import, a_contact_point_may_be_told) {
  const Imported folder;
  const auto contacts = [&](const std::string& value) {
    folder.write("manifest.toml", replaced(kManifest, "[[rec", "contact = " + value + "\n[[rec"));
    const Outcome outcome = folder.import();
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    std::vector<double> found;
    const auto rows = nlohmann::json::parse(content_of(folder / "samples.import.json"));
    for (const auto& row : rows.at("recordings")) found.push_back(row.at("contact_m"));
    return found;
  };
  EXPECT_EQ(contacts("\"0.5 mm\""), (std::vector<double>{0.5e-3, 0.5e-3}));
  EXPECT_EQ(contacts("0.0005"), (std::vector<double>{0.5e-3, 0.5e-3}));
}

TEST(import, mistakes_in_the_manifest_name_line_and_column) {
  const Imported folder;
  const auto error_of = [&](const std::string& from, const std::string& to) {
    folder.write("manifest.toml", replaced(kManifest, from, to));
    const Outcome outcome = folder.import();
    EXPECT_EQ(outcome.status, 1);
    return outcome.err;
  };
  EXPECT_TRUE(
      holds(error_of("point = \"a\"", "pont = \"a\""),
            "manifest.toml:9:1: [[recording]] has no key \"pont\"\n  Did you mean \"point\"?"));
  EXPECT_TRUE(holds(error_of("force = \"N\"", "force = \"mm\""), "which is no unit of force"));
  EXPECT_TRUE(holds(error_of("force_on = \"body\"\n", ""), "force_on is missing"));
  EXPECT_TRUE(holds(error_of("\"a.csv\"", "\"*.dat\""), "no file matches \"*.dat\""));
  EXPECT_TRUE(holds(error_of("[0, 0, 40]", "[0, 0]"), "is not a list of 3 numbers"));
  EXPECT_TRUE(holds(error_of("\"flat\"", "\"flta\""), "Did you mean \"flat\"?"));
  EXPECT_TRUE(holds(error_of("[defaults]", "[defaults"), "manifest.toml:1:"));
}

}  // namespace
}  // namespace palpate::tools
