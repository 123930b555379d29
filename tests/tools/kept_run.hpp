#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <unistd.h>

#include <fstream>
#include <string>

#include "tests/tools/block_scene.hpp"
#include "tests/tools/command_line.hpp"

namespace palpate::tools::testing_support {

/// Copies one run of the block, which all tests of all programs share, to `out` in a folder that
/// has its scene. ctest starts a process for each test: the run stays in the build folder, where
/// `palpate run` finds it up to date.
inline void copy_kept_run(const Folder& to) {
  const fs::path kept = PALPATE_RUN_DIR;
  fs::create_directories(kept);
  const int lock = open((kept / "lock").c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0644);
  ASSERT_EQ(flock(lock, LOCK_EX), 0);
  std::ofstream(kept / "scene.toml") << kScene;
  std::ofstream(kept / "block.off") << block_off(8);
  const Outcome run = palpate(
      to, "run " + (kept / "scene.toml").string() + " --jobs 2 -o " + (kept / "out").string());
  if (run.status == 0) fs::copy(kept / "out", to / "out", fs::copy_options::recursive);
  close(lock);
  ASSERT_EQ(run.status, 0) << run.err;
}

/// A suite on that run.
class KeptRun : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new Folder;
    copy_kept_run(*folder_);
  }
  static void TearDownTestSuite() { delete folder_; }

  static std::string path(const std::string& name) { return (*folder_ / name).string(); }

  static Folder* folder_;
};
inline Folder* KeptRun::folder_ = nullptr;

}  // namespace palpate::tools::testing_support
