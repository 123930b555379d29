// `palpate import` stopped by Ctrl-C in the middle.

#include <gtest/gtest.h>

#include "tests/tools/stopped.hpp"

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
  const fs::path journal = folder / "samples.import.journal";
  return exit_status(stopped(
      SIGINT, {"import", folder / "manifest.toml", "-o", folder / "samples.h5", "--jobs", "1"},
      [&] {
        std::error_code none;
        const auto bytes = fs::file_size(journal, none);
        return !none && bytes > 20000;
      },
      folder / "log"));
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
