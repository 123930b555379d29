// A program that dies of a signal says where, keeps what is finished, and goes on from there.

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <regex>
#include <set>
#include <thread>

#include "libfit/io/files/files.hpp"
#include "tests/tools/kept_run.hpp"
#include "tests/tools/stopped.hpp"
#include "tools/console.hpp"

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

TEST_F(Crash, in_simulate_names_the_point_and_the_next_run_goes_on_to_the_same_bytes) {
  copy_kept_run(folder);
  fs::rename(folder / "out", folder / "whole");
  const std::string out = (folder / "out").string();
  const int status = status_of_killed_run(out);
  ASSERT_TRUE(WIFSIGNALED(status)) << status;
  EXPECT_EQ(WTERMSIG(status), SIGSEGV);
  const std::string err = content_of(folder / "err");
  const std::regex line(
      "prepare[^\n]*\npalpate: crashed \\(SIGSEGV\\) in simulate, press at "
      "p[0-9]+: please send " +
      out + "\\.crash\\.txt and what the command reads; what is finished is kept\n");
  EXPECT_TRUE(std::regex_match(err, line)) << err;
  const std::string report = content_of(out + ".crash.txt");
  const std::string version = shell(folder, std::string(PALPATE_PROGRAM) + " --version").out;
  for (const std::string& part :
       {std::string("(SIGSEGV) in simulate, press at p"), "build: " + version.substr(8, 5),
        "command: palpate run " + (folder / "scene.toml").string() + " -o " + out + " --jobs 1",
        std::string("system: PRETTY_NAME="), std::string("processor:\nprocessor\t: 0\n"),
        std::string("stack:\n"), std::string("(+0x")})
    EXPECT_TRUE(holds(report, part));

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

[[noreturn]] void die_of(int signal, const std::string& output) {
  report_crashes("a test's");
  set_crash_file(output);
  set_stage("fit");
  std::thread other([] {
    set_item("p0001");
    for (;;) ::pause();
  });
  std::thread([signal] {
    set_item("p0002");
    std::raise(signal);
  }).join();
  std::_Exit(1);
}

using CrashDeathTest = Crash;

TEST_F(CrashDeathTest, of_any_signal_ends_with_it_and_names_the_point_of_the_thread_that_died) {
  for (const auto& [signal, name] : {std::pair(SIGSEGV, "SIGSEGV"),
                                     {SIGILL, "SIGILL"},
                                     {SIGBUS, "SIGBUS"},
                                     {SIGFPE, "SIGFPE"},
                                     {SIGABRT, "SIGABRT"}})
    EXPECT_EXIT(die_of(signal, (folder / "out/").string()), testing::KilledBySignal(signal),
                fmt::format("crashed .{}. in fit, p0002: please send [^ ]*/out.crash.txt", name));
}

TEST_F(CrashDeathTest, without_a_file_to_write_says_all_on_stderr) {
  EXPECT_EXIT(die_of(SIGSEGV, "/nowhere/out"), testing::KilledBySignal(SIGSEGV),
              "please send all of this.*\nbuild: a test's\n.*stack:\n");
}

int recurse(int depth) {
  volatile char bytes[4096];
  bytes[0] = static_cast<char>(depth);
  return depth < 0 ? 0 : recurse(depth + 1) + bytes[0];
}

TEST_F(CrashDeathTest, of_a_stack_that_overflows_is_reported) {
  const auto overflow = [&] {
    report_crashes("a test's");
    set_crash_file((folder / "out").string());
    std::_Exit(recurse(0));
  };
  EXPECT_EXIT(overflow(), testing::KilledBySignal(SIGSEGV), "crashed .SIGSEGV. in the command");
}

}  // namespace
}  // namespace palpate::tools
