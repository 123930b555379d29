// What a command may write over, and what it says where the name of a command, an option or a
// folder is wrong.

#include "tools/outputs.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>

#include "libfit/core/error.hpp"
#include "libfit/io/files/samples_file.hpp"
#include "tests/tools/block_scene.hpp"
#include "tools/scene/nearest_name.hpp"

namespace palpate::tools {
namespace {

using namespace testing_support;

constexpr std::string_view kSamplesOnly[] = {"palpate-samples"};

fs::path some_samples(const Folder& folder, const std::string& name) {
  Samples samples;
  write_samples(folder / name, samples, {});
  return folder / name;
}

TEST(outputs, a_file_is_told_by_its_first_bytes) {
  const Folder folder;
  EXPECT_EQ(kind_of_file(some_samples(folder, "a.h5")), "palpate-samples");
  EXPECT_EQ(kind_of_file(folder.write("a.csv", "t_s,fx_N\n0,1\n")), "t_s,fx_N");
  EXPECT_EQ(kind_of_file(folder.write("a.palp", "PALP....")), "palp");
  EXPECT_EQ(kind_of_file(folder.write("empty", "")), "");
  EXPECT_EQ(kind_of_file(folder / "missing"), "");
}

TEST(outputs, a_file_of_the_kind_that_is_written_and_an_empty_one_may_be_replaced) {
  const Folder folder;
  EXPECT_NO_THROW(check_output(some_samples(folder, "a.h5"), kSamplesOnly, {}));
  EXPECT_NO_THROW(check_output(folder.write("empty.h5", ""), kSamplesOnly, {}));
  EXPECT_NO_THROW(check_output(folder / "missing.h5", kSamplesOnly, {}));
}

TEST(outputs, a_file_of_another_kind_is_kept) {
  const Folder folder;
  const fs::path scene = folder.write("scene.toml", kScene);
  EXPECT_THROW(check_output(scene, kSamplesOnly, {}), Error);
}

TEST(outputs, an_input_is_not_replaced_under_any_of_its_names) {
  const Folder folder;
  const fs::path samples = some_samples(folder, "samples.h5"), before = folder / "before.h5";
  fs::copy_file(samples, before);
  fs::create_symlink(samples, folder / "link.h5");
  for (const char* name : {"samples.h5", "link.h5", "./samples.h5"}) {
    const Outcome outcome =
        palpate(folder, "fit " + samples.string() + " -o " + (folder / name).string());
    EXPECT_EQ(outcome.status, 1);
    EXPECT_NE(outcome.err.find("is also an input of this command"), std::string::npos)
        << outcome.err;
    EXPECT_EQ(content_of(samples), content_of(before));
  }
}

TEST(outputs, a_folder_of_a_run_that_is_a_file_is_named_before_any_work) {
  const Folder folder;
  folder.write("block.off", block_off(8));
  const fs::path scene = folder.write("scene.toml", kScene);
  const Outcome outcome = palpate(folder, "run " + scene.string() + " -o " + scene.string());
  EXPECT_EQ(outcome.status, 1);
  EXPECT_NE(outcome.err.find("is a file, so no folder can be made there"), std::string::npos)
      << outcome.err;
  EXPECT_EQ(outcome.err.find("prepare"), std::string::npos) << outcome.err;
  EXPECT_EQ(content_of(scene), kScene);
}

TEST(outputs, a_second_run_in_the_same_folder_is_refused_while_the_first_lives) {
  const Folder folder;
  {
    OutputFolder first(folder / "out");
    first.claim();
    OutputFolder second(folder / "out");
    EXPECT_THROW(second.claim(), Error);
  }
  OutputFolder third(folder / "out");
  EXPECT_NO_THROW(third.claim());
}

TEST(outputs, a_disk_that_takes_no_more_is_named_as_the_reason) {
  const Folder folder;
  rlimit before;
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit tiny{4096, before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &tiny), 0);
  std::string message;
  try {
    some_samples(folder, "s.h5");
  } catch (const Error& e) {
    message = e.what();
  }
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_NE(message.find("s.h5: cannot be written: File too large"), std::string::npos) << message;
  EXPECT_FALSE(fs::exists(folder / "s.h5"));
}

TEST(outputs, an_asset_of_another_body_is_not_validated) {
  const Folder folder;
  folder.write("block.off", block_off(8));
  const fs::path scene = folder.write("scene.toml", kScene);
  std::string other = kScene;
  other.replace(other.find("block.off"), 9, "other.off");
  folder.write("other.off", block_off(9));
  const fs::path another = folder.write("another.toml", other);
  ASSERT_NE(palpate(folder, "run " + scene.string() + " -o " + (folder / "out").string()).status,
            1);
  const Outcome outcome =
      palpate(folder, "validate " + (folder / "out/asset.palp").string() + " " + another.string());
  EXPECT_EQ(outcome.status, 1);
  EXPECT_NE(outcome.err.find("was made on another surface than the scene's"), std::string::npos)
      << outcome.err;
}

TEST(names, a_name_far_from_all_is_not_guessed) {
  EXPECT_EQ(nearest_name("simulat", {"simulate", "tabulate"}), "simulate");
  EXPECT_EQ(nearest_name("--out", {"--output", "--jobs"}), "--output");
  EXPECT_EQ(nearest_name("detph", {"depth", "points"}), "depth");
  EXPECT_EQ(nearest_name("zzzz", {"depth", "points"}), "");
  EXPECT_EQ(suggestion("zzzz", {"depth", "points"}), "Known: depth, points.");
}

TEST(names, a_misspelt_command_or_option_is_answered_with_the_right_one) {
  const Folder folder;
  const auto says = [&](const std::string& line, const std::string& answer) {
    const Outcome outcome = palpate(folder, line);
    EXPECT_EQ(outcome.status, 2) << line;
    EXPECT_NE(outcome.err.find(answer), std::string::npos) << line << "\n" << outcome.err;
  };
  says("simulat scene.toml", "Did you mean \"simulate\"?");
  says("fit samples.h5 --out curves.h5", "Did you mean \"--output\"?");
  says("", "Write curves as a table");
}

}  // namespace
}  // namespace palpate::tools
