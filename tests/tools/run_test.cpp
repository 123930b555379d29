// The whole way on a small block: made once, then up to date, then redone only where it changed.

#include <gtest/gtest.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <regex>
#include <string>
#include <thread>
#include <vector>

#include "libfit/assets/asset_file.hpp"
#include "libfit/core/experiments.hpp"
#include "libfit/experiments/follow.hpp"
#include "libfit/io/files/files.hpp"
#include "tests/tools/kept_run.hpp"
#include "tests/tools/stopped.hpp"

namespace palpate::tools {
namespace {

using namespace testing_support;

class Run : public BlockRun {};

const char* const kFiles[] = {"body.h5",  "samples.h5", "samples.surface.h5", "curves.h5",
                              "model.h5", "asset.palp", "validation.csv"};

// Its console once had ninety lines.
TEST_F(Run, makes_everything_once_in_six_lines_then_only_what_changed) {
  const Outcome first = run("out");
  ASSERT_EQ(first.status, 0) << first.err;
  EXPECT_TRUE(std::regex_match(first.err, std::regex("prepare +([^\\n]+ s|no time)\\n"
                                                     "simulate +([^\\n]+ s|no time)\\n"
                                                     "fit, refine, export +([^\\n]+ s|no time)\\n"
                                                     "validate +([^\\n]+ s|no time)\\n")))
      << first.err;
  EXPECT_TRUE(std::regex_match(
      first.out, std::regex("(Good|Fair|Poor)( (or|to) (good|fair))?: [^\\n]+\\nnext: "
                            "[^\\n]*report[^\\n]*\\n")))
      << first.out;
  EXPECT_TRUE(first.log.starts_with("palpate run ")) << first.log;
  for (const char* note : {"held: ", "  family ", "  residual: ", "a person would not notice"})
    EXPECT_TRUE(holds(first.log, note));
  for (const char* file : kFiles) EXPECT_TRUE(fs::exists(folder / "out" / file)) << file;
  EXPECT_TRUE(holds(first.log, "force error at 2 held-out contact points"));
  const auto statement = nlohmann::json::parse(content_of(folder / "out" / "statement.json"));
  EXPECT_LT(statement.at("force_error").at("median_rel").get<double>(), 0.25);
  EXPECT_GT(statement.at("asset_bytes").get<double>(), 1000);

  const Outcome second = run("out", "-v");
  EXPECT_EQ(second.status, 0) << second.err;
  EXPECT_TRUE(holds(second.err, "nothing to do"));
  EXPECT_TRUE(holds(second.log, "nothing to do")) << "is added";
  EXPECT_EQ(second.out, first.out);

  folder.write("scene.toml", replaced(kScene, "tolerance = 0.02", "tolerance = 0.05\npieces = 1"));
  const Outcome third = run("out");
  EXPECT_EQ(third.status, 0) << third.err;
  EXPECT_TRUE(holds(third.said(), "samples.h5 is up to date"));
  EXPECT_FALSE(holds(third.said(), "curves.h5 is up to date"));
}

TEST_F(Run, a_warning_is_on_stderr_and_in_the_log) {
  folder.write("scene.toml", replaced(kScene, "10 kPa", "10 GPa"));
  const Outcome outcome = run("out");
  const std::size_t at = outcome.err.find("  warning: ");
  ASSERT_NE(at, std::string::npos) << outcome.err;
  const std::string warning = outcome.err.substr(at, outcome.err.find('\n', at) - at);
  EXPECT_TRUE(holds(outcome.log, warning));
  EXPECT_EQ(outcome.err.find(warning, at + 1), std::string::npos) << "once: " << outcome.err;
}

// Of a body whose forces no hand feels it said 0.0 / 0.0 / 0.0 %, 100 % of rows within JND.
TEST_F(Run, a_body_too_soft_to_be_felt_has_an_error_and_no_share_within_jnd) {
  folder.write("scene.toml", replaced(kScene, "10 kPa", "200 Pa"));
  const Outcome outcome = run("out", "--quick");
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const auto statement = nlohmann::json::parse(content_of(folder / "out" / "statement.json"));
  EXPECT_GT(statement.at("force_error").at("p95_rel").get<double>(), 0.001);
  EXPECT_TRUE(statement.at("force_error").at("within_jnd").is_null());
  EXPECT_LT(statement.at("floor_N").get<double>(), 0.002);
  EXPECT_GT(statement.at("rows_above_floor").get<int>(), 3);
  for (const auto& [name, figures] : statement.at("by_path").items())
    EXPECT_NE(figures.at("p95_rel"), 0.0) << name;
  const std::string table = outcome.log.substr(outcome.log.find("force error at"));
  EXPECT_FALSE(holds(table, " 0.0 %"));
  EXPECT_TRUE(holds(table, "no force reaches 40 mN"));
  EXPECT_TRUE(holds(table, "on this machine"));
}

TEST_F(Run, a_comment_or_another_spelling_changes_nothing) {
  copy_kept_run(folder);
  folder.write("scene.toml", "# said differently\n" + replaced(kScene, "\"10 kPa\"", "10000.0"));
  EXPECT_TRUE(holds(run("out").said(), "nothing to do"));
}

TEST_F(Run, one_and_two_threads_make_the_same_bytes) {
  copy_kept_run(folder);
  ASSERT_EQ(run("one", "--jobs 1").status, 0);
  for (const char* file : kFiles)
    EXPECT_TRUE(content_of(folder / "one" / file) == content_of(folder / "out" / file)) << file;
}

TEST_F(Run, a_damaged_file_is_noticed_and_made_again) {
  copy_kept_run(folder);
  const std::string samples = content_of(folder / "out" / "samples.h5");
  folder.write("out/samples.h5", samples.substr(0, samples.size() / 2));
  const Outcome again = run("out");
  EXPECT_EQ(again.status, 0) << again.err;
  EXPECT_TRUE(content_of(folder / "out" / "samples.h5") == samples);
}

TEST_F(Run, an_interrupted_simulate_keeps_what_is_done_and_resumes_to_the_same_bytes) {
  ASSERT_EQ(palpate(folder, "prepare scene.toml -o body.h5").status, 0);
  copy_kept_run(folder);
  const fs::path partial = folder / "cut.h5.partial";
  const std::string cut = (folder / "cut.h5").string();
  const int raw = stopped(SIGINT, {"simulate", folder / "body.h5", "--jobs", "1", "-o", cut},
                          [&] { return fs::exists(partial); });
  if (exit_status(raw) == 0) GTEST_SKIP() << "it finished before the interrupt";
  EXPECT_EQ(exit_status(raw), 130);
  EXPECT_FALSE(fs::exists(cut));
  const Outcome resumed = palpate(folder, "simulate body.h5 --jobs 1 --resume -o " + cut);
  EXPECT_EQ(resumed.status, 0) << resumed.err;
  EXPECT_TRUE(holds(resumed.said(), "resuming"));
  EXPECT_TRUE(content_of(cut) == content_of(folder / "out/samples.h5"));
  EXPECT_TRUE(content_of(folder / "cut.surface.h5") ==
              content_of(folder / "out/samples.surface.h5"));
  EXPECT_FALSE(fs::exists(partial));
}

// Once a reference of another tolerance was taken for what the scene asks for now.
TEST_F(Run, a_reference_of_another_tolerance_is_simulated_anew) {
  const auto run_with = [&](const std::string& tolerance) {
    folder.write("scene.toml", replaced(kScene, "points = 2", "points = 1") +
                                   "force_tolerance = " + tolerance + "\n");
    return run("out");
  };
  ASSERT_EQ(run_with("0.5").status, 0);
  const Outcome second = run_with("0.4");
  ASSERT_EQ(second.status, 0) << second.err;
  EXPECT_FALSE(holds(second.said(), "need not be simulated again"));
}

// Starts a command, sends it a signal once its messages hold `begun`, and expects it to end with
// status 130 within half a second.
void expect_end_at_signal(const Folder& folder, const std::vector<std::string>& words, int signal,
                          const std::string& begun) {
  const fs::path log = folder.write("messages", "");
  std::chrono::steady_clock::time_point sent;
  const auto is_under_way = [&] {
    if (content_of(log).find(begun) == std::string::npos) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
    sent = std::chrono::steady_clock::now();
    return true;
  };
  const int raw = stopped(signal, words, is_under_way, log);
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - sent;
  EXPECT_EQ(exit_status(raw), 130) << content_of(log);
  EXPECT_LT(took.count(), 0.5) << "s";
}

// It used to notice only between its steps, and meshers run for seconds.
TEST_F(Run, prepare_ends_at_once_when_it_is_told_to_and_writes_nothing) {
  folder.write("scene.toml", replaced(kScene, "\"20 mm\"", "\"1 mm\""));
  for (const int signal : {SIGTERM, SIGINT}) {
    const fs::path out = folder / "body.h5";
    expect_end_at_signal(folder, {"prepare", folder / "scene.toml", "-o", out}, signal,
                         "surface: ");
    EXPECT_FALSE(fs::exists(out));
  }
}

// On a scan of a hand it went on for up to 13 s.
TEST_F(Run, check_ends_at_once_in_its_trial_and_says_when_that_begins) {
  folder.write("scene.toml", replaced(kScene, "press_steps = 5", "press_steps = 400"));
  for (const int signal : {SIGTERM, SIGINT})
    expect_end_at_signal(folder, {"check", folder / "scene.toml"}, signal, "trial at ");
}

}  // namespace
}  // namespace palpate::tools
