#include "libfit/validation/statement.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>

namespace palpate::validation {
namespace {

ComparedRow row(double reference_N, double error_N) {
  return {Vec3(0, 0, reference_N), Vec3(error_N, 0, reference_N), 0.01 * reference_N};
}

TEST(statement, an_exact_engine_has_no_error) {
  const Statement s = summarize({row(1, 0), row(2, 0)});
  EXPECT_EQ(s.max_N, 0);
  EXPECT_EQ(s.within_jnd, 1);
}

TEST(statement, quantiles_are_nearest_rank_over_rows_above_the_floor) {
  std::vector<ComparedRow> rows;
  for (int i = 1; i <= 100; ++i) rows.push_back(row(1, i * 1e-3));
  rows.push_back(row(0.01, 0.03));  // below the floor: counts in N, not in %
  const Statement s = summarize(rows);
  EXPECT_EQ(s.rows_above_floor, 100u);
  EXPECT_NEAR(s.median_rel, 0.050, 1e-12);
  EXPECT_NEAR(s.p95_rel, 0.095, 1e-12);
  EXPECT_NEAR(s.max_rel, 0.100, 1e-12);
  EXPECT_NEAR(s.within_jnd, 71.0 / 101, 1e-12);
  EXPECT_NEAR(s.reference_p95_rel, 0.01, 1e-12);
}

TEST(statement, says_when_it_compares_noise) {
  // Stated 1 % of each row; errors of 0.5, 0.9 and 1.5 %.
  const Statement noise = summarize({row(1, 0.005), row(1, 0.009), row(1, 0.015)});
  EXPECT_NEAR(noise.within_reference, 2.0 / 3, 1e-12);
  EXPECT_NE(in_words(noise).find("at 67 % of rows the error is within"), std::string::npos)
      << in_words(noise);
  const Statement clear = summarize({row(1, 0.05), row(1, 0.09)});
  EXPECT_EQ(clear.within_reference, 0);
  EXPECT_EQ(in_words(clear).find("noise"), std::string::npos) << in_words(clear);
}

TEST(statement, without_rows_nothing_is_claimed) {
  const Statement s = summarize({});
  EXPECT_EQ(s.within_jnd, 0);
  EXPECT_EQ(s.rows, 0u);
}

TEST(statement, unknown_reference_errors_do_not_count) {
  ComparedRow unknown = row(1, 0.01);
  unknown.reference_error_N = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(summarize({unknown}).reference_p95_rel, 0);
}

TEST(statement, reads_back_what_it_wrote) {
  Statement s = summarize({row(1, 0.02), row(3, 0.5)});
  s.probes = 2;
  s.tick_ns = 123.5;
  s.asset_bytes = 4567;
  s.reference_failures = 1;
  const Statement back = parse_statement(to_json(s, "0123"), "statement.json");
  EXPECT_EQ(to_json(back), to_json(s));
}

TEST(statement, causes_baselines_and_paths_are_read_back_by_name_and_in_order) {
  Statement s = summarize({row(1, 0.02)});
  s.causes = {named_error("interpolation", {row(1, 0.05)}),
              named_error("curve_fit", {row(2, 0.1)})};
  s.baselines = {named_error("linear", {row(1, 0.5)})};
  s.by_path = {named_error("straight", {row(1, 0.02)})};
  const Statement back = parse_statement(to_json(s), "statement.json");
  EXPECT_EQ(to_json(back), to_json(s));
  ASSERT_EQ(back.causes.size(), 2u);
  EXPECT_EQ(back.causes[1].name, "curve_fit");
  EXPECT_NEAR(back.causes[1].p95_N, 0.1, 1e-12);
  EXPECT_NEAR(back.causes[1].p95_rel, 0.05, 1e-12);
  EXPECT_NE(in_words(back).find("by cause\n  interpolation"), std::string::npos) << in_words(back);
}

TEST(statement, how_well_the_surface_is_shown_is_read_back_and_said_in_a_sentence) {
  Statement s = summarize({row(1, 0.02)});
  EXPECT_EQ(in_words(s).find("surface"), std::string::npos);
  EXPECT_TRUE(nlohmann::json::parse(to_json(s)).at("shape_error").empty());
  s.shape = {{1e-4, 2e-4, 3e-4, 0.01, 0.02, 0.03}, {4e-4, 5e-4, 6e-4, 0.04, 0.05, 0.06}, 7e-5, 12};
  const Statement back = parse_statement(to_json(s), "statement.json");
  EXPECT_EQ(to_json(back), to_json(s));
  EXPECT_EQ(back.shape.rows, 12u);
  EXPECT_NEAR(back.shape.all.p95_rel, 0.05, 1e-12);
  EXPECT_NEAR(back.shape.penetration_m, 7e-5, 1e-15);
  EXPECT_NE(in_words(back).find("within 0.10 mm near the tool, 1.0 % of the depth (median;\n"
                                "p95 0.20 mm, 2.0 %), and within 5.0 % over the whole body"),
            std::string::npos)
      << in_words(back);
}

TEST(statement, torques_are_read_back_said_in_newton_millimetres_and_left_out_of_the_asset) {
  Statement s = summarize({row(1, 0.02)});
  EXPECT_EQ(in_words(s).find("torque"), std::string::npos);
  s.torque = {{"all", 5e-3, 1e-4, 2e-4, 3e-4, 0.01, 0.02, 0.03},
              {"oblique", 5e-3, 4e-4, 5e-4, 6e-4, 0.04, 0.05, 0.06}};
  s.turning = {named_error("tilting", {row(1, 0.05)})};
  s.turning_torque = {s.torque[0]};
  s.turning_tick_ns = 700;
  const Statement back = parse_statement(to_json(s), "statement.json");
  EXPECT_EQ(to_json(back), to_json(s));
  EXPECT_EQ(back.turning_torque.size(), 1u);
  ASSERT_EQ(back.torque.size(), 2u);
  EXPECT_EQ(back.torque[1].name, "oblique");
  EXPECT_NEAR(back.torque[1].max_Nm, 6e-4, 1e-15);
  EXPECT_NE(in_words(back).find("0.10 Nmm   2.0 %  0.20 Nmm"), std::string::npos) << in_words(back);
  EXPECT_EQ(to_asset_json(s), to_asset_json(summarize({row(1, 0.02)})));
}

TEST(statement, of_several_tools_and_of_a_tool_of_balls_is_read_back_and_said) {
  Statement s = summarize({row(1, 0.02)});
  s.two_tools = {named_error("felt", {row(1, 0.03)})};
  s.two_tools_tick_ns = 800;
  s.tool = {named_error("felt", {row(1, 0.05)}), named_error("foremost_ball", {row(1, 0.5)})};
  s.tool_torque = {{"felt", 5e-3, 1e-4, 2e-4, 3e-4, 0.01, 0.02, 0.03}};
  s.tool_tick_ns = 9000;
  const Statement back = parse_statement(to_json(s), "statement.json");
  EXPECT_EQ(to_json(back), to_json(s));
  ASSERT_EQ(back.tool.size(), 2u);
  EXPECT_NEAR(back.tool[1].max_rel, 0.5, 1e-12);
  EXPECT_EQ(back.tool_torque.size(), 1u);
  EXPECT_NE(in_words(back).find("the tool, as balls"), std::string::npos) << in_words(back);
  EXPECT_NE(in_words(back).find("a tick of it: 9000 ns"), std::string::npos) << in_words(back);
  EXPECT_EQ(to_asset_json(s), to_asset_json(summarize({row(1, 0.02)})));
}

TEST(statement, words_fit_eighty_columns) {
  Statement s = summarize({row(1, 0.02), row(200, 150)});
  s.torque = {{"back_and_forth", 5e-3, 0.999, 0.999, 0.999, 0.5, 0.9, 2}};
  s.probes = 1000;
  s.rows = 123456;
  s.reference_failures = 10000;
  s.reference_p95_rel = 0.5;
  s.by_path = {named_error("back_and_forth", {row(1, 99.9)})};
  s.causes = {named_error("float_precision", {row(100, 1e-9)})};
  s.baselines = {named_error("one_response", {row(200, 199)})};
  s.shape = {{0.01, 0.02, 0.03, 0.5, 0.9, 2}, {0.01, 0.02, 0.03, 0.5, 0.9, 2}, 1, 10000};
  std::istringstream words(in_words(s));
  for (std::string text; std::getline(words, text);) EXPECT_LE(text.size(), 80u) << text;
}

TEST(statement, an_asset_carries_nothing_that_changes_from_one_machine_to_the_next) {
  Statement s = summarize({row(1, 0.02)});
  s.tick_ns = 100;
  s.asset_bytes = 5;
  Statement other = s;
  other.tick_ns = 200;
  other.asset_bytes = 6;
  EXPECT_EQ(to_asset_json(s), to_asset_json(other));
  EXPECT_NE(to_asset_json(s).find("\"p95_rel\""), std::string::npos);
}

TEST(statement, json_holds_the_names_others_read) {
  const auto json = nlohmann::json::parse(to_json(summarize({row(1, 0.02)})));
  for (const char* name :
       {"median_N", "p95_N", "max_N", "median_rel", "p95_rel", "max_rel", "within_jnd"})
    EXPECT_TRUE(json.at("force_error").at(name).is_number()) << name;
  for (const char* name : {"probes", "tick_ns", "asset_bytes"})
    EXPECT_TRUE(json.at(name).is_number()) << name;
}

}  // namespace
}  // namespace palpate::validation
