// Pictures of recordings in the page of `palpate report`.

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "tests/tools/report_page.hpp"

namespace palpate::tools {
namespace {

// Numbers of base64 (RFC 4648, section 4) and little-endian.
template <class T>
std::vector<T> unpacked(const nlohmann::json& json) {
  static const std::string kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  std::uint32_t group = 0;
  int bits = 0;
  for (const char c : json.get<std::string>()) {
    if (c == '=') break;
    group = group << 6 | static_cast<std::uint32_t>(kDigits.find(c));
    bits += 6;
    if (bits >= 8) bytes += static_cast<char>(group >> (bits -= 8) & 255);
  }
  std::vector<T> values(bytes.size() / sizeof(T));
  std::memcpy(values.data(), bytes.data(), values.size() * sizeof(T));
  return values;
}

// An import beside the run: a sound press, one without contact, and a file of no numbers.
class Recordings : public Report {
 protected:
  void SetUp() override {
    fs::create_directories(path("rig"));
    folder_->write("rig/a.csv", press(true)), folder_->write("rig/b.csv", press(false));
    folder_->write("rig/c.csv", "t,d,F\n0,0,0\n0,x,1\n");
    std::string manifest =
        "[defaults]\ncolumns = { time = \"t\", depth = \"d\", force = \"F\" }\nunits = { time = "
        "\"s\", position = \"mm\", force = \"N\" }\nforce_on = \"body\"\nnormal = [0, 0, "
        "-1]\nposition = [0, 0, 40]\nprobe = { shape = \"sphere\", radius = \"5 mm\" }\n";
    for (const char* file : {"a.csv", "b.csv", "c.csv"})
      manifest += "[[recording]]\nfile = \"" + std::string(file) + "\"\n";
    folder_->write("rig/manifest.toml", manifest);
    outcome = palpate(*folder_, "import rig/manifest.toml -o rig/samples.h5");
    ASSERT_EQ(outcome.status, 3) << outcome.err;
    outcome = palpate(*folder_, "fit rig/samples.h5 -o rig/curves.h5");
    ASSERT_EQ(outcome.status, 0) << outcome.err;
  }
  // Into the body and back, with a rest between, in 900 readings.
  static std::string press(bool touches) {
    std::string text = "t,d,F\n";
    for (int i = 0; i < 900; ++i) {
      const double travel_mm = i < 400 ? 0.015 * i : i < 500 ? 6 : 0.015 * (900 - i);
      const double depth_mm = std::max(0.0, travel_mm - 2);
      const double force_N = touches ? 0.4 * std::pow(depth_mm / 4, 1.5) : 0;
      text += std::to_string(0.01 * i) + "," + std::to_string(travel_mm) + "," +
              std::to_string(0.1 + force_N + 1e-3 * ((i * 7919) % 11 - 5)) + "\n";
    }
    return text;
  }
  Outcome outcome;
};

TEST_F(Recordings, all_are_in_the_page_refused_ones_first) {
  SKIP_WITHOUT_PAGE();
  ASSERT_EQ(report("rig -o report.html").status, 0);
  const auto pictures = contents_of(path("report.html")).at("pictures");
  EXPECT_EQ(pictures.at("file"), (nlohmann::json{"b.csv", "c.csv", "a.csv"}));
  EXPECT_EQ(pictures.at("all"), (nlohmann::json{1, 0, 0, 2}));
  EXPECT_EQ(pictures.at("readings")[1], 0) << "nothing was read of it";
  EXPECT_NE(pictures.at("reasons")[0].get<std::string>(), "");
  EXPECT_TRUE(holds(pictures.at("reasons")[1].get<std::string>(), "`x` is not a number"));
  const auto of_b = pictures.at("readings")[0].get<std::size_t>();
  for (const char* key : {"push_N", "travel_m"}) {
    const auto all = unpacked<float>(pictures.at(key));
    EXPECT_LE(all.size(), 2 * 202u);
    EXPECT_GE(all.size(), 2 * 190u);
    EXPECT_TRUE(std::all_of(all.begin(), all.end(), [](float v) { return std::isfinite(v); }));
  }
  // A sixth of them on the press.
  const auto travel = unpacked<float>(pictures.at("travel_m"));
  const auto used = unpacked<std::uint8_t>(pictures.at("is_used"));
  int pressed = 0;
  for (std::size_t i = of_b; i < travel.size(); ++i) pressed += used.at(i) && travel[i] > 2e-3;
  EXPECT_GT(pressed, 60);
  EXPECT_NEAR(unpacked<float>(pictures.at("contact_m")).at(2), 2e-3, 1e-4);
  EXPECT_NEAR(unpacked<float>(pictures.at("bias_N")).at(2), 0.1, 1e-3);
}

TEST_F(Recordings, of_another_import_are_not_shown) {
  SKIP_WITHOUT_PAGE();
  folder_->write("rig/a.csv", press(true) + "9.5,0,0.1\n");
  fs::copy_file(path("rig/samples.signals.h5"), path("rig/kept.h5"),
                fs::copy_options::overwrite_existing);
  ASSERT_EQ(palpate(*folder_, "import rig/manifest.toml -o rig/samples.h5").status, 3);
  fs::rename(path("rig/kept.h5"), path("rig/samples.signals.h5"));
  ASSERT_EQ(report("rig -o report.html").status, 0);
  const auto contents = contents_of(path("report.html"));
  EXPECT_FALSE(contents.contains("pictures"));
  EXPECT_TRUE(holds(contents.at("warnings").dump(), "of another import"));
}

TEST_F(Recordings, are_drawn_in_both_schemes_and_on_narrow_screens) {
  SKIP_WITHOUT_CHROMIUM();
  expect_in_chromium("recordings_are_drawn", folder_->path().string(), "rig");
}

}  // namespace
}  // namespace palpate::tools
