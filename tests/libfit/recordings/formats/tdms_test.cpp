// LabVIEW's TDMS: every layout that rigs write, and everything that can be wrong with a file.

#include <gtest/gtest.h>

#include <random>

#include "libfit/recordings/formats/importers.hpp"
#include "tests/libfit/io/scratch.hpp"
#include "tests/support/afm_files.hpp"

namespace palpate::importers {
namespace {

using namespace testing_support;
using testing_io::error_of;

ReadSettings on_body() {
  ReadSettings settings;
  settings.is_force_on_tool = false;
  return settings;
}

std::vector<RawRecording> read(const std::string& bytes, const ReadSettings& settings = on_body()) {
  return read_recordings("a", bytes, settings);
}

std::string refusal(const std::string& bytes, const ReadSettings& settings = on_body()) {
  return error_of([&] { read(bytes, settings); });
}

void expect_the_press(const RawRecording& r, int rows, double tolerance_N) {
  ASSERT_EQ(r.rows(), rows);
  ASSERT_EQ(r.time_s.size(), static_cast<std::size_t>(rows));
  for (int i = 0; i < rows; i += 7) {
    const auto k = static_cast<std::size_t>(i);
    EXPECT_NEAR(r.travel_m[k], press_travel_m(i), 1e-18) << i;
    EXPECT_NEAR(r.push_N[k], press_force_N(i), tolerance_N) << i;
    EXPECT_DOUBLE_EQ(r.time_s[k], 0.0025 * i);
  }
}

TEST(TdmsTest, the_same_press_comes_out_of_every_layout) {
  for (const bool is_interleaved : {false, true})
    for (const bool is_big : {false, true})
      for (const int segments : {1, 4})
        for (const bool has_scale : {false, true}) {
          SCOPED_TRACE(testing::Message() << is_interleaved << is_big << segments << has_scale);
          const auto r = read(tdms_file({is_interleaved, is_big, segments, has_scale}));
          ASSERT_EQ(r.size(), 1u);
          EXPECT_EQ(r[0].format, "tdms");
          EXPECT_EQ(r[0].name, "");
          expect_the_press(r[0], 2 * kWayRows, has_scale ? 0.6e-10 : 1e-14);
          EXPECT_EQ(r[0].taken.back(), "readings every 0.0025 s");
        }
}

TEST(TdmsTest, a_group_is_a_recording_unless_columns_name_groups) {
  const std::string three = tdms_file({.groups = 3});
  const auto r = read(three);
  ASSERT_EQ(r.size(), 3u);
  EXPECT_EQ(r[2].name, "press 3");
  expect_the_press(r[2], 2 * kWayRows, 1e-14);
  ReadSettings settings = on_body();
  settings.columns.depth = "press 2/depth";
  settings.columns.force = {"press 1/force"};
  ASSERT_EQ(read(three, settings).size(), 1u);
  expect_the_press(read(three, settings)[0], 2 * kWayRows, 1e-14);
  settings.columns.force = {"load"};
  settings.columns.depth = "depth";
  const auto unread = read(three, settings);
  ASSERT_EQ(unread.size(), 3u);
  EXPECT_TRUE(std::string(unread[1].unread->what()).starts_with("a: column `load` is missing"));
}

// A rig that stops in the middle leaves a segment without its length, or a part of the rows.
TEST(TdmsTest, what_is_whole_of_a_file_that_ends_early_is_read) {
  const std::string four = tdms_file({.is_interleaved = true, .segments = 4});
  const auto r = read(four.substr(0, four.size() - 12 * 50 - 5));
  expect_the_press(r[0], 2 * kWayRows - 51, 1e-14);
  EXPECT_EQ(r[0].taken.back(), "the file is cut short: what is whole was read");
  std::string open = tdms_file({.segments = 4});
  const std::size_t last = open.rfind("TDSm");
  open.replace(last + 12, 8, std::string(8, '\xff'));
  expect_the_press(read(open)[0], 2 * kWayRows, 1e-14);
  EXPECT_EQ(read(open)[0].taken.back(), "the file is cut short: what is whole was read");
}

TEST(TdmsTest, what_is_wrong_with_a_file_is_named) {
  const std::string good = tdms_file();
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string bytes = good;
    return bytes.replace(bytes.find(from), from.size(), to);
  };
  EXPECT_EQ(refusal(good.substr(0, 200)), "a: has no channel with numbers");
  EXPECT_EQ(refusal("TDSm"), "a: has no channel with numbers");
  EXPECT_EQ(refusal(good + "TDSh" + std::string(40, '\0')), "a: is a damaged TDMS file");
  EXPECT_EQ(refusal(with(std::string("\x14\0\0\0", 4), std::string("\x69\x12\0\0", 4))),
            "a: holds raw data of DAQmx, whose layout is not read");
  EXPECT_EQ(refusal(with(std::string("\x0a\0\0\0\x01", 5), std::string("\x0b\0\0\0\x01", 5))),
            "a:depth: holds numbers of type 0xb, which is not read");
  EXPECT_EQ(refusal(with("'force'", "'power'")), "a: no channel is named");
  EXPECT_EQ(refusal(with("mm", "kg")),
            "a: column `depth (kg)` is in `kg`, which is no unit of length");
  EXPECT_EQ(refusal(good, {}), "a: force_on is missing: whose force the sensor reports");
  std::string scaled = tdms_file({.has_scale = true});
  scaled.replace(scaled.find("Linear"), 6, "Strain");
  EXPECT_EQ(refusal(scaled), "a:force: has a scale of type Strain, and linear ones are read");
}

TEST(TdmsTest, damaged_tdms_bytes_are_read_or_refused) {
  for (const TdmsLayout& layout : {TdmsLayout{}, TdmsLayout{true, true, 4, true, 2}}) {
    const std::string good = tdms_file(layout);
    std::mt19937 random(4);
    for (int trial = 0; trial < 3000; ++trial) {
      std::string damaged = good;
      for (unsigned k = 0; k < 1 + random() % 4; ++k)
        damaged[random() % 900] = static_cast<char>(random() % 3 ? random() : 0);
      try {
        for (const RawRecording& r : read(damaged))
          for (const double value : r.push_N) ASSERT_TRUE(std::isfinite(value)) << trial;
      } catch (const Error&) {
      }
    }
  }
}

}  // namespace
}  // namespace palpate::importers
