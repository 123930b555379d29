#include <gtest/gtest.h>

#include <limits>

#include "libfit/core/perception.hpp"
#include "libfit/core/stated_error.hpp"
#include "libfit/core/statistics.hpp"
#include "libfit/core/text.hpp"

namespace palpate {
namespace {

TEST(Statistics, quantiles_are_values_that_occur_and_a_share_does_not_exceed) {
  const std::vector<double> ten{9, 1, 8, 2, 7, 3, 6, 4, 10, 5};
  EXPECT_EQ(quantile(ten, 0.5), 5);
  EXPECT_EQ(quantile(ten, 0.95), 10);
  EXPECT_EQ(lower_quantile(ten, 0.95), 9) << "of ten values the largest counts only for share 1";
  EXPECT_EQ(quantile(ten, 0), 1);
  EXPECT_EQ(quantile(ten, 1), 10);
  EXPECT_EQ(lower_quantile(ten, 1), 10);
}

TEST(Statistics, medians_of_an_even_number_take_the_side_they_say) {
  EXPECT_EQ(median({4, 1, 3, 2}), 2);
  EXPECT_EQ(upper_median({4, 1, 3, 2}), 3);
  EXPECT_EQ(median({5, 1, 3}), 3);
  EXPECT_EQ(upper_median({5, 1, 3}), 3);
}

TEST(Statistics, without_values_all_are_zero) {
  EXPECT_EQ(quantile({}, 0.95), 0);
  EXPECT_EQ(lower_quantile({}, 0.95), 0);
  EXPECT_EQ(upper_median({}), 0);
}

TEST(RelativeError, is_over_the_force_and_over_the_floor_where_the_force_is_lighter) {
  EXPECT_DOUBLE_EQ(relative_error(0.1, 2, perception().force_floor_N), 0.05);
  EXPECT_DOUBLE_EQ(relative_error(0.01, 0.001, perception().force_floor_N), 0.25);
}

TEST(RelativeError, that_is_stated_leaves_out_rows_at_the_floor_and_below) {
  EXPECT_EQ(stated_errors({{0.01, 2}, {0.01, 0.1}, {0.02, perception().force_floor_N}}),
            (std::vector<double>{0.01 / 2, 0.01 / 0.1}));
  EXPECT_EQ(stated_errors({{1e-4, 0.01}, {1e-4, 0.002}, {1e-4, 0.001}}),
            (std::vector<double>{1e-4 / 0.01, 1e-4 / 0.002}))
      << "of a soft body a tenth of its largest";
  EXPECT_TRUE(stated_errors({}).empty());
}

TEST(RelativeError, that_decides_knows_no_newtons) {
  EXPECT_DOUBLE_EQ(relative_floor(300), 1000 * relative_floor(0.3));
  EXPECT_EQ(relative_floor(0.3), relative_floor_N(0.3));
  EXPECT_EQ(relative_floor_N(300), perception().force_floor_N);
}

TEST(RelativeError, seven_percent_cannot_be_felt_and_neither_can_the_floor) {
  EXPECT_TRUE(is_within_threshold(0.07, 1));
  EXPECT_FALSE(is_within_threshold(0.071, 1));
  EXPECT_TRUE(is_within_threshold(perception().force_floor_N, 0));
}

TEST(Perception, numbers_are_those_of_the_table) {
  const Perception& known = perception();
  EXPECT_EQ(known.force_at_rest, 0.07);
  EXPECT_EQ(known.force_in_motion, 0.1);
  EXPECT_NEAR(known.force_floor_N, 0.04, 1e-15);
  EXPECT_NEAR(known.direction_deg, 25.6, 1e-9);
  EXPECT_EQ(known.torque, 0.127);
}

TEST(Text, numbers_are_short_and_shares_and_lengths_wear_their_unit) {
  EXPECT_EQ(number(1234.5), "1.23e+03");
  EXPECT_EQ(number(1234.5, 6), "1234.5");
  EXPECT_EQ(percent(0.0213), "2.1 %");
  EXPECT_EQ(percent(0.0213, 0), "2 %");
  EXPECT_EQ(millimetres(0.00213), "2.13 mm");
  EXPECT_EQ(coordinates({0.01, 0.02, 0}), "(0.01, 0.02, 0) m");
  EXPECT_EQ(file_line("rig.csv", 12), "rig.csv:12");
}

TEST(Text, one_thing_is_singular_and_lists_have_separators_between) {
  EXPECT_EQ(counted(1, "edge", "edges"), "1 edge");
  EXPECT_EQ(counted(0, "edge", "edges"), "0 edges");
  EXPECT_EQ(listed(std::vector<std::string>{"a", "b"}, "; "), "a; b");
  std::string message;
  add_sentence(message, "one");
  add_sentence(message, "two");
  EXPECT_EQ(message, "one; two");
}

TEST(Text, a_double_reads_back_from_its_text) {
  for (const double value : {0.1, -1e-300, 1e5, std::numeric_limits<double>::max()})
    EXPECT_EQ(std::stod(to_text(value)), value) << to_text(value);
}

}  // namespace
}  // namespace palpate
