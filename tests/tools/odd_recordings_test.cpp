// Recordings with the defects that strangers' files had: each is read right, or refused with a
// remedy.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <vector>

#include "tests/tools/odd_presses.hpp"

namespace palpate::tools {
namespace {

using namespace testing_support;
using Json = nlohmann::json;

struct Checked {
  Outcome said;
  Json json;
};

Checked check(const Folder& folder, const std::string& text) {
  folder.write("m.toml", text);
  Checked out{palpate(folder, "check --json m.toml"), {}};
  if (out.said.status == 0) out.json = Json::parse(out.said.out);
  return out;
}

// A log with three axes: at each place down, `times` in and out, up and on to the next, 10 mm away.
std::string log_of_places(int places, int times, double stiff_kPa) {
  std::mt19937 random(kSeed);
  std::normal_distribution<double> noise_N(0, 2e-3), noise_mm(0, 0.01);
  std::string text = "t_s,x_mm,y_mm,z_mm,fx_N,fy_N,fz_N\n";
  double time_s = 0;
  const auto row = [&](double x, double y, double depth_mm, double young_kPa) {
    text += fmt::format("{:.3f},{:.4f},{:.4f},{:.4f},{:.5f},{:.5f},{:.5f}\n", time_s,
                        x + noise_mm(random), y + noise_mm(random), kFree_mm - depth_mm,
                        noise_N(random), noise_N(random),
                        -hertz_N(depth_mm - kFree_mm, young_kPa) + noise_N(random));
    time_s += 0.02;
  };
  for (int k = 0; k < places; ++k) {
    const double x = 10 * (k % 3), y = 10 * (k / 3);
    const double young_kPa = k == 4 ? stiff_kPa : 10;
    for (int i = 0; i <= 200 * times; ++i)
      row(x, y, (kDepth_mm + kFree_mm) * (1 - std::abs(i % 200 - 100) / 100.0), young_kPa);
    const double to_x = 10 * ((k + 1) % 3), to_y = 10 * ((k + 1) / 3);
    for (int i = 1; i < 40 && k + 1 < places; ++i)
      row(x + (to_x - x) * i / 40, y + (to_y - y) * i / 40, 0, 10);
  }
  return text;
}

TEST(OddRecordings, a_log_of_nine_places_is_nine_recordings) {
  const Folder folder;
  folder.write("log.csv", log_of_places(9, 1, 40));
  for (const char* normal : {"normal = [0, 0, -1]", ""}) {
    const Checked nine = check(folder, manifest("log.csv", normal));
    ASSERT_EQ(nine.said.status, 0) << nine.said.err;
    ASSERT_EQ(nine.json.at("recordings").size(), 9u) << normal;
    EXPECT_EQ(nine.json.at("points"), 9);
    for (std::size_t k = 0; k < 9; ++k) {
      const Json& r = nine.json.at("recordings")[k];
      EXPECT_NEAR(r.at("depth_m"), 3e-3, 0.15e-3) << r;
      EXPECT_NEAR(r.at("force_N"), hertz_N(3, k == 4 ? 40 : 10), 0.02) << r;
      EXPECT_TRUE(holds(r.dump(), fmt::format("place {} of 9", k + 1))) << r;
    }
  }
  const Checked placed = check(folder, manifest("log.csv", "", kPlaced));
  EXPECT_NE(placed.said.status, 0);
  EXPECT_TRUE(holds(placed.said.err, "presses at 9 places"));
  EXPECT_TRUE(holds(placed.said.err, "Leave `position` out"));
}

TEST(OddRecordings, presses_that_repeat_at_each_place_stay_together) {
  const Folder folder;
  folder.write("log.csv", log_of_places(2, 3, 10)),
      folder.write("one.csv", log_of_places(1, 3, 10));
  const Checked two = check(folder, manifest("log.csv", "normal = [0, 0, -1]"));
  ASSERT_EQ(two.said.status, 0) << two.said.err;
  EXPECT_EQ(two.json.at("recordings").size(), 2u);
  EXPECT_TRUE(holds(two.json.dump(), "holds 3 presses as deep")) << two.json;
  const Checked one = check(folder, manifest("one.csv", "normal = [0, 0, -1]"));
  ASSERT_EQ(one.said.status, 0) << one.said.err;
  EXPECT_EQ(one.json.at("recordings").size(), 1u);
}

TEST(OddRecordings, a_key_that_a_format_does_not_read_is_refused_where_it_stands) {
  const Folder folder;
  folder.write("a.csv", table("t_s,z_mm,F_N", "{:.2f},{:.5f},{:.6f}"));
  const auto refusal = [&](const std::string& defaults, const std::string& entry) {
    const Checked out = check(folder, manifest("a.csv", defaults, kPlaced + entry));
    EXPECT_NE(out.said.status, 0) << entry;
    return out.said.err;
  };
  ASSERT_EQ(check(folder, manifest("a.csv", "", kPlaced)).said.status, 0);
  const std::string of_entry = refusal("", "normals = \"outward\"");
  EXPECT_TRUE(holds(of_entry, "m.toml:9:11: `normals` does nothing for "));
  EXPECT_TRUE(holds(of_entry, "turn `normal` around"));
  const std::string of_defaults = refusal("normals = \"outward\"", "");
  EXPECT_TRUE(holds(of_defaults,
                    "m.toml:4:11: `normals` does nothing for these recordings, which "
                    "are read as csv"));
  EXPECT_TRUE(holds(refusal("",
                            "columns = { depth = \"z_mm\", force = \"F_N\", normal = [\"a\", "
                            "\"b\", \"c\"] }"),
                    "does nothing for "));
}

// What `check` says of the press of kDepth_mm into 10 kPa.
void expect_press(const Checked& checked) {
  ASSERT_EQ(checked.said.status, 0) << checked.said.err;
  const Json& r = checked.json.at("recordings").at(0);
  EXPECT_NEAR(r.at("depth_m"), 1e-3 * kDepth_mm, 0.1e-3) << r;
  EXPECT_NEAR(r.at("force_N"), hertz_N(kDepth_mm, 10), 0.015) << r;
}

TEST(OddRecordings, hints_are_relative_to_the_unit_of_the_header) {
  const Folder folder;
  folder.write("force.csv", table("t_s,z_mm,F_mN", "{:.2f},{:.5f},{:.1f}", 1, 1e6));
  folder.write("depth.csv", table("t_s,z_um,F_N", "{:.2f},{:.5f},{:.6f}"));
  for (const auto& [file, hint] :
       {std::pair{"force.csv",
                  "The file says mN, and it should probably be \"uN\": correct the "
                  "header, or name `columns` by number and say units.force"},
        {"depth.csv",
         "The file says um, and it should probably be \"mm\": correct the header, or "
         "name `columns` by number and say units.position"}}) {
    const Checked refused = check(folder, manifest(file, "", kPlaced));
    EXPECT_TRUE(holds(refused.said.err, hint));
  }
  expect_press(check(folder, manifest("force.csv", "", kPlaced + std::string(R"(
columns = { time = 1, depth = 2, force = 3 }
units = { time = "s", position = "mm", force = "uN" })"))));
}

TEST(OddRecordings, clocks_may_count_nanoseconds_since_1970) {
  const Folder folder;
  std::string ticks = "%time,depth,fz\n", fast = "t_ns,z_mm,F_N\n";
  for (const auto& [t, d, f] : press()) {
    const auto since = static_cast<long long>(std::llround(1e9 * t));
    ticks += fmt::format("{},{:.8f},{:.6f}\n", 1617289471123456789 + since, 1e-3 * d, f);
    fast += fmt::format("{},{:.5f},{:.6f}\n", 1617289471123456789 + since / 1000000, d, f);
  }
  folder.write("ros.csv", ticks), folder.write("fast.csv", fast);
  expect_press(check(folder, manifest("ros.csv", R"(
columns = { time = "%time", depth = "depth", force = "fz" }
units = { time = "ns", position = "m", force = "N" })",
                                      kPlaced)));
  expect_press(check(folder, manifest("fast.csv", "", kPlaced)));  // steps of 10 ns
}

TEST(OddRecordings, numbers_may_be_grouped_or_quoted_and_headers_labelled) {
  const Folder folder;
  const auto grouped = [](double value) {
    const long whole = std::lround(std::abs(value));
    return (value < 0 ? "-" : "") + (whole < 1000
                                         ? fmt::format("{}", whole)
                                         : fmt::format("{},{:03}", whole / 1000, whole % 1000));
  };
  const auto comma = [](double value) {
    std::string text = fmt::format("{:.6f}", value);
    return text.replace(text.find('.'), 1, ",");
  };
  std::string thousands = "t (s)\tdepth (um)\tforce (mN)\n", quoted = "t_s,z_mm,F_N\n",
              unsure = "depth (um)\tforce (mN)\n", labelled = "# columns: t z F spare\n";
  for (const auto& [t, d, f] : press()) {
    thousands += fmt::format("{:.2f}\t{}\t{}\n", t, grouped(1e3 * d), grouped(1e3 * f));
    quoted += fmt::format("\"{}\",\"{}\",\"{}\"\n", comma(t), comma(d), comma(f));
    unsure += fmt::format("{}\t{}\n", grouped(1e3 * d), grouped(1e3 * f));
    labelled += fmt::format("{:.2f} {:.5f} {:.6f} 20.0\n", t, d, f);
  }
  folder.write("thousands.txt", thousands), folder.write("quoted.csv", quoted);
  folder.write("unsure.txt", unsure), folder.write("labelled.txt", labelled);
  for (const char* file : {"thousands.txt", "quoted.csv"}) {
    SCOPED_TRACE(file);
    expect_press(check(folder, manifest(file, "", kPlaced)));
  }
  expect_press(check(folder, manifest("labelled.txt", R"(
columns = { time = "t", depth = "z", force = "F" }
units = { time = "s", position = "mm", force = "N" })",
                                      kPlaced)));
  const Checked doubt = check(folder, manifest("unsure.txt", "", kPlaced));
  EXPECT_TRUE(holds(doubt.said.err, "may be a decimal or a thousand"));
  expect_press(check(folder, manifest("unsure.txt", "decimal = \".\"", kPlaced)));
  folder.write("shifted.txt", "tip load (N) z_mm\n0.1 0\n0.2 1\n");
  const Checked shifted =
      check(folder, manifest("shifted.txt",
                             "columns = { depth = \"z_mm\", force = \"load\" }\n"
                             "units = { force = \"N\" }",
                             kPlaced));
  EXPECT_TRUE(holds(shifted.said.err, "names 4 columns, the rows have 2"));
}

// Two topics in one log: a reading of the one, of the other or of both to each stamp.
TEST(OddRecordings, positions_and_forces_of_two_rates_on_one_clock_are_read_at_the_forces_times) {
  const Folder folder;
  std::string apart = "t_s,z_mm,F_N\n", shared = apart, lost = apart;
  const auto rows = press();
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto& [t, d, f] = rows[i];
    apart += fmt::format("{:.4f},{:.5f},\n", t, d);
    if (i % 2 == 0 && i + 1 < rows.size()) {  // 4 ms later than a position
      const double later_mm = d + 0.4 * (rows[i + 1][1] - d);
      apart += fmt::format("{:.4f},,{:.6f}\n", t + 0.004, hertz_N(later_mm - kFree_mm, 10));
    }
    shared += fmt::format("{:.4f},{:.5f},{}\n", t, d, i % 2 ? "nan" : fmt::format("{:.6f}", f));
    lost += fmt::format("{:.4f},{:.5f},{}\n", t, d, i % 50 == 7 ? "" : fmt::format("{:.6f}", f));
  }
  folder.write("apart.csv", apart), folder.write("shared.csv", shared);
  folder.write("lost.csv", lost);
  for (const char* file : {"apart.csv", "shared.csv"}) {
    SCOPED_TRACE(file);
    const Checked read = check(folder, manifest(file, "", kPlaced));
    expect_press(read);
    EXPECT_TRUE(holds(read.json.dump(), "interpolated at the times of the forces"));
  }
  const Checked some = check(folder, manifest("lost.csv", "", kPlaced));
  EXPECT_TRUE(holds(some.said.err, "column `F_N` has no value here"));
  const Checked timeless = check(
      folder, manifest("apart.csv", "columns = { depth = \"z_mm\", force = \"F_N\" }", kPlaced));
  EXPECT_TRUE(holds(timeless.said.err, "no time says how they belong"));
}

TEST(OddRecordings,
     a_filter_that_is_too_long_is_refused_and_the_longest_that_is_not_moves_no_contact) {
  const Folder folder;
  folder.write("a.csv", table("t_s,z_mm,F_N", "{:.2f},{:.5f},{:.6f}"));
  const Checked strong = check(folder, manifest("a.csv", "smooth = \"0.5 s\"", kPlaced));
  const std::string remedy = "Leave `smooth` out, or say ";
  const std::size_t at = strong.said.err.find(remedy);
  ASSERT_NE(at, std::string::npos) << strong.said.err;
  const double less_s = std::stod(strong.said.err.substr(at + remedy.size()));
  const Checked weak =
      check(folder, manifest("a.csv", fmt::format("smooth = \"{} s\"", less_s), kPlaced));
  ASSERT_EQ(weak.said.status, 0) << weak.said.err;
  const Json& r = weak.json.at("recordings").at(0);
  EXPECT_NEAR(r.at("contact_m"), 1e-3 * kFree_mm, 2 * r.at("contact_deviation_m").get<double>())
      << less_s << ": " << r;
  EXPECT_NEAR(r.at("force_N"), hertz_N(1e3 * r.at("depth_m").get<double>(), 10), 5e-3) << r;
}

// A folder's manifest as `new` proposes it, and what it said.
std::pair<std::string, std::string> proposed(const Folder& folder) {
  const Outcome said = palpate(folder, "new --recordings rig -o new.toml");
  EXPECT_EQ(said.status, 0) << said.err;
  return {content_of(folder / "new.toml"), said.err};
}

TEST(OddRecordings, a_folder_is_read_though_its_first_files_are_bad) {
  const Folder folder;
  fs::create_directory(folder / "rig");
  const std::string good = table("t_s,z_mm,F_N", "{:.2f},{:.5f},{:.6f}");
  folder.write("rig/a.csv", "");
  folder.write("rig/a_empty.csv", "t_s,z_mm,F_N\n");
  folder.write("rig/b_missed.csv",
               table("t_s,z_mm,F_N", "{:.2f},{:.5f},{:.6f}", 1, 1e-9));  // no contact
  for (const char* name : {"c", "d", "e"}) folder.write(std::string("rig/") + name + ".csv", good);
  const auto [text, err] = proposed(folder);
  for (const char* name : {"c", "d", "e"}) EXPECT_TRUE(holds(text, std::string(name) + ".csv"));
  EXPECT_TRUE(holds(err, "a_empty.csv: has no row of numbers; others alike are read"));
  EXPECT_TRUE(holds(err, "rig/a.csv: not used: is empty"));
  EXPECT_TRUE(holds(err, "b_missed.csv: "));
  const std::size_t defaults = text.find("[defaults]");
  ASSERT_NE(defaults, std::string::npos) << text;
  EXPECT_LT(defaults, text.find("[[recording]]"));
  EXPECT_TRUE(holds(text, "force_on = "));
  EXPECT_EQ(text.find("force_on = "), text.rfind("force_on = ")) << "in [defaults] alone\n" << text;
}

TEST(OddRecordings, headers_may_be_german_french_spanish_or_italian) {
  const std::string rows = "{:.2f};{:.5f};{:.6f}";
  for (const char* header :
       {"Zeit (s);Weg (mm);Kraft (N)", "Zeit;Eindringtiefe;Normalkraft",
        "Temps_s;Profondeur_mm;Effort_N", "temps;d\xC3\xA9placement;force",
        "Tiempo_s;Profundidad_mm;Fuerza_N", "tempo;spostamento;forza",
        "Temps (s);D\xE9placement (mm);Force (N)", "Elapsed (s);Crosshead (mm);LoadCell (N)"}) {
    const Folder folder;
    fs::create_directory(folder / "rig");
    folder.write("rig/a.csv", table(header, rows));
    std::string text = proposed(folder).first;
    text.insert(text.find("# position"), kPlaced + std::string("probe = { radius = \"5 mm\" }\n"));
    SCOPED_TRACE(text);
    expect_press(check(folder, text));
  }
}

}  // namespace
}  // namespace palpate::tools
