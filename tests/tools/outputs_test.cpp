// What a command may write over, and what it says where the name of a command, an option or a
// folder is wrong.

#include "tools/outputs.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>

#include "libfit/assets/exporters.hpp"
#include "libfit/core/error.hpp"
#include "libfit/io/files/files.hpp"
#include "tests/support/error_of.hpp"
#include "tests/tools/block_scene.hpp"
#include "tools/scene/nearest_name.hpp"

namespace palpate::tools {
namespace {

using namespace testing_support;
using palpate::testing_support::error_of;

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

TEST(outputs, an_input_is_not_replaced_under_any_of_its_names) {
  const Folder folder;
  const fs::path samples = some_samples(folder, "samples.h5"), before = folder / "before.h5";
  fs::copy_file(samples, before);
  fs::create_symlink(samples, folder / "link.h5");
  for (const char* name : {"samples.h5", "link.h5", "./samples.h5"}) {
    const Outcome outcome = palpate(folder, std::string("fit samples.h5 -o ") + name);
    EXPECT_EQ(outcome.status, 1);
    EXPECT_TRUE(holds(outcome.err, "is also an input of this command"));
    EXPECT_EQ(content_of(samples), content_of(before));
  }
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

TEST(outputs, a_kind_of_text_is_how_it_begins) {
  const Folder folder;
  EXPECT_EQ(kind_of_file(folder.write("a.json", "{\n  \"files\": 2 }")), "{\"files\":2}");
  const fs::path page = folder.write("a.html", "<!doctype html><!-- palpate --><svg>");
  EXPECT_EQ(kind_of_file(page), "<!doctype html><!-- palpate --><svg>");
}

// What commands write beside the output that they are given, or in the folder.
struct Stranger {
  const char *file, *command;
  bool can_force;
};
constexpr Stranger kStrangers[] = {
    {"out/report.html", "run none.toml -o out", true},
    {"out/run.log", "run none.toml -o out", true},
    {"out/statement.json", "run none.toml -o out", true},
    {"s.import.json", "import none.toml -o s.h5", true},
    {"s.surface.h5", "simulate none.h5 -o s.h5", false},
    {"placed.h5", "simulate none.h5 -o s.h5", false},
    {"kept/reference.h5", "validate none.palp none.toml --reference kept", false},
    {"st/results.csv", "study none.toml -o st", false},
};

TEST(outputs, a_file_that_palpate_did_not_write_is_kept_under_every_name_that_a_command_chooses) {
  for (const Stranger& each : kStrangers) {
    const Folder folder;
    fs::create_directories((folder / each.file).parent_path());
    folder.write(each.file, "my notes\n");
    const auto say = [&](const std::string& more) { return palpate(folder, each.command + more); };
    const Outcome outcome = say("");
    EXPECT_EQ(outcome.status, 1) << each.command;
    EXPECT_TRUE(holds(outcome.err, std::string(each.file) + ": begins with \"my notes\""));
    EXPECT_EQ(content_of(folder / each.file), "my notes\n");
    if (each.can_force) {
      EXPECT_TRUE(holds(outcome.err, "--force"));
      EXPECT_TRUE(holds(say(" --force").err, "none.toml: no such file"));
    }
    folder.write(each.file, "");
    EXPECT_TRUE(holds(say("").err, "none")) << each.command;
  }
}

TEST(outputs, an_engine_is_not_written_over_files_of_another_folder) {
  const Folder folder;
  folder.write("README.md", "my notes\n");
  EXPECT_TRUE(
      holds(error_of([&] { write_engine_folder(folder.path()); }), "README.md: is there already"));
  EXPECT_EQ(content_of(folder / "README.md"), "my notes\n");
  fs::remove(folder / "README.md");
  write_engine_folder(folder.path());
  EXPECT_NO_THROW(write_engine_folder(folder.path()));
}

TEST(outputs, stdout_that_cannot_be_written_ends_with_an_error) {
  const Folder folder;
  const fs::path samples = some_samples(folder, "s.h5");
  for (const std::string command : {"--version", "--help", "fit --help", "inspect s.h5",
                                    "inspect s.h5 --json", "inspect none.h5 --json"})
    for (const auto& [where, reason] :
         {std::pair{">/dev/full", "No space left on device"}, {">&-", "Bad file descriptor"}}) {
      const Outcome outcome = palpate(folder, command + where);
      EXPECT_EQ(outcome.status, 1) << command << where;
      const bool is_missing = command.find("none") != std::string::npos;
      const std::string wanted =
          is_missing ? "none.h5: no such file"
                     : std::string("palpate: error: stdout: cannot be written: ") + reason;
      EXPECT_TRUE(holds(outcome.err, wanted)) << command;
    }
  EXPECT_EQ(palpate(folder, "inspect s.h5 --quiet >/dev/full").status, 0);
}

TEST(outputs, a_limit_of_file_size_is_an_error_and_no_signal) {
  const BlockFolder folder;
  const Outcome outcome = shell(
      folder, "ulimit -f 40 && " + std::string(PALPATE_PROGRAM) + " prepare scene.toml -o b.h5");
  EXPECT_EQ(outcome.status, 1);
  EXPECT_TRUE(holds(outcome.err, "b.h5: cannot be written: File too large"));
}

TEST(outputs, stderr_that_cannot_be_written_ends_nothing) {
  const BlockFolder folder;
  for (const std::string where : {" 2>/dev/full", " 2>&-"}) {
    EXPECT_EQ(palpate(folder, "inspect none.h5" + where).status, 1) << where;
    EXPECT_EQ(palpate(folder, "new block.off -o s.toml </dev/null" + where).status, 0) << where;
    EXPECT_TRUE(fs::remove(folder / "s.toml")) << where;
  }
}

TEST(names, a_name_far_from_all_is_not_guessed) {
  EXPECT_EQ(nearest_name("simulat", {"simulate", "tabulate"}), "simulate");
  EXPECT_EQ(nearest_name("--out", {"--output", "--jobs"}), "--output");
  EXPECT_EQ(nearest_name("detph", {"depth", "points"}), "depth");
  EXPECT_EQ(nearest_name("zzzz", {"depth", "points"}), "");
  EXPECT_EQ(suggestion("zzzz", {"depth", "points"}), "Known: depth, points.");
}

}  // namespace
}  // namespace palpate::tools
