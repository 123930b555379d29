// A statement in words: verdict, advice, and what a person notices.

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/libfit/validation/statement_rows.hpp"

namespace palpate::validation {
namespace {

TEST(statement, a_verdict_names_the_torque_and_the_surface_where_they_were_compared) {
  Statement s = summarize({{1, 0.02}});
  EXPECT_EQ(verdict(s).find("torque"), std::string::npos) << verdict(s);
  EXPECT_EQ(verdict(s).find("surface"), std::string::npos) << verdict(s);
  s.all.handle.p95_rel = 0.14;
  s.shape.rows = 1;
  s.shape.near.p95_m = 6.1e-4;
  EXPECT_NE(verdict(s).find(" Also off, at most in 19 of 20: torque at a handle by 14.0 %, the "
                            "surface near the tool by 0.61 mm."),
            std::string::npos)
      << verdict(s);
}

TEST(statement, the_verdict_says_in_how_many_rows_a_person_notices_the_error) {
  const Statement s = summarize({{0.05, 0.0049}, {0.05, 0.004}, {0.045, 0.004}});
  EXPECT_EQ(s.within_jnd, 1);
  EXPECT_EQ(verdict(s),
            "Fair: 19 of 20 forces are within 9.8 % of the simulated: 9.8 % in size, 0 degrees in "
            "direction. A person would notice the error in 100 % of the forces above 40 mN.");
}

TEST(statement, an_error_of_direction_is_stated_in_degrees_and_judged_by_what_is_noticed) {
  Rows rows;
  for (int i = 0; i < 20; ++i) {
    rows.add(1, 0);
    rows.answer_N.back() = Vec3(0.2, 0, 1);
  }
  const Statement s = summarize(rows);
  EXPECT_NEAR(s.all.force.p95_rel, 0.2, 1e-12);
  EXPECT_NEAR(s.all.magnitude.p95, std::sqrt(1.04) - 1, 1e-12);
  EXPECT_NEAR(s.all.direction_deg.p95, 11.3099, 1e-4);
  EXPECT_EQ(s.within_jnd, 0);
  EXPECT_EQ(s.all.unnoticed, 1);
  EXPECT_EQ(
      verdict(s).rfind(
          "Good: 19 of 20 forces are within 20.0 % of the simulated: 2.0 % in size, 11 degrees", 0),
      0u)
      << verdict(s);
  for (Vec3& force_N : rows.answer_N) force_N = Vec3(0.6, 0, 0.8);
  EXPECT_EQ(summarize(rows).all.unnoticed, 0) << "37 degrees";
  EXPECT_EQ(verdict(summarize(rows)).rfind("Poor", 0), 0u);
  const auto json = nlohmann::json::parse(to_json(s));
  EXPECT_NEAR(json.at("direction_deg").at("p95").get<double>(), 11.3099, 1e-4);
  EXPECT_NEAR(json.at("magnitude").at("p95_rel").get<double>(), 0.0198, 1e-4);
}

// Half as much again is noticed, be it less than the least force that is felt.
TEST(statement, an_error_below_the_least_force_is_noticed_in_a_force_above_it) {
  const Rows rows{{0.05, 0.025}, {0.02, 0.01}};
  EXPECT_EQ(validation::summarize(compare(rows.reference, rows.answer())).all.unnoticed, 0);
}

TEST(statement, a_tenth_more_is_noticed_at_rest_and_not_by_a_hand_that_slides) {
  const Rows rows{{1, 0.09}};
  Replayed answer = rows.answer();
  EXPECT_EQ(validation::summarize(compare(rows.reference, answer)).all.unnoticed, 0);
  answer.is_sliding[0] = 1;
  EXPECT_EQ(validation::summarize(compare(rows.reference, answer)).all.unnoticed, 1);
}

TEST(statement, a_verdict_names_the_grades_at_both_ends_of_its_band) {
  Rows rows;
  for (std::int32_t place = 0; place < 6; ++place)
    for (int i = 0; i < 10; ++i) {
      rows.add(1, place < 5 ? 0.05 : 0.09, place);
    }
  EXPECT_EQ(verdict(summarize(rows)),
            "Poor to good: 19 of 20 forces are within 9.0 % of the simulated (5.2 % to 22.3 %, as "
            "few places were tried): 9.0 % in size, 0 degrees in direction. A person would notice "
            "the error in 17 % of the forces above 40 mN.");
  Statement few = summarize(rows);
  few.p95_rel_high = 3e5;
  EXPECT_NE(verdict(few).find("9.0 % of the simulated (too few places to tell)"),
            std::string::npos);
}

TEST(statement, a_verdict_counts_slides_where_the_body_changes) {
  Rows rows;
  for (std::int32_t place = 0; place < 6; ++place) rows.add(1, 0.05, place);
  Statement s = summarize(rows);
  EXPECT_EQ(verdict(s).find("Good: "), 0u) << verdict(s);
  s.sections = {{"where_it_changes", "where the body changes", {line("all", {{1, 0.12}})}}};
  EXPECT_EQ(
      verdict(s),
      "Poor to good: 19 of 20 forces are within 5.0 % of the simulated (5.0 % to 5.0 %, as few "
      "places were tried): 5.0 % in size, 0 degrees in direction; 12.0 % in size where stiffness "
      "changes most. A person would notice the error in 0 % of the forces above 40 mN.");
}

TEST(statement, a_poor_asset_ends_with_what_to_do_about_it) {
  Statement s = summarize({{1, 0.15}, {2, 0.3}});
  EXPECT_NE(in_words(s).find("causes = true"), std::string::npos) << in_words(s);
  s.sections = {
      {"by_path", "by path", {line("straight", {{1, 0.02}}), line("sliding", {{1, 0.4}})}},
      {"causes",
       "by cause",
       {line("interpolation", {{1, 0.05}}), line("curve_fit", {}),
        line("friction_law", {{1, 0.14}})}}};
  const auto advised = advice(s);
  ASSERT_EQ(advised.size(), 2u);
  EXPECT_EQ(advised[0], "It is worst on paths of the kind sliding, 40.0 %.");
  EXPECT_EQ(advised[1].rfind("Most of it is felt while sliding", 0), 0u) << advised[1];
  EXPECT_TRUE(in_words(s).ends_with("drag_directions.")) << in_words(s);
  s.sections.back().lines.push_back(line("curve_family", {{1, 0.2}}));
  EXPECT_NE(advice(s)[1].find("family of [fit] at \"rings\""), std::string::npos) << advice(s)[1];
  s.sections.back().lines.pop_back();
  EXPECT_EQ(verdict(s),
            "Poor: 19 of 20 forces are within 15.0 % of the simulated: 15.0 % in size, 0 degrees "
            "in direction. A person would notice the error in 100 % of the forces above 40 mN.");
  const Statement fair = summarize({{1, 0.09}}), good = summarize({{1, 0.02}});
  EXPECT_TRUE(advice(fair).empty());
  EXPECT_EQ(verdict(fair).rfind("Fair", 0), 0u);
  EXPECT_EQ(verdict(good).rfind("Good", 0), 0u);
  Rows noisy{{1, 0.15}};
  noisy.reference.force_error[0] = 0.12;
  EXPECT_NE(advice(summarize(noisy)).at(0).find("force_tolerance = 0.04"), std::string::npos);
}

TEST(statement, advice_on_a_scan_is_not_of_its_surface) {
  Statement s = summarize({{1, 0.3}});
  s.is_recorded = true;
  s.sections = {{"by_motion", "by motion", {line("sliding", {{1, 0.3}})}}};
  EXPECT_EQ(advice(s).at(0), "Most of it lies between the passes: record more of them.");
  s.sections.push_back({"baselines", "baselines", {line("nearest_rows", {{1, 0.1}})}});
  EXPECT_NE(advice(s).at(0).find("several depths at each place"), std::string::npos);
}

TEST(statement, sections_of_any_name_are_read_back_in_order_and_said) {
  Statement s = summarize({{1, 0.02}});
  StatedError felt = line("felt", {{1, 0.05}}), alone = line("each_by_itself", {{1, 0.5}});
  felt.handle = {5e-3, 1e-4, 2e-4, 3e-4, 0.01, 0.02, 0.03};
  felt.tick_ns = 9000;
  s.sections = {
      {"causes", "by cause", {line("interpolation", {{1, 0.05}}), line("curve_fit", {{2, 0.1}})}},
      {"baselines", "baselines", {}},
      {"tool", "the tool, as balls", {felt, alone}}};
  const Statement back = parse_statement(to_json(s), "statement.json");
  EXPECT_EQ(to_json(back), to_json(s));
  ASSERT_EQ(back.sections.size(), 3u);
  EXPECT_EQ(back.sections[2].title, "the tool, as balls");
  ASSERT_EQ(back.lines_of("causes").size(), 2u);
  EXPECT_EQ(back.lines_of("causes")[1].name, "curve_fit");
  EXPECT_NEAR(back.lines_of("causes")[1].force.p95, 0.1, 1e-12);
  EXPECT_NEAR(back.lines_of("tool")[1].force.max_rel, 0.5, 1e-12);
  EXPECT_TRUE(back.lines_of("baselines").empty());
  EXPECT_TRUE(back.lines_of("none of these").empty());
  EXPECT_TRUE(nlohmann::json::parse(to_json(s)).at("baselines").empty()) << "others read it";
  const std::string words = in_words(back);
  EXPECT_NE(words.find("\n  interpolation "), std::string::npos) << words;
  EXPECT_EQ(words.find("baselines"), std::string::npos) << words;
  EXPECT_NE(words.find("the tool, as balls, torque at the handle\n  felt "), std::string::npos)
      << words;
  EXPECT_NE(words.find("1.0 %   2.0 %   0.20 Nmm"), std::string::npos) << words;
  EXPECT_NE(words.find("a tick of felt: 9000 ns on this machine"), std::string::npos) << words;
}

TEST(statement, how_well_the_surface_is_shown_is_read_back_and_said_in_a_sentence) {
  Statement s = summarize({{1, 0.02}});
  EXPECT_EQ(in_words(s).find("surface"), std::string::npos);
  EXPECT_TRUE(nlohmann::json::parse(to_json(s)).at("shape_error").empty());
  s.shape = {{1e-4, 2e-4, 3e-4, 0.01, 0.02, 0.03}, {4e-4, 5e-4, 6e-4, 0.04, 0.05, 0.06}, 12};
  const Statement back = parse_statement(to_json(s), "statement.json");
  EXPECT_EQ(to_json(back), to_json(s));
  EXPECT_EQ(back.shape.rows, 12u);
  EXPECT_NEAR(back.shape.all.p95_rel, 0.05, 1e-12);
  EXPECT_NE(in_words(back).find("within 0.10 mm near the tool, 1.0 % of the depth (median;\n"
                                "p95 0.20 mm, 2.0 %), and within 5.0 % over the whole body"),
            std::string::npos)
      << in_words(back);
}

TEST(statement, words_fit_eighty_columns) {
  Statement s = summarize({{1, 0.02}, {200, 150}});
  s.probes = 1000;
  s.all.rows = 123456;
  s.reference_failures = 10000;
  s.reference_p95_rel = 0.5;
  s.sections = {{"by_path", "by path", {line("back_and_forth", {{1, 99.9}})}},
                {"causes", "by cause", {line("curve_fit", {{100, 1e-9}})}},
                {"baselines", "baselines", {line("one_response", {{200, 199}})}}};
  s.sections[0].lines[0].handle = {5e-3, 0.999, 0.999, 0.999, 0.5, 0.9, 2};
  s.sections[0].lines[0].tick_ns = 123456;
  s.shape = {{0.01, 0.02, 0.03, 0.5, 0.9, 2}, {0.01, 0.02, 0.03, 0.5, 0.9, 2}, 10000};
  Statement soft = summarize({{2e-7, 1e-7}, {3e-7, 0}});
  soft.sections = {{"by_path", "by path", {line("back_and_forth", {{1e-9, 1e-9}}, soft.floor_N)}},
                   {"causes", "by cause", {line("interpolation", {{2e-7, 1e-7}}, soft.floor_N)}}};
  for (const Statement& statement : {s, soft}) {
    std::istringstream words(in_words(statement));
    for (std::string text; std::getline(words, text);) EXPECT_LE(text.size(), 80u) << text;
  }
}

}  // namespace
}  // namespace palpate::validation
