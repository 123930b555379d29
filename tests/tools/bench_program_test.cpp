// `palpate bench` as a user runs it: what it prints it writes, and it says what it lacks.

#include <gtest/gtest.h>

#include <sstream>
#include <string>

#include "tests/tools/command_line.hpp"

namespace palpate::tools::testing_support {
namespace {

// Every instruction set gives the same bits (kernels_test.cpp); one double at a time adds the
// forces of a node's cells in another order.
TEST(bench_fem, eight_cells_at_a_time_give_the_forces_of_one_double_at_a_time) {
  const Folder folder;
  const Outcome outcome =
      palpate(folder, "bench fem --part assembly --quick -o " + folder.path().string());
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  std::istringstream table(content_of(folder / "fem_assembly.csv"));
  std::string line;
  std::getline(table, line);
  EXPECT_EQ(line.substr(0, 8), "kernels,");
  int rows = 0;
  for (; std::getline(table, line); ++rows)
    EXPECT_LT(std::stod(line.substr(line.rfind(',') + 1)), 1e-15) << line;
  EXPECT_GE(rows, 2);
  EXPECT_NE(outcome.out.find("one double at a time"), std::string::npos);
}

TEST(bench_fem, an_unknown_part_is_named_with_those_there_are) {
  const Folder folder;
  const Outcome outcome = palpate(folder, "bench fem --part speed -o " + folder.path().string());
  EXPECT_EQ(outcome.status, 1);
  EXPECT_NE(outcome.err.find("there is no part called speed"), std::string::npos);
  EXPECT_NE(outcome.err.find("assembly"), std::string::npos);
}

TEST(bench_curves, wants_samples_and_says_how) {
  const Folder folder;
  const Outcome outcome = palpate(folder, "bench curves -o " + folder.path().string());
  EXPECT_EQ(outcome.status, 1);
  EXPECT_NE(outcome.err.find("there are no samples to fit"), std::string::npos) << outcome.err;
  EXPECT_NE(outcome.err.find("--samples samples.h5"), std::string::npos) << outcome.err;
}

TEST(bench, hands_its_arguments_and_the_exit_status_through) {
  const Folder folder;
  const Outcome help = palpate(folder, "bench fem --help");
  EXPECT_EQ(help.status, 0) << help.err;
  EXPECT_NE(help.out.find("--part"), std::string::npos) << help.out;
  for (const char* wrong : {"bench fem --no-such-option", "bench speed"})
    EXPECT_EQ(palpate(folder, wrong).status, 2) << wrong;
}

TEST(bench, says_when_the_program_is_not_beside_palpate) {
  const Folder folder;
  fs::copy_file(PALPATE_PROGRAM, folder / "palpate");
  const int raw = std::system(
      ((folder / "palpate").string() + " bench tick 2>" + (folder / "err").string()).c_str());
  EXPECT_EQ(WEXITSTATUS(raw), 1);
  const std::string err = content_of(folder / "err");
  EXPECT_NE(err.find("palpate: error: bench: cannot start "), std::string::npos) << err;
  EXPECT_NE(err.find("Build the target palpate_bench"), std::string::npos) << err;
}

}  // namespace
}  // namespace palpate::tools::testing_support
