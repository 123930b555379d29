// palpate_bench as a user runs it: what it prints it writes.

#include <gtest/gtest.h>

#include <sstream>
#include <string>

#include "tests/tools/command_line.hpp"

namespace palpate::tools::testing_support {
namespace {

Outcome bench(const Folder& folder, const std::string& arguments) {
  return shell(folder, PALPATE_BENCH " " + arguments);
}

TEST(bench_fem, writes_the_table_that_it_prints) {
  const Folder folder;
  const Outcome outcome = bench(folder, "fem --part rates --quick -o .");
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  std::istringstream table(content_of(folder / "fem_rates.csv"));
  int rows = 0;
  for (std::string line; std::getline(table, line); ++rows) {
    std::istringstream fields(line);
    for (std::string field; std::getline(fields, field, ',');)
      EXPECT_TRUE(holds(outcome.out, field));
  }
  EXPECT_EQ(rows, 2);
}

TEST(bench, says_wrong_usage_by_its_status) {
  const Folder folder;
  const Outcome help = bench(folder, "fem --help");
  EXPECT_EQ(help.status, 0) << help.err;
  EXPECT_TRUE(holds(help.out, "--part"));
  for (const char* wrong : {"fem --no-such-option", "speed"})
    EXPECT_EQ(bench(folder, wrong).status, 2) << wrong;
}

}  // namespace
}  // namespace palpate::tools::testing_support
