// `palpate report` on a small run: what the page holds, and the page itself in Chromium and Node
// where they are there.

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/tools/report_page.hpp"

namespace palpate::tools {
namespace {

TEST_F(Report, holds_what_the_run_left_in_one_file) {
  SKIP_WITHOUT_PAGE();
  const Outcome outcome = report("out -o report.html");
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
    EXPECT_FALSE(holds(page, loads));
  // The same folder gives the same page, which may take the place of the old one.
  ASSERT_EQ(report("out -o report.html").status, 0);
  EXPECT_TRUE(content_of(path("report.html")) == page);
}

TEST_F(Report, of_a_part_of_a_run_shows_that_part) {
  SKIP_WITHOUT_PAGE();
  fs::create_directories(path("part"));
  for (const char* file : {"samples.h5", "curves.h5"})
    fs::copy_file(path("out/") + file, path("part/") + file, fs::copy_options::overwrite_existing);
  const Outcome outcome = report("part -o part.html");
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_TRUE(holds(content_of(path("part.html")), "\"points\""));
}

TEST_F(Report, of_a_folder_without_results_is_refused) {
  fs::create_directories(path("empty"));
  const Outcome outcome = report("empty -o empty.html");
  EXPECT_EQ(outcome.status, 1);
  EXPECT_TRUE(holds(outcome.err, "holds no file of a run"));
  EXPECT_EQ(report("absent -o empty.html").status, 1);
  EXPECT_FALSE(fs::exists(path("empty.html")));
}

TEST_F(Report, of_a_folder_with_an_odd_name_is_whole) {
  SKIP_WITHOUT_PAGE();
  const std::string name = "<script>\"\xff";
  fs::create_directories(path(name));
  fs::copy_file(path("out/curves.h5"), path(name) + "/curves.h5",
                fs::copy_options::overwrite_existing);
  const Outcome outcome = report("'" + path(name) + "/.' -o odd.html");
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(contents_of(path("odd.html")).at("name"), "<script>\"\uFFFD");
  EXPECT_FALSE(holds(content_of(path("odd.html")), "<script>\\\""));
}

TEST_F(Report, of_a_body_prepared_anew_shows_the_model_and_says_so) {
  SKIP_WITHOUT_PAGE();
  folder_->write("scene.toml", kScene);
  folder_->write("block.off", block_off(6));
  fs::create_directories(path("stale"));
  fs::copy_file(path("out/model.h5"), path("stale/model.h5"), fs::copy_options::overwrite_existing);
  const Outcome prepared = palpate(*folder_, "prepare scene.toml -o stale/body.h5");
  ASSERT_EQ(prepared.status, 0) << prepared.err;
  for (const char* of : {"out", "stale"})
    ASSERT_EQ(report(path(of) + " -o " + path(std::string(of) + ".html")).status, 0);
  const auto run = contents_of(path("out.html")), stale = contents_of(path("stale.html"));
  EXPECT_FALSE(holds(run.at("warnings").dump(), "another surface"));
  EXPECT_TRUE(holds(stale.at("warnings").dump(), "another surface"));
  EXPECT_TRUE(stale.at("surface") == run.at("surface"));
}

TEST_F(Report, finds_its_page_where_it_is_installed_and_says_how_to_get_it) {
  fs::create_directories(path("bin"));
  fs::copy_file(PALPATE_PROGRAM, path("bin/palpate"), fs::copy_options::overwrite_existing);
  const Outcome none = shell(*folder_, "bin/palpate report out -o none.html");
  EXPECT_EQ(none.status, 1);
  EXPECT_TRUE(holds(none.err, "palpate_page"));
  EXPECT_FALSE(fs::exists(path("none.html")));

  SKIP_WITHOUT_PAGE();
  fs::create_directories(path("share/palpate"));
  fs::copy_file(modules() + "/page.html", path("share/palpate/page.html"),
                fs::copy_options::overwrite_existing);
  EXPECT_EQ(shell(*folder_, "bin/palpate report out -o some.html").status, 0);
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
  const Outcome played = node("engine.mjs", "out/asset.palp path.csv wasm.csv");
  ASSERT_EQ(played.status, 0) << played.out;
  expect_native_forces(path("path.csv"), path("wasm.csv"));
}

TEST_F(Report, page_sources_are_formatted_linted_and_typed) {
  SKIP_WITHOUT_PAGE();
  const std::string page = modules(), sources = PALPATE_SOURCE_DIR "/tools/page";
  const auto says = [&](const std::string& command) {
    const Outcome outcome = shell(*folder_, command);
    return outcome.status == 0 ? "" : outcome.out + outcome.err;
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
  EXPECT_EQ(says("node " + page + "/node_modules/typescript/bin/tsc -p tsconfig.json"), "");
}

// Playwright 1.62 wants Node.js 20, and Debian 12 has 18.
TEST(Page, is_built_and_tested_with_the_node_of_debian_12) {
  const auto lock =
      nlohmann::json::parse(content_of(PALPATE_SOURCE_DIR "/tools/page/package-lock.json"));
  for (const auto& [name, package] : lock.at("packages").items()) {
    const std::string wanted =
        package.value("/engines/node"_json_pointer, std::string());  // ">=18", "^18.2 || >=20"
    const auto oldest = wanted.find_first_of("0123456789");
    EXPECT_LE(oldest == std::string::npos ? 0 : std::stoi(wanted.substr(oldest)), 18) << name;
  }
}

TEST_F(Report, of_a_scene_that_has_not_been_run_shows_its_set_up) {
  SKIP_WITHOUT_PAGE();
  folder_->write("scene.toml", kScene);
  folder_->write("block.off", block_off(8));
  const Outcome outcome = palpate(*folder_, "check scene.toml --no-trial --page set-up.html");
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  SKIP_WITHOUT_CHROMIUM();
  const Outcome seen =
      node("browser.mjs", "a_click_picks_the_window " + path("set-up.html") + " " + path("region"));
  ASSERT_EQ(seen.status, 0) << seen.out;
  std::string scene = kScene;
  const std::size_t window = scene.find("region = ");
  scene.replace(window, scene.find("depth = ") - window, content_of(path("region")));
  folder_->write("picked.toml", scene);
  const Outcome checked = palpate(*folder_, "check picked.toml --no-trial");
  EXPECT_EQ(checked.status, 0) << scene << checked.err;
}

// A statement of no row was drawn as 0.0 %.
TEST_F(Report, of_figures_without_a_row_shows_no_number) {
  fs::create_directories(path("soft"));
  for (const char* file : {"body.h5", "curves.h5", "asset.palp", "validation.csv"})
    fs::copy_file(path("out/") + file, path("soft/") + file, fs::copy_options::overwrite_existing);
  auto statement = nlohmann::json::parse(content_of(path("out/statement.json")));
  for (const char* name : {"median_rel", "p95_rel", "max_rel"})
    statement["force_error"][name] = nullptr;
  const auto empty = [](auto& figures) {
    for (auto* errors : {&figures, &figures["torque_at_handle"], &figures["magnitude"]})
      (*errors)["median_rel"] = (*errors)["p95_rel"] = nullptr;
    figures["direction_deg"]["median"] = figures["direction_deg"]["p95"] = nullptr;
    figures["unnoticed"] = nullptr;
  };
  empty(statement);
  for (auto& figures : statement["by_path"]) empty(figures);
  for (const char* name : {"reference_p95_rel", "within_reference", "tick_ns"})
    statement[name] = nullptr;
  statement["baselines"] = nlohmann::json::object();
  statement["verdict"] = "Poor: said of the asset.";
  statement["words"] = "All that is known.";
  folder_->write("soft/statement.json", statement.dump());
  SKIP_WITHOUT_CHROMIUM();
  expect_in_chromium("no_row_is_no_number", "-", "soft");
}

TEST_F(Report, of_an_asset_alone_does_not_say_that_nothing_is_covered) {
  SKIP_WITHOUT_CHROMIUM();
  fs::create_directories(path("asset"));
  fs::copy_file(path("out/asset.palp"), path("asset/asset.palp"),
                fs::copy_options::overwrite_existing);
  expect_in_chromium("grey_means_uncovered_only_beside_a_map", "-", "asset");
}

class InChromium : public Report, public testing::WithParamInterface<const char*> {};

TEST_P(InChromium, holds) {
  SKIP_WITHOUT_CHROMIUM();
  expect_in_chromium(GetParam(), folder_->path().string());
}

INSTANTIATE_TEST_SUITE_P(
    Report, InChromium,
    testing::Values("opens_from_disk_without_error_or_request",
                    "a_click_shows_the_curves_of_the_nearest_point",
                    "a_click_shows_the_forces_of_the_nearest_held_out_path",
                    "the_body_gives_way_under_the_tool", "two_fingers_are_two_tools",

                    "the_window_is_pressed_at_once_and_all_else_turns_the_body",
                    "grey_says_that_it_is_not_measured", "the_body_is_seen_cut_from_the_side",
                    "axe_finds_nothing", "keys_alone_reach_everything",
                    "the_body_is_lit_alike_wherever_it_lies",
                    "both_schemes_and_narrow_screens_hold_it"),
    [](const auto& claim) { return std::string(claim.param); });

}  // namespace
}  // namespace palpate::tools
