// `palpate import` stopped by Ctrl-C in the middle.

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <chrono>
#include <thread>

#include "tests/tools/command_line.hpp"

namespace palpate::tools {
namespace {

using namespace testing_support;

constexpr int kRecordings = 1500;

// A press beyond 1 mm, 2 mm deep, its stiffness that of its number.
std::string press(int number) {
  std::string text = "t,d,F\n";
  for (int i = 0; i < 100; ++i) {
    const double travel_mm = 0.03 * i;
    text += std::to_string(0.01 * i) + "," + std::to_string(travel_mm) + "," +
            std::to_string((1 + 1e-3 * number) * std::max(0.0, travel_mm - 1) + 1e-4 * (i % 3)) +
            "\n";
  }
  return text;
}

// Runs the import and interrupts it as soon as its journal holds more than a few recordings.
int status_of_interrupted_import(const Folder& folder) {
  const std::string manifest = (folder / "manifest.toml").string(),
                    output = (folder / "samples.h5").string();
  const pid_t child = fork();
  if (child == 0) {
    const int log = open((folder / "log").c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    dup2(log, 1), dup2(log, 2);
    execl(PALPATE_PROGRAM, PALPATE_PROGRAM, "import", manifest.c_str(), "-o", output.c_str(),
          "--jobs", "1", nullptr);
    _exit(127);
  }
  const fs::path journal = folder / "samples.import.journal";
  for (int wait = 0; wait < 20000; ++wait) {
    std::error_code none;
    if (const auto bytes = fs::file_size(journal, none); !none && bytes > 20000) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  kill(child, SIGINT);
  int raw = 0;
  waitpid(child, &raw, 0);
  return WIFEXITED(raw) ? WEXITSTATUS(raw) : 1000 + WTERMSIG(raw);
}

TEST(import_interrupted, leaves_a_journal_from_which_the_same_command_gives_the_same_bytes) {
  const Folder folder;
  for (int i = 0; i < kRecordings; ++i) folder.write(std::to_string(i) + ".csv", press(i));
  folder.write("manifest.toml", R"(repeats = "keep"
[defaults]
columns = { time = "t", depth = "d", force = "F" }
units = { time = "s", position = "mm", force = "N" }
force_on = "body"
normal = [0, 0, -1]
position = [0, 0, 40]
probe = { shape = "flat", radius = "10 mm" }
[[recording]]
file = "*.csv"
)");
  EXPECT_EQ(status_of_interrupted_import(folder), 130) << content_of(folder / "log");
  EXPECT_FALSE(fs::exists(folder / "samples.h5"));
  EXPECT_NE(content_of(folder / "log").find("the same command goes on from there"),
            std::string::npos)
      << content_of(folder / "log");

  const std::string line = "import " + (folder / "manifest.toml").string() + " -o ";
  const Outcome resumed = palpate(folder, line + (folder / "samples.h5").string());
  EXPECT_EQ(resumed.status, 0) << resumed.err;
  const auto at = resumed.err.find(" of 1500 files are unchanged");
  ASSERT_NE(at, std::string::npos) << resumed.err;
  const int reused = std::stoi(resumed.err.substr(resumed.err.rfind('\n', at) + 1));
  EXPECT_GT(reused, 0);
  EXPECT_LT(reused, kRecordings);
  EXPECT_EQ(palpate(folder, line + (folder / "whole.h5").string()).status, 0);
  EXPECT_TRUE(content_of(folder / "samples.h5") == content_of(folder / "whole.h5"));
}

}  // namespace
}  // namespace palpate::tools
