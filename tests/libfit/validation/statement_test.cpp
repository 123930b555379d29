#include "libfit/validation/statement.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>

#include "libfit/validation/replay.hpp"

namespace palpate::validation {
namespace {

// Reference rows with their answers.
struct Rows {
  Samples reference;
  std::vector<Vec3> answer_N;

  Rows(std::initializer_list<std::array<double, 2>> rows = {}) {
    for (const auto& [reference_N, error_N] : rows) add(reference_N, error_N);
  }
  void add(double reference_N, double error_N, std::int32_t place = 0) {
    const Eigen::Index row = reference.rows();
    reference.point.push_back(place);
    reference.status.push_back(RowStatus::good);
    reference.deflection.setZero(row + 1, 3);
    reference.force.conservativeResize(row + 1, 3);
    reference.force.row(row) << 0, 0, reference_N;
    reference.force_error.conservativeResize(row + 1);
    reference.force_error[row] = 0.01 * reference_N;
    answer_N.emplace_back(0, 0, reference_N + error_N);
  }
  Replayed answer() const {
    Replayed out(reference);
    for (std::size_t i = 0; i < answer_N.size(); ++i) out.force_N.row(i) = answer_N[i];
    out.is_answered.assign(answer_N.size(), 1);
    return out;
  }
};

Statement summarize(const Rows& rows) {
  return validation::summarize(compare(rows.reference, rows.answer()));
}

// A line of rows of a body whose floor is 0.04 N, or of a softer one.
StatedError line(std::string name, const Rows& rows, double floor_N = 0.04) {
  return stated_error(std::move(name), compare(rows.reference, rows.answer()), {floor_N});
}

TEST(statement, quantiles_are_nearest_rank_over_rows_above_the_floor) {
  Rows rows;
  for (int i = 1; i <= 100; ++i) rows.add(1, i * 1e-3);
  rows.add(0.01, 0.03);  // below the floor: counts in N, not in %
  const Statement s = summarize(rows);
  EXPECT_EQ(s.rows_above_floor, 100u);
  EXPECT_NEAR(s.all.force.median_rel, 0.050, 1e-12);
  EXPECT_NEAR(s.all.force.p95_rel, 0.095, 1e-12);
  EXPECT_NEAR(s.all.force.max_rel, 0.100, 1e-12);
  EXPECT_NEAR(s.within_jnd, 70.5 / 101, 0.6 / 101) << "that of 7 % rounds to either side";
  EXPECT_NEAR(s.reference_p95_rel, 0.01, 1e-12);
}

TEST(statement, says_when_it_compares_noise) {
  // Stated 1 % of each row; errors of 0.5, 0.9 and 1.5 %.
  const Statement noise = summarize({{1, 0.005}, {1, 0.009}, {1, 0.015}});
  EXPECT_NEAR(noise.within_reference, 2.0 / 3, 1e-12);
  EXPECT_NE(in_words(noise).find("at 67 % of rows the error is within"), std::string::npos)
      << in_words(noise);
  const Statement clear = summarize({{1, 0.05}, {1, 0.09}});
  EXPECT_EQ(clear.within_reference, 0);
  EXPECT_EQ(in_words(clear).find("noise"), std::string::npos) << in_words(clear);
}

TEST(statement, without_rows_nothing_is_claimed) {
  Statement s = summarize({});
  EXPECT_EQ(s.all.rows, 0u);
  const auto json = nlohmann::json::parse(to_json(s));
  for (const auto& [name, figure] : json.at("force_error").items())
    EXPECT_TRUE(figure.is_null()) << name;
  for (const char* name : {"reference_p95_rel", "within_reference", "tick_ns"})
    EXPECT_TRUE(json.at(name).is_null()) << name;
  EXPECT_EQ(json.at("verdict"), "No verdict: no row could be compared.");
  EXPECT_TRUE(json.at("advice").empty());
  EXPECT_EQ(in_words(s).find('%'), std::string::npos) << in_words(s);
  EXPECT_EQ(to_json(parse_statement(to_json(s), "statement.json")), to_json(s));
}

// It said 0.0 / 0.0 / 0.0 %, 100 % of rows within JND, of a spleen of 200 Pa that was off by 13 %.
TEST(statement, of_a_body_softer_than_a_hand_feels_has_its_error_and_no_share_within_jnd) {
  Rows rows;
  for (int i = 1; i <= 20; ++i) rows.add(1e-3 * i, 0.13e-3 * i);
  const Statement s = summarize(rows);
  EXPECT_DOUBLE_EQ(s.floor_N, 0.002);
  EXPECT_EQ(s.rows_above_floor, 18u);
  EXPECT_NEAR(s.all.force.median_rel, 0.13, 1e-12);
  EXPECT_NEAR(s.all.force.p95_rel, 0.13, 1e-12);
  EXPECT_TRUE(std::isnan(s.within_jnd));
  EXPECT_TRUE(nlohmann::json::parse(to_json(s)).at("force_error").at("within_jnd").is_null());
  const std::string words = in_words(s);
  EXPECT_NE(words.find("of the 18 rows above 2 mN"), std::string::npos) << words;
  EXPECT_NE(words.find("13.0 %   2.470 mN"), std::string::npos) << words;
  EXPECT_NE(words.find("no force reaches 40 mN"), std::string::npos) << words;
  EXPECT_EQ(words.find(" 0.0 %"), std::string::npos) << words;
  EXPECT_NE(words.find("Poor: 19 of 20 forces"), std::string::npos) << words;
  // A hand that meets what no reference has does feel the error.
  rows.answer_N[3] = Vec3(0, 0, 3);
  EXPECT_NEAR(summarize(rows).within_jnd, 19.0 / 20, 1e-12);
}

TEST(statement, the_floor_is_what_a_person_feels_where_a_tenth_of_the_largest_force_is_more) {
  EXPECT_EQ(summarize({{0.05, 0}, {0.4, 0}, {7, 0}}).floor_N, 0.04);
  EXPECT_DOUBLE_EQ(summarize({{0.05, 0}, {0.2, 0}}).floor_N, 0.02);
  EXPECT_EQ(summarize({{0, 0.1}}).floor_N, 0);
  EXPECT_EQ(verdict(summarize({{0, 0.1}})), "No verdict: no row above 0 N.");
}

TEST(statement, a_verdict_names_the_torque_and_the_surface_where_they_were_compared) {
  Statement s = summarize({{1, 0.02}});
  EXPECT_EQ(verdict(s).find("torque"), std::string::npos) << verdict(s);
  EXPECT_EQ(verdict(s).find("surface"), std::string::npos) << verdict(s);
  s.all.handle.p95_rel = 0.14;
  s.shape.rows = 1;
  s.shape.near.p95_m = 6.1e-4;
  EXPECT_NE(
      verdict(s).find(", torque at the handle to 14.0 %, the surface near the tool to 0.61 mm"),
      std::string::npos)
      << verdict(s);
}

TEST(statement, a_kind_of_path_of_which_no_row_counts_has_newtons_and_no_share) {
  Statement s = summarize({{1, 0.02}, {0.01, 0.001}});
  s.sections = {
      {"by_path",
       "by path",
       {line("straight", {{1, 0.02}}), line("wandering", {{0.01, 0.001}}), line("tilting", {})}}};
  const auto json = nlohmann::json::parse(to_json(s)).at("by_path");
  EXPECT_TRUE(json.at("wandering").at("p95_rel").is_null());
  EXPECT_NEAR(json.at("wandering").at("p95_N").get<double>(), 0.001, 1e-12);
  EXPECT_TRUE(json.at("tilting").at("median_N").is_null());
  const Statement back = parse_statement(to_json(s), "statement.json");
  EXPECT_EQ(to_json(back), to_json(s));
  EXPECT_TRUE(std::isnan(back.lines_of("by_path")[1].force.median_rel));
  const std::string words = in_words(s);
  EXPECT_NE(words.find(
                "  wandering                   -       -   0.0010 N       -       -      -      -"),
            std::string::npos)
      << words;
  EXPECT_NE(words.find("(-: no row above 40 mN)"), std::string::npos) << words;
}

// A soft body was told "more than the 7 % that a person notices" of rows that nobody feels.
TEST(statement, the_verdict_says_in_how_many_rows_a_person_notices_the_error) {
  const Statement s = summarize({{0.05, 0.0049}, {0.05, 0.004}, {0.045, 0.004}});
  EXPECT_EQ(s.within_jnd, 1);
  EXPECT_EQ(
      verdict(s),
      "Fair: 19 of 20 forces are right to 9.8 % in size and to 0 degrees in direction; a person "
      "notices the error in 0 % of the rows.");
}

// A side force that is wrong by a fifth counted like a push that is: it turns the force by 11
// degrees, of which people notice 25.
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
      verdict(s).rfind("Good: 19 of 20 forces are right to 2.0 % in size and to 11 degrees", 0), 0u)
      << verdict(s);
  for (Vec3& force_N : rows.answer_N) force_N = Vec3(0.6, 0, 0.8);
  EXPECT_EQ(summarize(rows).all.unnoticed, 0) << "37 degrees";
  EXPECT_EQ(verdict(summarize(rows)).rfind("Poor", 0), 0u);
  const auto json = nlohmann::json::parse(to_json(s));
  EXPECT_NEAR(json.at("direction_deg").at("p95").get<double>(), 11.3099, 1e-4);
  EXPECT_NEAR(json.at("magnitude").at("p95_rel").get<double>(), 0.0198, 1e-4);
}

// Truths drawn from the deviations, of a press and a slide on a half-space (Hertz, Coulomb).
TEST(statement, its_interval_holds_95_of_100_seeded_truths) {
  const BodyKnowledge known{0.22, 0.45, 0.02, 0.3, 0.4, 0.05, 0.04};
  const TruthInterval interval = *truth_interval(known);
  EXPECT_NEAR(
      interval.young + interval.poisson + interval.friction + interval.held + interval.replay, 1,
      1e-12);
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  int inside = 0;
  constexpr int kTruths = 4000;
  const auto force = [](double young, double nu, double mu) {
    return young / (1 - nu * nu) * std::sqrt(1 + mu * mu);
  };
  const double sigma = std::sqrt(std::log1p(0.22 * 0.22));
  for (int i = 0; i < kTruths; ++i) {
    const double truth = force(std::exp(sigma * normal(random)), 0.45 + 0.02 * normal(random),
                               0.3 * (1 + 0.4 * normal(random))) *
                         (1 + 0.05 * normal(random)) * (1 + 0.04 / 1.96 * normal(random));
    const double off = truth / force(1, 0.45, 0.3) - 1;
    inside += interval.low_rel <= off && off <= interval.high_rel;
  }
  EXPECT_GT(inside, 0.94 * kTruths);
  EXPECT_LT(inside, 0.96 * kTruths);
  EXPECT_FALSE(truth_interval({}).has_value()) << "nothing is known of how well it is known";
  Statement s = summarize({{1, 0.02}});
  s.interval = interval;
  EXPECT_EQ(to_json(parse_statement(to_json(s), "statement.json")), to_json(s));
  EXPECT_NE(in_words(s).find("forces of the body itself: 95 % within -3"), std::string::npos)
      << in_words(s);
}

TEST(statement, a_tenth_more_is_noticed_at_rest_and_not_by_a_hand_that_slides) {
  const Rows rows{{1, 0.09}};
  Replayed answer = rows.answer();
  EXPECT_EQ(validation::summarize(compare(rows.reference, answer)).all.unnoticed, 0);
  answer.is_sliding[0] = 1;
  EXPECT_EQ(validation::summarize(compare(rows.reference, answer)).all.unnoticed, 1);
}

TEST(statement, p95_of_all_places_lies_in_the_band_of_eight_of_them_eight_times_of_ten) {
  // Errors of a place share a factor; 60 draws of 8 places from 4000, seeds from 1.
  const auto drawn = [](unsigned seed, std::int32_t places) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    Rows rows;
    for (std::int32_t place = 0; place < places; ++place) {
      const double factor = 0.04 * std::exp(0.4 * normal(random));
      for (int i = 0; i < 20; ++i) {
        rows.add(1, factor * std::abs(1 + 0.3 * normal(random)), place);
      }
    }
    return summarize(rows);
  };
  const double truth = drawn(1000, 1000).all.force.p95_rel;
  int held = 0;
  double width = 0;
  for (unsigned seed = 1; seed <= 60; ++seed) {
    const Statement s = drawn(seed, 8);
    EXPECT_LE(s.p95_rel_low, s.all.force.p95_rel);
    EXPECT_GE(s.p95_rel_high, s.all.force.p95_rel);
    held += s.p95_rel_low <= truth && truth <= s.p95_rel_high;
    width += (s.p95_rel_high - s.p95_rel_low) / truth / 60;
    EXPECT_EQ(parse_statement(to_json(s), "statement.json").p95_rel_low, s.p95_rel_low);
  }
  EXPECT_GE(held, 46);
  EXPECT_LT(width, 1);
  EXPECT_TRUE(std::isnan(drawn(1, 1).p95_rel_low));
}

TEST(statement, a_verdict_names_the_grades_at_both_ends_of_its_band) {
  Rows rows;
  for (std::int32_t place = 0; place < 6; ++place)
    for (int i = 0; i < 10; ++i) {
      rows.add(1, place < 5 ? 0.05 : 0.09, place);
    }
  EXPECT_EQ(verdict(summarize(rows)),
            "Poor to good: 19 of 20 forces are right to 9.0 % in size (5.2 % to 22.3 % if all "
            "places were tried) "
            "and to 0 degrees in direction; a person notices the error in 17 % of the rows.");
}

TEST(statement, a_verdict_counts_slides_where_the_body_changes) {
  Rows rows;
  for (std::int32_t place = 0; place < 6; ++place) rows.add(1, 0.05, place);
  Statement s = summarize(rows);
  EXPECT_EQ(verdict(s).find("Good: "), 0u) << verdict(s);
  s.sections = {{"where_it_changes", "where the body changes", {line("all", {{1, 0.12}})}}};
  EXPECT_EQ(
      verdict(s),
      "Poor to good: 19 of 20 forces are right to 5.0 % in size (5.0 % to 5.0 % if all places were "
      "tried) "
      "and to 0 degrees in direction, of slides where the body changes to 12.0 %; a person notices "
      "the error in 0 % of the rows.");
}

TEST(statement, a_poor_asset_ends_with_what_to_do_about_it) {
  Statement s = summarize({{1, 0.15}, {2, 0.3}});
  EXPECT_NE(in_words(s).find("set causes = true"), std::string::npos) << in_words(s);
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
  EXPECT_EQ(
      verdict(s),
      "Poor: 19 of 20 forces are right to 15.0 % in size and to 0 degrees in direction; a person "
      "notices the error in 100 % of the rows.");
  const Statement fair = summarize({{1, 0.09}}), good = summarize({{1, 0.02}});
  EXPECT_TRUE(advice(fair).empty());
  EXPECT_EQ(verdict(fair).rfind("Fair", 0), 0u);
  EXPECT_EQ(verdict(good).rfind("Good", 0), 0u);
  Rows noisy{{1, 0.15}};
  noisy.reference.force_error[0] = 0.12;
  EXPECT_NE(advice(summarize(noisy)).at(0).find("force_tolerance = 0.04"), std::string::npos);
}

// Advances by what a test says.
struct FakeClock {
  using time_point = std::chrono::steady_clock::time_point;
  static time_point now() { return time_point(std::chrono::nanoseconds(ns)); }
  static inline long ns = 0;
};

// 162 ns on an idle machine were 17,198 on a loaded one, by their mean.
TEST(statement, a_tick_is_timed_as_if_a_loaded_machine_were_idle) {
  int batch = 0;
  const double ns = tick_ns<FakeClock>([&]() -> std::size_t {
    FakeClock::ns += ++batch % 3 == 0 ? 160 * 1000 : 17000 * 1000;  // a third goes undisturbed
    return 1000;
  });
  EXPECT_EQ(batch, 200);
  EXPECT_DOUBLE_EQ(ns, 160);
  batch = 0;
  tick_ns<FakeClock>([&]() -> std::size_t { return ++batch, 1000000; });
  EXPECT_GE(batch, 8) << "of few batches a quartile is the luck of one";
  EXPECT_EQ(tick_ns<FakeClock>([]() -> std::size_t { return 0; }), 0);
}

TEST(statement, unknown_reference_errors_do_not_count) {
  Rows unknown{{1, 0.01}};
  unknown.reference.force_error[0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(std::isnan(summarize(unknown).reference_p95_rel));
}

TEST(statement, reads_back_what_it_wrote) {
  Statement s = summarize({{1, 0.02}, {3, 0.5}});
  s.probes = 2;
  s.all.tick_ns = 123.5;
  s.asset_bytes = 4567;
  s.reference_failures = 1;
  const Statement back = parse_statement(to_json(s, "0123"), "statement.json");
  EXPECT_EQ(to_json(back), to_json(s));
}

TEST(statement, sections_of_any_name_are_read_back_in_order_and_said) {
  Statement s = summarize({{1, 0.02}});
  StatedError felt = line("felt", {{1, 0.05}}), foremost = line("foremost_ball", {{1, 0.5}});
  felt.handle = {5e-3, 1e-4, 2e-4, 3e-4, 0.01, 0.02, 0.03};
  felt.tick_ns = 9000;
  s.sections = {
      {"causes", "by cause", {line("interpolation", {{1, 0.05}}), line("curve_fit", {{2, 0.1}})}},
      {"baselines", "baselines", {}},
      {"tool", "the tool, as balls", {felt, foremost}}};
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

// An asset that was made for a capsule did not say how right the capsule is.
TEST(statement, an_asset_carries_what_is_stated_of_its_tool_but_no_time_of_a_tick) {
  Statement s = summarize({{1, 0.02}});
  s.sections = {{"tool", "the tool, as balls", {line("felt", {{1, 0.05}})}}};
  s.sections[0].lines[0].torque = {5e-3, 1e-4, 2e-4, 3e-4, 0.01, 0.02, 0.03};
  const std::string untimed = to_asset_json(s);
  s.sections[0].lines[0].tick_ns = 9000;
  EXPECT_EQ(to_asset_json(s), untimed);
  const auto felt = nlohmann::json::parse(untimed).at("tool").at("felt");
  EXPECT_NEAR(felt.at("p95_rel").get<double>(), 0.05, 1e-12);
  EXPECT_NEAR(felt.at("torque").at("p95_Nm").get<double>(), 2e-4, 1e-15);
}

TEST(statement, how_well_the_surface_is_shown_is_read_back_and_said_in_a_sentence) {
  Statement s = summarize({{1, 0.02}});
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
  s.shape = {{0.01, 0.02, 0.03, 0.5, 0.9, 2}, {0.01, 0.02, 0.03, 0.5, 0.9, 2}, 1, 10000};
  Statement soft = summarize({{2e-7, 1e-7}, {3e-7, 0}});
  soft.sections = {{"by_path", "by path", {line("back_and_forth", {{1e-9, 1e-9}}, soft.floor_N)}},
                   {"causes", "by cause", {line("interpolation", {{2e-7, 1e-7}}, soft.floor_N)}}};
  for (const Statement& statement : {s, soft}) {
    std::istringstream words(in_words(statement));
    for (std::string text; std::getline(words, text);) EXPECT_LE(text.size(), 80u) << text;
  }
}

TEST(statement, an_asset_carries_nothing_that_changes_from_one_machine_to_the_next) {
  Statement s = summarize({{1, 0.02}});
  s.all.tick_ns = 100;
  s.asset_bytes = 5;
  Statement other = s;
  other.all.tick_ns = 200;
  other.asset_bytes = 6;
  EXPECT_EQ(to_asset_json(s), to_asset_json(other));
  EXPECT_NE(to_asset_json(s).find("\"p95_rel\""), std::string::npos);
}

TEST(statement, json_holds_the_names_others_read) {
  const auto json = nlohmann::json::parse(to_json(summarize({{1, 0.02}})));
  for (const char* name :
       {"median_N", "p95_N", "max_N", "median_rel", "p95_rel", "max_rel", "within_jnd"})
    EXPECT_TRUE(json.at("force_error").at(name).is_number()) << name;
  for (const char* name : {"probes", "rows", "asset_bytes", "floor_N"})
    EXPECT_TRUE(json.at(name).is_number()) << name;
}

}  // namespace
}  // namespace palpate::validation
