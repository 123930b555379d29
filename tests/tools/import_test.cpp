// `palpate import` as a user runs it.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "tests/tools/command_line.hpp"

namespace palpate::tools {
namespace {

using namespace testing_support;

// A press of F = 1000 N/m beyond 1 mm, 2 mm deep, 100 rows, position in mm.
std::string press(double stiffness_N_m) {
  std::string text = "t,d,F\n";
  for (int i = 0; i < 100; ++i) {
    const double travel_mm = 0.03 * i;
    text += std::to_string(0.01 * i) + "," + std::to_string(travel_mm) + "," +
            std::to_string(stiffness_N_m * 1e-3 * std::max(0.0, travel_mm - 1) + 1e-4 * (i % 3)) +
            "\n";
  }
  return text;
}

const std::string kManifest = R"([defaults]
columns = { time = "t", depth = "d", force = "F" }
units = { time = "s", position = "mm", force = "N" }
force_on = "body"
normal = [0, 0, -1]
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

std::string import_line(const Folder& folder, const std::string& more = "") {
  return "import " + (folder / "manifest.toml").string() + " -o " +
         (folder / "samples.h5").string() + " " + more;
}

TEST(import, a_fit_frees_contact_points_and_tabulates_errors_of_curves) {
  const Folder folder;
  folder.write("manifest.toml", kManifest), folder.write("a.csv", press(1000)),
      folder.write("b.csv", press(2000));
  ASSERT_EQ(palpate(folder, import_line(folder)).status, 0);
  const std::string fit =
      "fit " + (folder / "samples.h5").string() + " -o " + (folder / "curves.h5").string();
  const Outcome wrong = palpate(folder, fit + " --free contact,slope");
  EXPECT_EQ(wrong.status, 1);
  EXPECT_NE(wrong.err.find("--free: there is nothing called \"slope\" to free"), std::string::npos)
      << wrong.err;
  const Outcome freed = palpate(folder, fit + " --free contact,bias --degree 2");
  EXPECT_NE(freed.err.find("pieces of degree 2 to"), std::string::npos) << freed.err;
  EXPECT_NE(freed.err.find("90 % band where its rows end"), std::string::npos) << freed.err;
  EXPECT_NE(freed.err.find("experiment 1: contact "), std::string::npos) << freed.err;
  const Outcome table =
      palpate(folder, "tabulate --band --steps 3 " + (folder / "curves.h5").string() + " -o " +
                          (folder / "T.csv").string());
  EXPECT_EQ(table.status, 0) << table.err;
  const std::string text = content_of(folder / "T.csv");
  EXPECT_EQ(text.substr(0, text.find('\n')), "point,name,curve,at_m,value_N,slope_N_m,deviation_N");
  EXPECT_NE(text.find("\n1,b,normal,"), std::string::npos) << text;
  EXPECT_EQ(text.find("lateral"), std::string::npos);  // presses say nothing of it
  EXPECT_EQ(std::ranges::count(text, '\n'), 1 + 2 * 4) << text;
}

TEST(import, recordings_become_samples_that_can_be_fitted) {
  const Folder folder;
  folder.write("manifest.toml", kManifest), folder.write("a.csv", press(1000)),
      folder.write("b.csv", press(2000));
  const Outcome outcome = palpate(folder, import_line(folder, "--json"));
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const auto json = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(json.at("imported"), 2);
  EXPECT_EQ(json.at("failed"), 0);
  const Outcome fit = palpate(
      folder, "fit " + (folder / "samples.h5").string() + " -o " + (folder / "curves.h5").string());
  EXPECT_EQ(fit.status, 0) << fit.err;  // what presses do not tell is assumed, not a failure
  EXPECT_NE(fit.err.find("2 good, 0 poor, 0 underdetermined"), std::string::npos) << fit.err;
  EXPECT_NE(fit.err.find("assumed: no point was dragged: there"), std::string::npos) << fit.err;
  EXPECT_TRUE(fs::exists(folder / "curves.h5"));
}

TEST(import, a_bad_recording_is_listed_with_status_3_and_the_rest_is_there) {
  const Folder folder;
  folder.write("manifest.toml", kManifest), folder.write("a.csv", press(1000)),
      folder.write("b.csv", "t,d,F\n0,0,0\n0,1,1\n0,x,2\n");
  const Outcome outcome = palpate(folder, import_line(folder));
  EXPECT_EQ(outcome.status, 3) << outcome.err;
  EXPECT_NE(outcome.err.find("b.csv:4: column `d`: `x` is not a number"), std::string::npos)
      << outcome.err;
  EXPECT_TRUE(fs::exists(folder / "samples.h5"));
  EXPECT_NE(content_of(folder / "samples.import.csv").find("b.csv,4,\"\",b,refused"),
            std::string::npos)
      << content_of(folder / "samples.import.csv");
  EXPECT_EQ(nlohmann::json::parse(content_of(folder / "samples.import.json")).at("failed"), 1);
}

TEST(import, without_any_good_recording_the_old_file_stays) {
  const Folder folder;
  folder.write("manifest.toml", kManifest), folder.write("a.csv", press(1000)),
      folder.write("b.csv", press(1000));
  ASSERT_EQ(palpate(folder, import_line(folder)).status, 0);
  const std::string before = content_of(folder / "samples.h5");
  folder.write("a.csv", ""), fs::remove(folder / "b.csv");
  const Outcome outcome = palpate(folder, import_line(folder));
  EXPECT_EQ(outcome.status, 1);
  EXPECT_NE(outcome.err.find("a.csv:1: is empty"), std::string::npos) << outcome.err;
  EXPECT_NE(outcome.err.find("b.csv: no such file"), std::string::npos) << outcome.err;
  EXPECT_TRUE(content_of(folder / "samples.h5") == before);
}

TEST(import, the_same_recordings_give_the_same_bytes) {
  const Folder folder;
  folder.write("manifest.toml", kManifest), folder.write("a.csv", press(1000)),
      folder.write("b.csv", press(2000));
  ASSERT_EQ(palpate(folder, import_line(folder)).status, 0);
  const std::string before = content_of(folder / "samples.h5");
  ASSERT_EQ(palpate(folder, import_line(folder)).status, 0);
  EXPECT_TRUE(content_of(folder / "samples.h5") == before);
}

TEST(import, a_pattern_is_found_beside_a_manifest_that_is_named_without_its_folder) {
  const Folder folder;
  std::string text = kManifest.substr(0, kManifest.rfind("[[recording]]"));
  text.replace(text.find("a.csv"), 5, "a*.csv");
  folder.write("manifest.toml", text), folder.write("a1.csv", press(1000));
  const std::filesystem::path before = std::filesystem::current_path();
  std::filesystem::current_path(folder / ".");
  const Outcome outcome = palpate(folder, "import manifest.toml -o samples.h5");
  std::filesystem::current_path(before);
  EXPECT_EQ(outcome.status, 0) << outcome.err;
}

TEST(import, a_contact_point_may_be_told) {
  const Folder folder;
  const auto contacts = [&](const std::string& value) {
    std::string text = kManifest;
    folder.write("manifest.toml", text.insert(text.find("[[rec"), "contact = " + value + "\n"));
    const Outcome outcome = palpate(folder, import_line(folder));
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    std::vector<double> found;
    const auto rows = nlohmann::json::parse(content_of(folder / "samples.import.json"));
    for (const auto& row : rows.at("recordings")) found.push_back(row.at("contact_m"));
    return found;
  };
  folder.write("a.csv", press(1000)), folder.write("b.csv", press(1300));
  EXPECT_EQ(contacts("\"0.5 mm\""), (std::vector<double>{0.5e-3, 0.5e-3}));
  EXPECT_EQ(contacts("0.0005"), (std::vector<double>{0.5e-3, 0.5e-3}));
}

TEST(import, mistakes_in_the_manifest_name_line_and_column) {
  const Folder folder;
  const auto error_of = [&](const std::string& from, const std::string& to) {
    std::string text = kManifest;
    text.replace(text.find(from), from.size(), to);
    folder.write("manifest.toml", text);
    const Outcome outcome = palpate(folder, import_line(folder));
    EXPECT_EQ(outcome.status, 1);
    return outcome.err;
  };
  EXPECT_NE(
      error_of("point = \"a\"", "pont = \"a\"")
          .find("manifest.toml:9:1: [[recording]] has no key \"pont\"\n  Did you mean \"point\"?"),
      std::string::npos);
  EXPECT_NE(error_of("force = \"N\"", "force = \"mm\"").find("which is no unit of force"),
            std::string::npos);
  EXPECT_NE(error_of("force_on = \"body\"\n", "").find("force_on is missing"), std::string::npos);
  EXPECT_NE(error_of("\"a.csv\"", "\"*.dat\"").find("no file matches \"*.dat\""),
            std::string::npos);
  EXPECT_NE(error_of("[0, 0, 40]", "[0, 0]").find("is not a list of 3 numbers"), std::string::npos);
  EXPECT_NE(error_of("\"flat\"", "\"flta\"").find("Did you mean \"flat\"?"), std::string::npos);
  EXPECT_NE(error_of("[defaults]", "[defaults").find("manifest.toml:1:"), std::string::npos);
}

}  // namespace
}  // namespace palpate::tools
