// `palpate report` on a small run: what the page holds, and the page itself in Chromium and Node
// where they are there.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>

#include "tests/tools/kept_run.hpp"
#include "tools/report/packed.hpp"

namespace palpate::tools {
namespace {

using namespace testing_support;

constexpr const char* kBegin = "<script type=\"application/json\" id=\"contents\">";

class Report : public KeptRun {
 protected:
  static Outcome report(const std::string& arguments) {
    return palpate(*folder_, "report " + arguments);
  }
  static nlohmann::json contents_of(const std::string& report) {
    const std::string page = content_of(report);
    const std::size_t begin = page.find(kBegin) + std::strlen(kBegin);
    return nlohmann::json::parse(page.substr(begin, page.find("</script>", begin) - begin));
  }
  // Where the page was built with npm's packages; "" where it was not.
  static std::string modules() {
    return fs::exists(fs::path(PALPATE_PAGE_DIR) / "page.html") ? PALPATE_PAGE_DIR : "";
  }
  static bool has_engine() { return fs::exists(fs::path(PALPATE_PAGE_DIR) / "engine.wasm"); }

  static Outcome node(const std::string& script, const std::string& arguments) {
    const std::string out = path(".node");
    const int raw = std::system(("node " PALPATE_SOURCE_DIR "/tests/tools/page/" + script + " " +
                                 modules() + " " + arguments + " >" + out + " 2>&1")
                                    .c_str());
    return {WIFEXITED(raw) ? WEXITSTATUS(raw) : 128, content_of(out), {}};
  }
  // A claim of browser.mjs about the report of a folder, the block's if none is given.
  static void expect_in_chromium(const std::string& claim, const std::string& output,
                                 const std::string& folder = "out") {
    ASSERT_EQ(report(path(folder) + " -o " + path("report.html")).status, 0);
    const Outcome seen = node("browser.mjs", claim + " " + path("report.html") + " " + output);
    EXPECT_EQ(seen.status, 0) << seen.out;
  }
  // Three numbers of each row, from the named column on.
  static std::vector<std::array<double, 3>> vectors(const fs::path& csv, const std::string& name) {
    std::istringstream rows(content_of(csv));
    std::string line;
    std::getline(rows, line);
    const auto before = line.substr(0, line.find(name));
    const auto first = std::count(before.begin(), before.end(), ',');
    std::vector<std::array<double, 3>> out;
    while (std::getline(rows, line)) {
      std::istringstream fields(line);
      std::string field;
      for (long k = 0; k < first; ++k) std::getline(fields, field, ',');
      for (double& value : out.emplace_back()) {
        std::getline(fields, field, ',');
        value = std::stod(field);
      }
    }
    return out;
  }
  // Forces that a native replay gives along a path, against those in another table.
  static void expect_native_forces(const std::string& path_csv, const fs::path& forces_csv) {
    const Outcome replay = palpate(*folder_, "replay " + path("out/asset.palp") + " " + path_csv +
                                                 " -o " + path("native.csv"));
    ASSERT_EQ(replay.status, 0) << replay.err;
    const auto native = vectors(path("native.csv"), "fx_N"), other = vectors(forces_csv, "fx_N");
    ASSERT_EQ(native.size(), other.size());
    std::size_t touching = 0, differing = 0;
    for (std::size_t i = 0; i < native.size(); ++i) {
      touching += native[i] != std::array<double, 3>{};
      differing += native[i] != other[i];
    }
    EXPECT_GT(touching, native.size() / 10) << "of " << native.size();
    EXPECT_EQ(differing, 0u) << "of " << native.size();
  }
};

#define SKIP_WITHOUT_PAGE() \
  if (modules().empty()) GTEST_SKIP() << "no page was built (Node.js with npm's packages)"
#define SKIP_WITHOUT_ENGINE() \
  SKIP_WITHOUT_PAGE();        \
  if (!has_engine()) GTEST_SKIP() << "no engine in the page (clang++ makes no WebAssembly)"
#define SKIP_WITHOUT_CHROMIUM() \
  SKIP_WITHOUT_ENGINE();        \
  if (!fs::exists("/usr/bin/chromium")) GTEST_SKIP() << "no Chromium (package chromium)"

TEST_F(Report, holds_what_the_run_left_in_one_file) {
  SKIP_WITHOUT_PAGE();
  const Outcome outcome = report(path("out") + " -o " + path("report.html"));
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const std::string page = content_of(path("report.html"));
  const auto contents = contents_of(path("report.html"));
  EXPECT_EQ(contents.at("schema"), "palpate-report");
  EXPECT_TRUE(fs::exists(path("out/report.html")));  // of the run itself
  EXPECT_EQ(contents.at("name"), "out");
  EXPECT_EQ(contents.at("statement"),
            nlohmann::json::parse(content_of(path("out/statement.json"))));
  EXPECT_EQ(contents.at("points").at("name").size(), 4u);
  const auto bytes = fs::file_size(path("out/asset.palp"));
  EXPECT_EQ(contents.at("asset").at("bytes").get<std::string>().size(), (bytes + 2) / 3 * 4);
  for (const char* loads : {"src=\"http", "href=\"http", "@import"})
    EXPECT_EQ(page.find(loads), std::string::npos) << loads;
  // The same folder gives the same page, which may take the place of the old one.
  ASSERT_EQ(report(path("out") + " -o " + path("report.html")).status, 0);
  EXPECT_TRUE(content_of(path("report.html")) == page);
}

TEST_F(Report, of_a_part_of_a_run_shows_that_part) {
  SKIP_WITHOUT_PAGE();
  fs::create_directories(path("part"));
  for (const char* file : {"samples.h5", "curves.h5"})
    fs::copy_file(path("out/") + file, path("part/") + file, fs::copy_options::overwrite_existing);
  const Outcome outcome = report(path("part") + " -o " + path("part.html"));
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_NE(content_of(path("part.html")).find("\"points\""), std::string::npos);
}

TEST_F(Report, of_two_folders_compares_them) {
  SKIP_WITHOUT_PAGE();
  fs::create_directories(path("part"));
  fs::copy_file(path("out/samples.h5"), path("part/samples.h5"),
                fs::copy_options::overwrite_existing);
  const Outcome outcome = report(path("out") + " " + path("part") + " -o " + path("compared.html"));
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const auto compared = contents_of(path("compared.html")).at("compared");
  ASSERT_EQ(compared.size(), 2u);
  EXPECT_EQ(compared[0].at("name"), "out");
  EXPECT_EQ(compared[0].at("points"), 4);
  EXPECT_TRUE(compared[0].contains("statement"));
  EXPECT_EQ(compared[1].at("rows"), compared[0].at("rows"));
  EXPECT_FALSE(compared[1].contains("statement"));
}

TEST_F(Report, of_a_folder_without_results_is_refused) {
  fs::create_directories(path("empty"));
  const Outcome outcome = report(path("empty") + " -o " + path("empty.html"));
  EXPECT_EQ(outcome.status, 1);
  EXPECT_NE(outcome.err.find("holds no file of a run"), std::string::npos) << outcome.err;
  EXPECT_EQ(report(path("out") + " " + path("empty") + " -o " + path("empty.html")).status, 1);
  EXPECT_EQ(report(path("out") + " " + path("absent") + " -o " + path("empty.html")).status, 1);
  EXPECT_FALSE(fs::exists(path("empty.html")));
}

TEST_F(Report, of_a_folder_with_an_odd_name_is_whole) {
  SKIP_WITHOUT_PAGE();
  const std::string name = "<script>\"\xff";
  fs::create_directories(path(name));
  fs::copy_file(path("out/curves.h5"), path(name) + "/curves.h5",
                fs::copy_options::overwrite_existing);
  const Outcome outcome = report("'" + path(name) + "/.' -o " + path("odd.html"));
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(contents_of(path("odd.html")).at("name"), "<script>\"\uFFFD");
  EXPECT_EQ(content_of(path("odd.html")).find("<script>\\\""), std::string::npos);
}

TEST_F(Report, of_a_body_prepared_anew_shows_the_model_and_says_so) {
  SKIP_WITHOUT_PAGE();
  folder_->write("scene.toml", kScene);
  folder_->write("block.off", block_off(6));
  fs::create_directories(path("stale"));
  fs::copy_file(path("out/model.h5"), path("stale/model.h5"), fs::copy_options::overwrite_existing);
  const Outcome prepared =
      palpate(*folder_, "prepare " + path("scene.toml") + " -o " + path("stale/body.h5"));
  ASSERT_EQ(prepared.status, 0) << prepared.err;
  for (const char* of : {"out", "stale"})
    ASSERT_EQ(report(path(of) + " -o " + path(std::string(of) + ".html")).status, 0);
  const auto run = contents_of(path("out.html")), stale = contents_of(path("stale.html"));
  EXPECT_EQ(run.at("warnings").dump().find("another surface"), std::string::npos);
  EXPECT_NE(stale.at("warnings").dump().find("another surface"), std::string::npos);
  EXPECT_TRUE(stale.at("surface") == run.at("surface"));
}

TEST_F(Report, finds_its_page_where_it_is_installed_and_says_how_to_get_it) {
  fs::create_directories(path("bin"));
  fs::copy_file(PALPATE_PROGRAM, path("bin/palpate"), fs::copy_options::overwrite_existing);
  const int raw = std::system((path("bin/palpate") + " report " + path("out") + " -o " +
                               path("none.html") + " 2>" + path("said"))
                                  .c_str());
  EXPECT_EQ(WEXITSTATUS(raw), 1);
  EXPECT_NE(content_of(path("said")).find("palpate_page"), std::string::npos);
  EXPECT_FALSE(fs::exists(path("none.html")));

  SKIP_WITHOUT_PAGE();
  fs::create_directories(path("share/palpate"));
  fs::copy_file(modules() + "/page.html", path("share/palpate/page.html"),
                fs::copy_options::overwrite_existing);
  EXPECT_EQ(std::system((path("bin/palpate") + " report " + path("out") + " -o " +
                         path("some.html") + " 2>" + path("said"))
                            .c_str()),
            0);
}

// Presses, drags along and across, and a walk at random through the top of the block.
TEST_F(Report, engine_in_webassembly_answers_the_native_bits) {
  SKIP_WITHOUT_ENGINE();
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> step(-1, 1);
  std::ofstream file(path("path.csv"));
  file.precision(17);
  file << "t_s,x_m,y_m,z_m\n";
  double at[3] = {0.04, 0.04, 0.031};
  const auto go = [&](double x, double y, double z, int ticks) {
    static int row = 0;
    const double from[3] = {at[0], at[1], at[2]}, to[3] = {x, y, z};
    for (int i = 1; i <= ticks; ++i) {
      for (int k = 0; k < 3; ++k) at[k] = from[k] + (to[k] - from[k]) * i / ticks;
      file << 0.001 * row++ << ',' << at[0] << ',' << at[1] << ',' << at[2] << '\n';
    }
  };
  go(0.04, 0.04, 0.0268, 200);
  go(0.048, 0.043, 0.0268, 400);
  go(0.033, 0.036, 0.0275, 600);
  go(0.033, 0.036, 0.031, 100);
  for (int leg = 0; leg < 60; ++leg)
    go(0.04 + 0.012 * step(random), 0.04 + 0.012 * step(random), 0.0285 + 0.002 * step(random),
       150);
  file.close();
  const Outcome played =
      node("engine.mjs", PALPATE_SOURCE_DIR "/tools/page/src " + path("out/asset.palp") + " " +
                             path("path.csv") + " " + path("wasm.csv"));
  ASSERT_EQ(played.status, 0) << played.out;
  expect_native_forces(path("path.csv"), path("wasm.csv"));
}

// Across the middle of the block the curves differ from facet to facet.
TEST_F(Report, without_interpolation_forces_jump_between_facets) {
  SKIP_WITHOUT_ENGINE();
  std::ofstream file(path("slide.csv"));
  file.precision(17);
  file << "t_s,x_m,y_m,z_m\n";
  for (int i = 0; i < 1200; ++i)
    file << 0.001 * i << ',' << 0.03 + 0.02 * std::max(i - 200, 0) / 1000 << ',' << 0.043 << ','
         << 0.0305 - 0.0035 * std::min(i, 200) / 200 << '\n';
  file.close();
  std::map<std::string, double> largest_change_N;
  for (const std::string mode : {"blended", "faceted"}) {
    const Outcome played =
        node("engine.mjs", PALPATE_SOURCE_DIR "/tools/page/src " + path("out/asset.palp") + " " +
                               path("slide.csv") + " " + path("wasm.csv") + " " + mode);
    ASSERT_EQ(played.status, 0) << played.out;
    const auto force = vectors(path("wasm.csv"), "fx_N");
    double& largest = largest_change_N[mode];
    for (std::size_t i = 400; i < force.size(); ++i)
      largest = std::max(largest, std::abs(force[i][2] - force[i - 1][2]));
  }
  EXPECT_GT(largest_change_N["faceted"], 5 * largest_change_N["blended"])
      << largest_change_N["blended"] << " N at most with interpolation";
}

TEST_F(Report, page_sources_are_formatted_linted_and_typed) {
  SKIP_WITHOUT_PAGE();
  const std::string page = modules(), sources = PALPATE_SOURCE_DIR "/tools/page";
  const auto says = [&](const std::string& command) {
    const int raw = std::system((command + " >" + path("said") + " 2>&1").c_str());
    return raw == 0 ? "" : content_of(path("said"));
  };
  EXPECT_EQ(
      says("cd " + sources + " && node " + page + "/node_modules/@biomejs/biome/bin/biome ci ."),
      "");
  const nlohmann::json project{
      {"extends", sources + "/tsconfig.json"},
      {"compilerOptions",
       {{"baseUrl", page},
        {"paths", {{"*", {"./node_modules/@types/*", "./node_modules/*"}}}},
        {"types", nlohmann::json::array()}}},
      {"include", {sources + "/src"}}};
  folder_->write("tsconfig.json", project.dump());
  EXPECT_EQ(says("node " + page + "/node_modules/typescript/bin/tsc -p " + path("tsconfig.json")),
            "");
}

TEST_F(Report, of_a_scene_that_has_not_been_run_shows_its_set_up) {
  SKIP_WITHOUT_PAGE();
  folder_->write("scene.toml", kScene);
  folder_->write("block.off", block_off(8));
  const Outcome outcome = palpate(
      *folder_, "check " + path("scene.toml") + " --no-trial --page " + path("set-up.html"));
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_NE(content_of(path("set-up.html")).find("\"held_m\""), std::string::npos);
}

TEST_F(Report, opens_from_disk_without_error_or_request) {
  SKIP_WITHOUT_CHROMIUM();
  expect_in_chromium("opens_from_disk_without_error_or_request", "-");
}

TEST_F(Report, a_click_shows_the_curves_of_the_nearest_point) {
  SKIP_WITHOUT_CHROMIUM();
  expect_in_chromium("a_click_shows_the_curves_of_the_nearest_point", "-");
}

TEST_F(Report, of_an_asset_alone_does_not_say_that_nothing_is_covered) {
  SKIP_WITHOUT_CHROMIUM();
  fs::create_directories(path("asset"));
  fs::copy_file(path("out/asset.palp"), path("asset/asset.palp"),
                fs::copy_options::overwrite_existing);
  expect_in_chromium("grey_means_uncovered_only_beside_a_map", "-", "asset");
}

TEST_F(Report, a_drag_with_the_mouse_yields_the_native_forces) {
  SKIP_WITHOUT_CHROMIUM();
  expect_in_chromium("a_drag_is_recorded", path("touch.csv"));
  ASSERT_TRUE(fs::exists(path("touch.csv")));
  expect_native_forces(path("touch.csv"), path("touch.csv"));
}

TEST_F(Report, the_body_gives_way_under_the_tool) {
  SKIP_WITHOUT_CHROMIUM();
  expect_in_chromium("the_body_gives_way_under_the_tool", "");
}

TEST_F(Report, a_gamepad_presses_drags_and_turns) {
  SKIP_WITHOUT_CHROMIUM();
  expect_in_chromium("a_gamepad_presses_drags_and_turns", "-");
}

// The ball of 48 facets of the golden asset, felt along an arc.
TEST_F(Report, facets_are_heard_and_interpolation_is_not) {
  SKIP_WITHOUT_ENGINE();
  const Outcome heard =
      node("sound.mjs", PALPATE_SOURCE_DIR "/tools/page/src " PALPATE_SOURCE_DIR
                                           "/tests/libfit/runtime/golden/version_1.palp 0.03");
  ASSERT_EQ(heard.status, 0) << heard.out;
  double smooth = 0, faceted = 0;
  long samples = 0, again = 0;
  std::istringstream(heard.out) >> smooth >> samples >> faceted >> again;
  EXPECT_EQ(samples, 72000);  // 1.5 s at 48 kHz
  EXPECT_EQ(again, samples);
  EXPECT_GT(smooth, 0);
  EXPECT_GT(faceted, 8 * smooth) << heard.out;
}

TEST_F(Report, a_large_surface_is_moved_and_met_by_rays_in_a_share_of_the_time) {
  SKIP_WITHOUT_PAGE();
  const Outcome seen = node("surface.mjs", PALPATE_SOURCE_DIR "/tools/page/src");
  EXPECT_EQ(seen.status, 0) << seen.out;
}

TEST_F(Report, the_sound_switch_plays_what_the_tool_feels) {
  SKIP_WITHOUT_CHROMIUM();
  expect_in_chromium("the_sound_switch_plays_what_the_tool_feels", "-");
}

// An import beside the run: a sound press, one without contact, and a file of no numbers.
class Recordings : public Report {
 protected:
  void SetUp() override {
    fs::create_directories(path("rig"));
    folder_->write("rig/a.csv", press(true)), folder_->write("rig/b.csv", press(false));
    folder_->write("rig/c.csv", "t,d,F\n0,0,0\n0,x,1\n");
    std::string manifest =
        "[defaults]\ncolumns = { time = \"t\", depth = \"d\", force = \"F\" }\nunits = { time = "
        "\"s\", position = \"mm\", force = \"N\" }\nforce_on = \"body\"\nnormal = [0, 0, "
        "-1]\nposition = [0, 0, 40]\nprobe = { shape = \"sphere\", radius = \"5 mm\" }\n";
    for (const char* file : {"a.csv", "b.csv", "c.csv"})
      manifest += "[[recording]]\nfile = \"" + std::string(file) + "\"\n";
    folder_->write("rig/manifest.toml", manifest);
    outcome =
        palpate(*folder_, "import " + path("rig/manifest.toml") + " -o " + path("rig/samples.h5"));
    ASSERT_EQ(outcome.status, 3) << outcome.err;
    outcome = palpate(*folder_, "fit " + path("rig/samples.h5") + " -o " + path("rig/curves.h5"));
    ASSERT_EQ(outcome.status, 0) << outcome.err;
  }
  // Into the body and back, with a rest between, in 900 readings.
  static std::string press(bool touches) {
    std::string text = "t,d,F\n";
    for (int i = 0; i < 900; ++i) {
      const double travel_mm = i < 400 ? 0.015 * i : i < 500 ? 6 : 0.015 * (900 - i);
      const double depth_mm = std::max(0.0, travel_mm - 2);
      const double force_N = touches ? 0.4 * std::pow(depth_mm / 4, 1.5) : 0;
      text += std::to_string(0.01 * i) + "," + std::to_string(travel_mm) + "," +
              std::to_string(0.1 + force_N + 1e-3 * ((i * 7919) % 11 - 5)) + "\n";
    }
    return text;
  }
  Outcome outcome;
};

TEST_F(Recordings, all_are_in_the_page_refused_ones_first) {
  SKIP_WITHOUT_PAGE();
  ASSERT_EQ(report(path("rig") + " -o " + path("report.html")).status, 0);
  const auto pictures = contents_of(path("report.html")).at("pictures");
  EXPECT_EQ(pictures.at("file"), (nlohmann::json{"b.csv", "c.csv", "a.csv"}));
  EXPECT_EQ(pictures.at("all"), (nlohmann::json{1, 0, 0, 2}));
  EXPECT_EQ(pictures.at("readings")[1], 0) << "nothing was read of it";
  EXPECT_NE(pictures.at("reasons")[0].get<std::string>(), "");
  EXPECT_NE(pictures.at("reasons")[1].get<std::string>().find("`x` is not a number"),
            std::string::npos);
  const auto of_b = pictures.at("readings")[0].get<std::size_t>();
  for (const char* key : {"push_N", "travel_m", "time_s"}) {
    const auto all = unpacked<float>(pictures.at(key));
    EXPECT_LE(all.size(), 2 * 202u);
    EXPECT_GE(all.size(), 2 * 190u);
    EXPECT_TRUE(std::all_of(all.begin(), all.end(), [](float v) { return std::isfinite(v); }));
  }
  // Half of them on the press, and every phase among them.
  const auto travel = unpacked<float>(pictures.at("travel_m"));
  const auto phase = unpacked<std::uint8_t>(pictures.at("phase"));
  const auto used = unpacked<std::uint8_t>(pictures.at("is_used"));
  std::array<int, 5> count{};
  int pressed = 0;
  for (std::size_t i = of_b; i < travel.size(); ++i) {
    ++count.at(phase.at(i));
    pressed += used.at(i) && travel[i] > 2e-3;
  }
  EXPECT_GT(count[0], 50);
  EXPECT_GT(count[1], 5);
  EXPECT_GT(count[2], 20);
  EXPECT_GT(pressed, 60);
  EXPECT_NEAR(unpacked<float>(pictures.at("contact_m")).at(2), 2e-3, 1e-4);
  EXPECT_NEAR(unpacked<float>(pictures.at("bias_N")).at(2), 0.1, 1e-3);
}

TEST_F(Recordings, of_another_import_are_not_shown) {
  SKIP_WITHOUT_PAGE();
  folder_->write("rig/a.csv", press(true) + "9.5,0,0.1\n");
  fs::copy_file(path("rig/samples.signals.h5"), path("rig/kept.h5"),
                fs::copy_options::overwrite_existing);
  ASSERT_EQ(
      palpate(*folder_, "import " + path("rig/manifest.toml") + " -o " + path("rig/samples.h5"))
          .status,
      3);
  fs::rename(path("rig/kept.h5"), path("rig/samples.signals.h5"));
  ASSERT_EQ(report(path("rig") + " -o " + path("report.html")).status, 0);
  const auto contents = contents_of(path("report.html"));
  EXPECT_FALSE(contents.contains("pictures"));
  EXPECT_NE(contents.at("warnings").dump().find("of another import"), std::string::npos);
}

TEST_F(Recordings, are_drawn_in_both_schemes_and_on_narrow_screens) {
  SKIP_WITHOUT_CHROMIUM();
  expect_in_chromium("recordings_are_drawn", folder_->path().string(), "rig");
}

TEST_F(Report, keys_alone_reach_everything) {
  SKIP_WITHOUT_CHROMIUM();
  expect_in_chromium("keys_alone_reach_everything", "-");
}

TEST_F(Report, both_schemes_and_narrow_screens_hold_it) {
  SKIP_WITHOUT_CHROMIUM();
  expect_in_chromium("both_schemes_and_narrow_screens_hold_it", folder_->path().string());
}

}  // namespace
}  // namespace palpate::tools
