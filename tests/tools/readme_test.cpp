// README.md is short, and its figures are those of the tables that they come from.

#include <gtest/gtest.h>

#include <cstdio>
#include <map>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/sources.hpp"

namespace palpate {
namespace {

using testing_support::kSourceRoot;
using testing_support::text_of;

// The rows of all tables of a page, by the first cell up to its first comma.
std::map<std::string, std::vector<std::string>> table_rows(const std::string& page) {
  std::map<std::string, std::vector<std::string>> rows;
  std::istringstream lines(page);
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("| ")) continue;
    std::vector<std::string> cells;
    std::istringstream rest(line.substr(2));
    for (std::string cell; std::getline(rest, cell, '|');)
      cells.push_back(std::regex_replace(cell, std::regex("^ +| +$"), ""));
    rows.emplace(cells[0].substr(0, cells[0].find(',')), cells);
  }
  return rows;
}

std::string figure(const std::string& text, const std::string& pattern) {
  std::smatch found;
  return std::regex_search(text, found, std::regex(pattern)) ? std::string(found[1]) : "";
}

// The 95th percentile of "**median / p95 / largest**".
std::string p95_of(const std::vector<std::string>& row) {
  return figure(row.at(2), R"re(/ ([0-9.]+) /)re");
}

// A number of a table, which the pattern finds, times a factor and in two digits.
std::string measured(const std::string& table, const std::string& pattern, double factor) {
  const std::string found = figure(text_of(kSourceRoot / "docs/bench" / table), pattern);
  const double value = factor * std::stod(found);
  char digits[32];
  std::snprintf(digits, sizeof digits, value < 1 ? "%.2f" : value < 10 ? "%.1f" : "%.0f", value);
  return digits;
}

TEST(readme, has_at_most_8000_bytes) {
  EXPECT_LE(text_of(kSourceRoot / "README.md").size(), 8000u);
}

TEST(readme, states_the_errors_of_the_validation) {
  const std::string page = text_of(kSourceRoot / "README.md");
  const std::string validation = text_of(kSourceRoot / "docs/validation.md");
  const auto measured_rows = table_rows(validation.substr(validation.find("## Assets")));
  int checked = 0;
  for (const auto& [body, cells] :
       table_rows(page.substr(page.find("## Accuracy"), page.find("## Limits")))) {
    if (cells.size() != 3 || !std::isdigit(cells[1][0])) continue;
    ASSERT_TRUE(measured_rows.contains(body)) << body;
    EXPECT_EQ(cells[1], p95_of(measured_rows.at(body))) << body;
    EXPECT_EQ(cells[2], measured_rows.at(body).at(3)) << body;
    ++checked;
  }
  EXPECT_EQ(checked, 6);
  EXPECT_EQ(figure(page, "toy dragon: ([0-9.]+)"), p95_of(measured_rows.at("dragon")));
  EXPECT_EQ(figure(page, "toy on two feet: ([0-9.]+)"),
            p95_of(measured_rows.at("a toy on two feet (\"cheburashka\")")));
  EXPECT_EQ(figure(page, "within ([0-9.]+ %) of an independent"),
            figure(validation, "at most ([0-9.]+ %) off"));
}

TEST(readme, states_times_and_rivals_as_measured) {
  const std::string page = text_of(kSourceRoot / "README.md");
  const struct {
    std::string stated, table, pattern;
    double factor;
  } cases[] = {
      {"([0-9.]+) µs while the tool sticks", "tick.csv",
       R"re(\n10050,rings,stick,engine,warm,([0-9]+))re", 1e-3},
      {"([0-9.]+) µs while it slides", "tick.csv", R"re(\n10050,rings,slip,engine,warm,([0-9]+))re",
       1e-3},
      {"only 20 places. ([0-9.]+) %", "rivals.csv",
       R"re(\nliver,Palpate,"[^"]*",20,20,24,206,([0-9.]+))re", 100},
      {"one spring [^%]* ([0-9.]+) %", "rivals.csv",
       R"re(\nliver,"proxy, one spring","[^"]*",0,20,[0-9]+,[0-9]+,([0-9.]+))re", 100},
      {"linear body ([0-9.]+) %", "rivals.csv",
       R"re(\nliver,"Green's functions","[^"]*",1566,20,[0-9]+,[0-9]+,([0-9.]+))re", 100},
      {"all that a millisecond allows. ([0-9.]+) %", "rivals.csv",
       R"re(\nliver,"corotational FEM","[^"]*",154,20,[0-9]+,[0-9]+,([0-9.]+))re", 100},
  };
  for (const auto& [stated, table, pattern, factor] : cases)
    EXPECT_EQ(figure(page, stated), measured(table, pattern, factor)) << stated;
  EXPECT_EQ(figure(page, "Two cores take ([0-9.]+) of the time"),
            measured("cluster.csv", R"re(\nthreads,1,10045,([0-9.]+))re", 1 / 391.3));
}

}  // namespace
}  // namespace palpate
