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
  const Outcome outcome =
      palpate(folder, "bench fem --part rates --quick -o " + folder.path().string());
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  std::istringstream table(content_of(folder / "fem_rates.csv"));
  int rows = 0;
  for (std::string line; std::getline(table, line); ++rows) {
    std::istringstream fields(line);
    for (std::string field; std::getline(fields, field, ',');)
      EXPECT_NE(outcome.out.find(field), std::string::npos) << field;
  }
  EXPECT_EQ(rows, 2);
}

TEST(bench_fem, an_unknown_part_is_named_with_those_there_are) {
  const Folder folder;
  const Outcome outcome = palpate(folder, "bench fem --part haste -o " + folder.path().string());
  EXPECT_EQ(outcome.status, 1);
  EXPECT_NE(outcome.err.find("there is no part called haste"), std::string::npos);
  EXPECT_NE(outcome.err.find("ripple"), std::string::npos);
}

TEST(bench_laws, wants_the_reference_of_a_run_and_says_how) {
  const Folder folder;
  const Outcome outcome = palpate(folder, "bench laws -o " + folder.path().string());
  EXPECT_EQ(outcome.status, 1);
  EXPECT_NE(outcome.err.find("needs reference.h5 of a run"), std::string::npos) << outcome.err;
  EXPECT_NE(outcome.err.find("--samples RUN/reference.h5"), std::string::npos) << outcome.err;
}

TEST(bench_rivals, wants_a_run_and_a_rival_that_there_is) {
  const Folder folder;
  const std::string output = " -o " + folder.path().string();
  const Outcome no_run = palpate(folder, "bench rivals" + output);
  EXPECT_EQ(no_run.status, 1);
  EXPECT_NE(no_run.err.find("there is no run to compare on"), std::string::npos) << no_run.err;
  EXPECT_NE(no_run.err.find("give --run DIR"), std::string::npos) << no_run.err;
  const Outcome no_rival = palpate(folder, "bench rivals --part magic" + output);
  EXPECT_EQ(no_rival.status, 1);
  EXPECT_NE(no_rival.err.find("there is no rival called magic"), std::string::npos);
  EXPECT_NE(no_rival.err.find("corotational"), std::string::npos) << no_rival.err;
}

TEST(bench, hands_its_arguments_and_the_exit_status_through) {
  const Folder folder;
  const Outcome help = palpate(folder, "bench fem --help");
  EXPECT_EQ(help.status, 0) << help.err;
  EXPECT_NE(help.out.find("--part"), std::string::npos) << help.out;
  for (const char* wrong : {"bench fem --no-such-option", "bench speed"})
    EXPECT_EQ(palpate(folder, wrong).status, 2) << wrong;
}

#endif

TEST(bench, says_when_the_program_is_not_beside_palpate) {
  const Folder folder;
  fs::copy_file(PALPATE_PROGRAM, folder / "palpate");
  const int raw = std::system(
      ((folder / "palpate").string() + " bench tick 2>" + (folder / "err").string()).c_str());
  EXPECT_EQ(WEXITSTATUS(raw), 1);
  const std::string err = content_of(folder / "err");
  EXPECT_NE(err.find("palpate: error: bench: cannot start "), std::string::npos) << err;
  EXPECT_NE(err.find("-DPALPATE_WORKSHOP=ON"), std::string::npos) << err;
  const std::string out = (folder / "out").string();
  EXPECT_EQ(std::system(((folder / "palpate").string() + " bench --help >" + out).c_str()), 0);
  EXPECT_NE(content_of(out).find("-DPALPATE_WORKSHOP=ON"), std::string::npos);
}

}  // namespace
}  // namespace palpate::tools::testing_support
