// From the folder of a rig to an asset and its error statement, as a user runs it.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "tests/tools/command_line.hpp"

namespace palpate::tools {
namespace {

using namespace testing_support;
using Json = nlohmann::json;

// A robot's file: a ball pressed 2.5 mm into a bump at 7 x 7 places, stiffer to one side; normals
// outward, forces on the tool, no unit in the header, and one probe that failed. off_mm: what is
// written as its position lies so far out of the body.
std::string robot_file(double off_mm = 0) {
  std::string text;
  for (const char* name : {"contact", "normal", "force", "desired", "current"})
    for (const char axis : {'x', 'y', 'z'})
      text += std::string(name) + "_" + axis +
              (name[0] == 'c' && name[1] == 'u' && axis == 'z' ? "\n" : ",");
  const auto row = [&](const double(&c)[3], const double(&n)[3], double force_N, double depth_mm) {
    char line[512];
    const auto at = [&](int k) { return c[k] + (off_mm - depth_mm) * n[k]; };
    std::snprintf(line, sizeof line,
                  "%.6f,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f\n",
                  c[0] + off_mm * n[0], c[1] + off_mm * n[1], c[2] + off_mm * n[2], n[0], n[1],
                  n[2], force_N * n[0], force_N * n[1], force_N * n[2], at(0), at(1), at(2), at(0),
                  at(1), at(2));
    text += line;
  };
  for (int k = 0; k < 49; ++k) {
    const double x = 5.0 * (k % 7) - 15, y = 5.0 * (k / 7) - 15;
    const double c[3] = {x, y, 20 - 0.01 * (x * x + y * y)};
    const double length = std::hypot(0.02 * x, 0.02 * y, 1.0);
    const double n[3] = {0.02 * x / length, 0.02 * y / length, 1 / length};
    for (int i = 0; i < 40; ++i) {
      const double depth_mm = -1.0 + 3.5 * i / 39, in_mm = std::max(0.0, depth_mm);
      row(c, n, (0.3 + 0.004 * x) * in_mm * std::sqrt(in_mm) + 1e-4 * (i % 3), depth_mm);
    }
  }
  const double c[3] = {100, 100, 0}, none[3] = {0, 0, 0};
  row(c, none, 0, 0);
  return text;
}

// The bump of robot_file, in mm.
std::string bump_off() {
  return sheet_off(20, [](std::ostream& out, int i, int j) {
    const double x = 2.0 * i - 20, y = 2.0 * j - 20;
    out << x << ' ' << y << ' ' << 20 - 0.01 * (x * x + y * y);
  });
}

class RecordingsRun : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    shared = std::make_unique<Folder>();
    fs::create_directory(*shared / "rig");
    shared->write("rig/probes.csv", robot_file());
    proposed = palpate(*shared, "new --recordings rig -o manifest.toml");
    ran = palpate(*shared, "run manifest.toml -o out");
  }
  static void TearDownTestSuite() { shared.reset(); }
  static Json statement() { return Json::parse(content_of(*shared / "out/statement.json")); }

  static std::unique_ptr<Folder> shared;
  static Outcome proposed, ran;
};
std::unique_ptr<Folder> RecordingsRun::shared;
Outcome RecordingsRun::proposed, RecordingsRun::ran;

TEST_F(RecordingsRun, new_finds_format_signs_and_guesses_units_aloud) {
  ASSERT_EQ(proposed.status, 0) << proposed.err;
  const std::string text = content_of(*shared / "manifest.toml");
  for (const char* line : {"format = \"robot-palpation\"", "position = \"mm\", force = \"N\"",
                           "force_on = \"tool\"", "normals = \"outward\""})
    EXPECT_TRUE(holds(text, line));
  EXPECT_TRUE(holds(proposed.err, "units mm and N, which no header says"));
}

// Positions of a ball's centre: 4 mm off the body's surface, and off that of the contacts.
TEST(BallCentres, are_proposed_beside_a_mesh_and_become_places_of_contact) {
  const Folder folder;
  for (const double off_mm : {0.0, 4.0}) {
    const std::string name = off_mm > 0 ? "center" : "contact";
    fs::create_directory(folder / name);
    folder.write(name + "/probes.csv", robot_file(off_mm));
    folder.write(name + "/body.off", bump_off());
    const std::string manifest = name + ".toml";
    const Outcome proposed = palpate(folder, "new --recordings " + name + " -o " + manifest);
    ASSERT_EQ(proposed.status, 0) << proposed.err;
    const std::string text = content_of(folder / manifest);
    const bool is_proposed = text.find(
                                 "\npositions = \"center\"\nprobe = { shape = \"sphere\", "
                                 "radius = \"4 mm\" }") != std::string::npos;
    EXPECT_EQ(is_proposed, off_mm > 0) << text;
    EXPECT_EQ(proposed.err.find("touched 4 mm off the surface") != std::string::npos, off_mm > 0)
        << proposed.err;
    EXPECT_EQ(text.find("# positions = \"center\"") != std::string::npos, off_mm == 0) << text;
    const Outcome checked = palpate(folder, "check " + manifest);
    EXPECT_EQ(checked.status, 3) << checked.err;  // a probe failed
    EXPECT_TRUE(holds(checked.err, "49 recordings lie 0.0"));
  }
  // Without a mesh the surface of the contacts is the body's, not that of the centres.
  std::string text = content_of(folder / "center.toml");
  folder.write("alone.toml", text.substr(text.find("[[recording]]")));
  ASSERT_EQ(palpate(folder, "import alone.toml -o alone.h5").status, 3);
  ASSERT_EQ(palpate(folder, "surface alone.h5 -o b.obj").status, 0);
  std::istringstream lines(content_of(folder / "b.obj"));
  double worst_mm = 0;
  int vertices = 0;
  for (std::string line; std::getline(lines, line);) {
    double x = 0, y = 0, z = 0;
    if (std::sscanf(line.c_str(), "v %lf %lf %lf", &x, &y, &z) != 3 ||
        std::max(std::abs(x), std::abs(y)) > 15)  // no contact lies beyond
      continue;
    worst_mm = std::max(worst_mm, std::abs(z - 20 + 0.01 * (x * x + y * y)));
    ++vertices;
  }
  EXPECT_GE(vertices, 49);
  EXPECT_LT(worst_mm, 0.3);
}

// A controller holds the force for 20 s while a ball sinks; one place makes no surface.
TEST(Check, says_that_one_place_makes_no_surface) {
  const Folder folder;
  std::string table = "t_s,d_mm,F_N\n";
  for (int i = 0; i <= 1200; ++i) {
    const double t = 0.02 * i, in_mm = std::max(0.0, std::min(t, 3.0) - 1);
    const double sunk = t > 3 ? 0.3 * (1 - std::exp(-(t - 3) / 4)) : 0;
    table += fmt::format("{},{:.5f},{:.6f}\n", t, std::min(t, 1.0) + in_mm * (1 + sunk),
                         0.1 * in_mm * std::sqrt(in_mm) + 5e-4 * (i * 7 % 5 - 2));
  }
  folder.write("a.csv", table);
  folder.write(
      "m.toml",
      "[[recording]]\nfile = \"a.csv\"\nforce_on = \"body\"\nprobe = { radius = \"5 mm\" }\n"
      "position = [\"0 mm\", \"0 mm\", \"0 mm\"]\nnormal = [0, 0, -1]\n");
  const Outcome checked = palpate(folder, "check m.toml");
  EXPECT_EQ(checked.status, 0) << checked.err;
  EXPECT_TRUE(holds(checked.out, "a.csv: csv, press, "));
  EXPECT_TRUE(holds(checked.err, "1 place is too few for a surface"));
}

TEST_F(RecordingsRun, check_says_what_each_recording_is_and_what_is_wrong) {
  const Outcome checked = palpate(*shared, "check manifest.toml");
  EXPECT_EQ(checked.status, 3);  // a probe failed
  EXPECT_TRUE(holds(checked.err, "the surface normal has no direction"));
  EXPECT_TRUE(holds(checked.out, "rig/probes.csv#contact1: robot-palpation, press, "));
  EXPECT_TRUE(holds(checked.out, "49 points, 9 of them held out"));
}

TEST_F(RecordingsRun, ends_with_an_asset_and_a_statement_of_what_was_held_out) {
  ASSERT_EQ(ran.status, 3) << ran.err;  // a probe failed
  const Json s = statement();
  EXPECT_EQ(s["reference"], "recorded");
  EXPECT_EQ(s["probes"].get<int>() + s["beyond"].get<int>(), 9);
  EXPECT_GT(s["rows"], 100);
  // The field is linear along x: interpolation is far better than the nearest press.
  const double own = s["force_error"]["p95_rel"],
               nearest = s["baselines"]["nearest_point"]["p95_rel"];
  EXPECT_LT(own, 0.07);
  EXPECT_LT(2 * own, nearest);
  EXPECT_TRUE(s["baselines"].contains("inverse_distance"));
  EXPECT_LT(s["left_out"]["interpolated"]["p95_rel"].get<double>(),
            s["left_out"]["nearest_point"]["p95_rel"].get<double>());
  EXPECT_LT(s["fitted"]["fitted"]["p95_rel"], own + 0.02);
  EXPECT_TRUE(holds(ran.said(), "held-out recorded points"));
  EXPECT_TRUE(holds(content_of(*shared / "out/asset.palp"), "\"reference\":\"recorded\""));
}

TEST_F(RecordingsRun, is_done_once) {
  const Outcome again = palpate(*shared, "run manifest.toml -o out");
  EXPECT_EQ(again.status, 3);
  EXPECT_TRUE(holds(again.said(), "nothing to do"));
}

TEST_F(RecordingsRun, validate_states_what_run_stated) {
  const Outcome stated = palpate(
      *shared,
      "validate out/asset.palp out/samples.h5 --curves out/curves.h5 --body out/body.h5 --json");
  ASSERT_EQ(stated.status, 0) << stated.err;
  const Json told = Json::parse(stated.out), own = statement();
  for (const char* part : {"force_error", "baselines", "left_out", "fitted", "verdict"}) {
    Json a = told[part], b = own[part];
    EXPECT_EQ(a, b) << part;
  }
}

TEST_F(RecordingsRun, points_are_held_out_by_name) {
  std::string text = content_of(*shared / "manifest.toml");
  text += "\n[validate]\nhold_out = [\"*#contact2*\"]\n";
  shared->write("named.toml", text);
  const Outcome imported = palpate(*shared, "import named.toml -o named.h5");
  EXPECT_EQ(imported.status, 3) << imported.err;
  EXPECT_TRUE(holds(imported.err, "at 11 points, held out of the fit"));
  shared->write("typo.toml", replaced(text, "#contact2*", "#contakt2*"));
  const Outcome refused = palpate(*shared, "import typo.toml -o typo.h5");
  EXPECT_EQ(refused.status, 1);
  EXPECT_TRUE(holds(refused.err, "hold_out names \"*#contakt2*\", and no point is so called"));
}

TEST_F(RecordingsRun, surface_passes_through_the_contacts_and_says_how_far_others_lie_off) {
  const Outcome made = palpate(*shared, "surface out/samples.h5 -o s.obj --json");
  ASSERT_EQ(made.status, 0) << made.err;
  const Json json = Json::parse(made.out);
  EXPECT_EQ(json["contacts"], 40);
  EXPECT_EQ(json["is_height_field"], true);
  EXPECT_LT(json["left_out"]["median_m"], 1e-4);
  EXPECT_EQ(content_of(*shared / "s.obj").rfind("# palpate surface, length_unit = \"mm\"", 0), 0u);
}

TEST_F(RecordingsRun, a_folder_without_a_recording_is_refused) {
  fs::create_directory(*shared / "empty");
  shared->write("empty/notes.txt", "pressed on Monday\n");
  const Outcome refused = palpate(*shared, "new --recordings empty -o none.toml");
  EXPECT_EQ(refused.status, 1);
  EXPECT_TRUE(holds(refused.err, "holds no file that a recording could be read from"));
  EXPECT_FALSE(fs::exists(*shared / "none.toml"));
}

// Lines to and fro over a plane of 300 N/m and friction 0.3, from `first_mm` on, with a sine of
// depth; before and behind them the tool is in the air.
std::string scan_file(double first_mm, double deepest_mm, double bias_N, int rows_in_air) {
  std::string text = "t_s,x_mm,y_mm,z_mm,fx_N,fy_N,fz_N\n";
  for (int row = -rows_in_air; row < 1200 + rows_in_air; ++row) {
    const int line = std::clamp(row / 100, 0, 11), i = std::clamp(row - 100 * line, 0, 99);
    const double heading = line % 2 == 0 ? 1 : -1, x = 10 + heading * (0.2 * i - 10),
                 depth_mm = row < 0 || row >= 1200
                                ? -4
                                : 0.55 * deepest_mm - 0.45 * deepest_mm * std::cos(0.19 * row),
                 push_N = 0.3 * std::max(0.0, depth_mm), noise_N = 2e-3 * (row * row % 7 - 3);
    text += fmt::format("{:.5f},{:.4f},{:.4f},{:.4f},{:.5f},{:.5f},{:.5f}\n", 1 + row / 66.0, x,
                        first_mm + 1.5 * line, -depth_mm, -0.3 * heading * push_N + bias_N, noise_N,
                        push_N + noise_N);
  }
  return text;
}

// A press into that plane at a place, from 3 mm above it to 5 mm, with a bias of its own.
std::string press_file(double x_mm, double y_mm, double bias_N) {
  std::string text = "t_s,x_mm,y_mm,z_mm,fx_N,fy_N,fz_N\n";
  for (int row = 0; row < 160; ++row) {
    const double depth_mm = 5 - 0.1 * std::abs(row - 80.0), noise_N = 2e-3 * (row * row % 7 - 3);
    text += fmt::format("{:.5f},{:.4f},{:.4f},{:.4f},{:.5f},{:.5f},{:.5f}\n", row / 66.0, x_mm,
                        y_mm, -depth_mm, noise_N, bias_N, 0.3 * std::max(0.0, depth_mm) + noise_N);
  }
  return text;
}

// Three lines at 2 N: a path of less than four diagonals of its region.
TEST(New, proposes_a_scan_of_few_lines) {
  const Folder folder;
  std::string text = "t_s,x_mm,y_mm,z_mm,fx_N,fy_N,fz_N\n";
  for (int i = 0; i < 450; ++i)
    text += fmt::format("{},{},{},{},{},0,2\n", i / 60.0, 0.2 * std::abs((i + 150) % 300 - 150),
                        0.02 * i, 1e-3 * (i * i % 7), i / 150 % 2 == 0 ? 0.6 : -0.6);
  fs::create_directory(folder / "rig");
  folder.write("rig/a.csv", text);
  const Outcome proposed = palpate(folder, "new --recordings rig -o m.toml");
  ASSERT_EQ(proposed.status, 0) << proposed.err;
  EXPECT_TRUE(holds(content_of(folder / "m.toml"), "kind = \"scan\""));
}

// Presses deeper than a scan make curves together with it, and later ones are corrected as it is.
TEST(Run, makes_one_asset_of_a_scan_and_presses) {
  const Folder folder;
  folder.write("scan.csv", scan_file(0, 3, 0.1, 20));
  for (int k = 0; k < 6; ++k)
    folder.write(fmt::format("{}_{}.csv", k < 4 ? "press" : "later", k),
                 press_file(6 + 4 * (k % 3), 5 + 5 * (k / 3), 0.02 * k));
  const std::string presses = "[[recording]]\nforce_on = \"tool\"\nfile = ";
  folder.write("both.toml", "[validate]\nhold_out = [\"press_1\", \"scan#4\", \"scan#9\"]\n" +
                                presses + "\"scan.csv\"\nkind = \"scan\"\n" + presses +
                                "\"press_*.csv\"\n");
  folder.write("later.toml", presses + "\"later_*.csv\"\n");
  const Outcome ran = palpate(folder, "run both.toml -o out");
  ASSERT_EQ(ran.status, 0) << ran.err;
  const Json kinds = Json::parse(content_of(folder / "out/statement.json"))["by_kind"];
  for (const char* kind : {"press", "scan"}) {
    EXPECT_LT(kinds[kind]["p95_rel"].get<double>(), 0.15) << kind << ran.err;
    EXPECT_GT(kinds[kind]["rows"], 40) << kind;
  }
  const Outcome later = palpate(folder, "validate out/asset.palp later.toml --json");
  ASSERT_EQ(later.status, 0) << later.err;
  EXPECT_LT(Json::parse(later.out)["force_error"]["p95_rel"].get<double>(), 0.15) << later.err;
  folder.write("both.toml",
               "relaxation = \"apply\"\n" + presses + "\"scan.csv\"\nkind = \"scan\"\n");
  EXPECT_TRUE(holds(palpate(folder, "check both.toml").err, "relaxation does nothing for a scan"));
}

// A second recording, with a bias of its own, goes deeper and beyond the edge of the first.
TEST(Validate, states_a_scan_that_was_recorded_later) {
  const Folder folder;
  for (const char* name : {"first", "second"})
    folder.write(std::string(name) + ".toml",
                 fmt::format("[[recording]]\nfile = \"{}.csv\"\nkind = \"scan\"\n"
                             "force_on = \"tool\"\n[validate]\nhold_out = 0\n",
                             name));
  folder.write("first.csv", scan_file(0, 3, 0, 6));
  folder.write("second.csv", scan_file(7.7, 4, 0.1, 6));
  const Outcome ran = palpate(folder, "run first.toml -o out");
  ASSERT_EQ(ran.status, 0) << ran.err;
  const Outcome stated = palpate(folder, "validate out/asset.palp second.toml --json");
  ASSERT_EQ(stated.status, 0) << stated.err;
  const Json s = Json::parse(stated.out);
  EXPECT_TRUE(holds(stated.err, "scan: bias of the force -0.1, "));
  EXPECT_EQ(s["reference"], "recorded");
  EXPECT_LT(s["by_reach"]["within"]["p95_rel"].get<double>(), 0.2);
  for (const char* beyond : {"deeper", "beyond_edge"})
    EXPECT_GT(s["by_reach"][beyond]["rows"], 20) << beyond;
  EXPECT_TRUE(s["baselines"].contains("nearest_rows"));
  const Outcome refused = palpate(folder, "validate out/asset.palp second.toml --points 3");
  EXPECT_EQ(refused.status, 1);
}

}  // namespace
}  // namespace palpate::tools
