// A program that dies of a signal keeps what is finished, and goes on from there.

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <set>
#include <thread>

#include "libfit/io/files/files.hpp"
#include "tests/tools/kept_run.hpp"
#include "tests/tools/stopped.hpp"

namespace palpate::tools {
namespace {

using namespace testing_support;

class Crash : public BlockRun {
 protected:
  void SetUp() override {
#ifdef __SANITIZE_ADDRESS__
    GTEST_SKIP() << "the sanitizer reports";
#endif
  }
  // Starts a run on one thread and kills it while it simulates its second experiment.
  int status_of_killed_run(const std::string& out) const {
    const auto keeps_the_first = [&] {
      if (!fs::exists(out + "/samples.h5.partial")) return false;
      std::this_thread::sleep_for(std::chrono::milliseconds(50));  // until the file is kept
      return true;
    };
    return stopped(SIGSEGV, {"run", folder / "scene.toml", "-o", out, "--jobs", "1"},
                   keeps_the_first, folder / "err");
  }
};

TEST_F(Crash, in_simulate_lets_the_next_run_go_on_to_the_same_bytes) {
  copy_kept_run(folder);
  fs::rename(folder / "out", folder / "whole");
  const std::string out = (folder / "out").string();
  const int status = status_of_killed_run(out);
  ASSERT_TRUE(WIFSIGNALED(status)) << status;
  EXPECT_EQ(WTERMSIG(status), SIGSEGV);
  const Samples kept = read_samples(out + "/samples.h5.partial");
  const std::set<std::int32_t> finished(kept.experiment.begin(), kept.experiment.end());
  EXPECT_GT(finished.size(), 0u);
  const Outcome resumed = run("out");
  EXPECT_EQ(resumed.status, 0) << resumed.err;
  EXPECT_TRUE(
      holds(resumed.said(), fmt::format("resuming: {} experiments are done", finished.size())));
  for (const char* file : {"body.h5", "samples.h5", "samples.surface.h5", "curves.h5", "model.h5",
                           "asset.palp", "reference.h5"})
    EXPECT_TRUE(content_of(folder / "out" / file) == content_of(folder / "whole" / file)) << file;
}

// METIS took the signal of the process: of six such runs two went on to their end and one crashed.
TEST_F(Crash, is_no_answer_to_sigterm_on_two_threads) {
  for (int tenths = 4; tenths < 16; ++tenths) {
    const Outcome outcome = shell(
        folder,
        fmt::format("rm -rf out; {} run scene.toml -o out --jobs 2 & sleep {}.{}; kill -TERM $!; "
                    "wait $!",
                    PALPATE_PROGRAM, tenths / 10, tenths % 10));
    EXPECT_EQ(outcome.status, 130) << tenths << "\n" << outcome.err;
  }
}

}  // namespace
}  // namespace palpate::tools
