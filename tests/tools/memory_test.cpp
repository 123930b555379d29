// With little memory every command ends, and says what it lacks.

#include <gtest/gtest.h>

#include "tests/tools/block_scene.hpp"

namespace palpate::tools {
namespace {

using namespace testing_support;

struct Memory : testing::Test {
  // Within `limit_KB` of address space; 124 where it had to be killed.
  Outcome within(int limit_KB, const std::string& arguments) const {
    return shell(folder, "ulimit -v " + std::to_string(limit_KB) + " && timeout -k 1 60 " +
                             std::string(PALPATE_PROGRAM) + " " + arguments);
  }
  BlockFolder folder;
};

// A BLAS with a thread pool took 128 MB for each core when it was loaded, or span for ever.
TEST_F(Memory, that_loads_the_program_is_enough_for_small_commands) {
  EXPECT_EQ(within(100'000, "--version").status, 0);
  EXPECT_EQ(within(100'000, "--help").status, 0);
  EXPECT_EQ(within(200'000, "new block.off -o new.toml </dev/null").status, 0);
}

TEST_F(Memory, that_is_too_little_is_an_error_and_no_hang) {
  int errors = 0, done = 0;
  for (const int limit_KB : {100'000, 150'000, 200'000, 250'000, 400'000, 2'000'000}) {
    const Outcome outcome = within(limit_KB, "check scene.toml --jobs 1");
    const bool is_done = outcome.status == 0;
    ++(is_done ? done : errors);
    if (is_done) continue;
    EXPECT_EQ(outcome.status, 1) << limit_KB << "\n" << outcome.err;
    EXPECT_TRUE(holds(outcome.err, "palpate: error: memory: there is not enough of it"))
        << limit_KB;
  }
  EXPECT_GT(errors, 0);
  EXPECT_GT(done, 0);
}

}  // namespace
}  // namespace palpate::tools
