// `palpate bench` as a user runs it: what it prints it writes, and it says how it is built.

#include <gtest/gtest.h>

#include <sstream>
#include <string>

#include "tests/tools/command_line.hpp"

namespace palpate::tools::testing_support {
namespace {

#ifdef PALPATE_WORKSHOP
TEST(bench_fem, writes_the_table_that_it_prints) {
  const Folder folder;
  const Outcome outcome = palpate(folder, "bench fem --part rates --quick -o .");
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

TEST(bench, hands_its_arguments_and_the_exit_status_through) {
  const Folder folder;
  const Outcome help = palpate(folder, "bench fem --help");
  EXPECT_EQ(help.status, 0) << help.err;
  EXPECT_TRUE(holds(help.out, "--part"));
  for (const char* wrong : {"bench fem --no-such-option", "bench speed"})
    EXPECT_EQ(palpate(folder, wrong).status, 2) << wrong;
}

#endif

TEST(bench, says_when_the_program_is_not_beside_palpate) {
  const Folder folder;
  fs::copy_file(PALPATE_PROGRAM, folder / "palpate");
  const Outcome tick = shell(folder, "./palpate bench tick");
  EXPECT_EQ(tick.status, 1);
  EXPECT_TRUE(holds(tick.err, "palpate: error: bench: cannot start "));
  EXPECT_TRUE(holds(tick.err, "-DPALPATE_WORKSHOP=ON"));
  const Outcome help = shell(folder, "./palpate bench --help");
  EXPECT_EQ(help.status, 0);
  EXPECT_TRUE(holds(help.out, "-DPALPATE_WORKSHOP=ON"));
}

}  // namespace
}  // namespace palpate::tools::testing_support
