// Test points simulated by several processes: how they are dealt, what merging refuses, and what is
// left when one of them is killed, runs out of disk or meets another.

#include "tools/stages/samples/shards.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "libfit/core/error.hpp"
#include "libfit/io/files/files.hpp"
#include "tests/tools/block_scene.hpp"
#include "tests/tools/stopped.hpp"
#include "tools/outputs.hpp"

namespace palpate::tools {
namespace {

using namespace testing_support;

TEST(shards, every_experiment_goes_to_one_shard_and_shards_are_equally_long) {
  fem::Experiments each;
  each.drag_depths_m = {0.001, 0.002};
  ExperimentList list;
  for (int p = 0; p < 53; ++p)
    list.experiments.push_back({ExperimentKind::press, p, {p % 7 == 0, p % 3 == 0 ? 0.98 : 0}, {}});
  for (int p = 0; p < 7; ++p)
    list.experiments.push_back({ExperimentKind::pair, p, {}, {p, Points::Zero(8, 3)}});
  for (const int count : {1, 2, 5, 70}) {
    std::vector<int> times(list.size(), 0);
    std::vector<double> load;
    for (int number = 1; number <= count; ++number) {
      load.push_back(0);
      for (const std::size_t i : dealt_to({number, count}, list, each)) {
        ++times[i];
        load.back() += cost_of(list.experiments[i], each);
      }
    }
    EXPECT_EQ(times, std::vector<int>(times.size(), 1)) << count;
    // Graham's bound: the longest exceeds the shortest by no more than one point's.
    const auto [least, most] = std::minmax_element(load.begin(), load.end());
    EXPECT_LE(*most - *least, cost_of({ExperimentKind::press, 0, {true, 0}, {}}, each)) << count;
    const double mean = std::accumulate(load.begin(), load.end(), 0.0) / count;
    EXPECT_LT(*most, count <= 5 ? 1.05 * mean : 1e9) << count;
  }
}

TEST(shards, a_shard_that_is_none_is_refused) {
  for (const char* text : {"", "3", "0/4", "5/4", "a/b", "1/4x", "-1/4", "1 /4"})
    EXPECT_THROW(parse_shard(text), Error) << text;
  EXPECT_EQ(parse_shard("3/8").number, 3);
}

// Five points, a press of one step each; all tests look at the three shards of one folder.
class SharedFolder : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    made = std::make_unique<BlockFolder>(scene("0.45"));
    made->write("other.toml", scene("0.4"));
    ASSERT_EQ(palpate(*made, "prepare scene.toml -o body.h5").status, 0);
    ASSERT_EQ(palpate(*made, "simulate body.h5 -o one.h5").status, 0);
    for (const char* number : {"1", "2", "3"}) {
      const Outcome outcome = simulate(number, "3", "shards");
      ASSERT_EQ(outcome.status, 0) << outcome.err;
    }
  }
  static void TearDownTestSuite() { made.reset(); }
  static std::string scene(const std::string& poisson) {
    std::string text = replaced(kScene, "test_points = 4", "test_points = 5");
    text = replaced(text, "drag_depths = [\"3 mm\"]", "drag_depths = []");
    text = replaced(text, "press_steps = 5", "press_steps = 1");
    return replaced(text, "poisson = 0.45", "poisson = " + poisson);
  }
  static std::string in(const std::string& name) { return (*made / name).string(); }
  static Outcome simulate(const std::string& number, const std::string& count,
                          const std::string& folder, const std::string& from = "scene.toml") {
    return palpate(
        *made, "simulate " + from + " --jobs 1 --shard " + number + "/" + count + " -o " + folder);
  }
  // A copy of the shards to do something to.
  std::string copied() {
    const std::string name = testing::UnitTest::GetInstance()->current_test_info()->name();
    fs::copy(*made / "shards", *made / name);
    return name;
  }
  static Outcome merge(const std::string& folder) {
    return palpate(*made, "merge " + folder + " -o " + folder + "/samples.h5");
  }
  static void expect_same_as_one(const std::string& folder) {
    const Outcome merged = merge(folder);
    ASSERT_EQ(merged.status, 0) << merged.err;
    EXPECT_TRUE(content_of(*made / folder / "samples.h5") == content_of(*made / "one.h5"));
    EXPECT_TRUE(content_of(*made / folder / "samples.surface.h5") ==
                content_of(*made / "one.surface.h5"));
  }
  static void expect_refused(const Outcome& outcome, const std::string& what,
                             const std::string& remedy) {
    EXPECT_EQ(outcome.status, 1) << outcome.err;
    EXPECT_TRUE(holds(outcome.err, what));
    EXPECT_TRUE(holds(outcome.err, remedy));
  }
  static std::unique_ptr<Folder> made;
};
std::unique_ptr<Folder> SharedFolder::made;

TEST_F(SharedFolder, merged_shards_have_the_bytes_of_one_process) {
  const std::string folder = copied();
  expect_same_as_one(folder);
  EXPECT_FALSE(fs::exists(*made / folder / "shard-1-of-3.h5"));
  const Outcome again = merge(folder);
  EXPECT_EQ(again.status, 0) << again.err;
  EXPECT_TRUE(holds(again.err, "is up to date"));
}

TEST_F(SharedFolder, a_shard_that_is_done_is_not_simulated_again) {
  const Outcome outcome = simulate("2", "3", "shards");
  EXPECT_EQ(outcome.status, 0);
  EXPECT_TRUE(holds(outcome.err, "shard-2-of-3.h5 is up to date"));
}

TEST_F(SharedFolder, more_shards_than_points_are_merged) {
  for (const char* number : {"1", "2", "3", "4", "5", "6"})
    ASSERT_EQ(simulate(number, "6", "six", "body.h5").status, 0);
  expect_same_as_one("six");
}

TEST_F(SharedFolder, missing_shards_are_named) {
  const std::string folder = copied();
  fs::remove(*made / folder / "shard-2-of-3.h5");
  expect_refused(merge(folder), "lacks 1 of 3 shards: 2/3", "--shard 2/3 -o " + folder);
  ASSERT_EQ(simulate("2", "3", folder).status, 0);
  expect_same_as_one(folder);
}

TEST_F(SharedFolder, shards_of_two_counts_are_refused) {
  const std::string folder = copied();
  fs::copy(*made / folder / "shard-1-of-3.h5", *made / folder / "shard-1-of-4.h5");
  expect_refused(merge(folder), "shards of 3 and of 4", "Delete those of one");
}

TEST_F(SharedFolder, a_shard_under_another_name_is_refused_so_that_no_point_comes_twice) {
  const std::string folder = copied();
  fs::copy(*made / folder / "shard-1-of-3.h5", *made / folder / "shard-2-of-3.h5",
           fs::copy_options::overwrite_existing);
  expect_refused(merge(folder), "is another shard than its name says", "--shard 2/3");
}

TEST_F(SharedFolder, shards_of_another_scene_are_refused_by_both_commands) {
  const std::string folder = copied();
  expect_refused(simulate("1", "3", folder, "other.toml"), "holds shards of another scene",
                 "Choose another folder");
  ASSERT_EQ(simulate("1", "3", "other", "other.toml").status, 0);
  fs::copy(*made / "other" / "shard-1-of-3.h5", *made / folder / "shard-1-of-3.h5",
           fs::copy_options::overwrite_existing);
  expect_refused(merge(folder), "was simulated from another scene", "--shard 1/3");
}

TEST_F(SharedFolder, a_shard_of_another_version_is_refused) {
  const std::string folder = copied();
  const fs::path path = *made / folder / "shard-3-of-3.h5";
  Attributes attributes = read_attributes(path);
  attributes.at("program_hash").back() ^= 1;
  write_samples(path, read_samples(path), attributes);
  expect_refused(merge(folder), "another version of palpate", "--shard 3/3");
}

TEST_F(SharedFolder, a_shard_that_lost_a_point_is_refused) {
  const std::string folder = copied();
  const fs::path path = *made / folder / "shard-1-of-3.h5",
                 fewer = *made / folder / "shard-3-of-3.h5";
  write_samples(path, read_samples(fewer), read_attributes(path));
  expect_refused(merge(folder), "does not hold the experiments of its shard", "--shard 1/3");
}

TEST_F(SharedFolder,
       a_killed_shard_goes_on_with_what_was_finished_and_its_stale_lock_locks_nothing) {
  const fs::path partial = *made / "killed" / "shard-1-of-1.h5.partial";
  const int status = stopped(
      SIGKILL,
      {"simulate", in("body.h5"), "--jobs", "1", "--shard", "1/1", "-o", in("killed"), "--quiet"},
      [&] { return fs::exists(partial); });
  ASSERT_TRUE(WIFSIGNALED(status));
  ASSERT_TRUE(fs::exists(*made / "killed" / "shard-1-of-1.h5.lock"));
  expect_refused(merge("killed"), "holds no shard of this round", "--shard 1/1");
  const Outcome resumed = simulate("1", "1", "killed", "body.h5");
  ASSERT_EQ(resumed.status, 0) << resumed.err;
  EXPECT_TRUE(holds(resumed.err, "resuming: "));
  expect_same_as_one("killed");
}

TEST_F(SharedFolder, two_writers_of_one_shard_do_not_meet) {
  const std::string folder = copied();
  const fs::path path = *made / folder / "shard-2-of-3.h5";
  fs::remove(path);
  {
    const OutputLock lock(path);
    expect_refused(simulate("2", "3", folder), "another palpate is writing this file", "Wait");
  }
  EXPECT_FALSE(fs::exists(path.string() + ".lock"));
  EXPECT_EQ(simulate("2", "3", folder).status, 0);
}

TEST_F(SharedFolder, a_full_disk_is_named_and_the_same_command_goes_on) {
  const std::string folder = copied();
  fs::remove(*made / folder / "shard-2-of-3.h5");
  // A limit of 4 KiB to a file stands for a disk that takes no more.
  expect_refused(shell(*made, "trap '' XFSZ; ulimit -f 8; " PALPATE_PROGRAM
                              " simulate body.h5 --shard 2/3 -o " +
                                  folder),
                 "cannot be written: File too large", "has space");
  ASSERT_EQ(simulate("2", "3", folder).status, 0);
  expect_same_as_one(folder);
}

}  // namespace
}  // namespace palpate::tools
