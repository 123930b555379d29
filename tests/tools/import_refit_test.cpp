// One recording of a batch changed, imported and fitted again, against both from nothing.

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/tools/command_line.hpp"

namespace palpate::tools {
namespace {

using namespace testing_support;

constexpr int kRecordings = 24;

std::string press(int number, double factor, int rows = 120) {
  std::string text = "t,d,F\n";
  for (int i = 0; i < rows; ++i) {
    const double travel_mm = 0.03 * i, depth_mm = std::max(0.0, travel_mm - 1);
    text += std::to_string(0.01 * i) + "," + std::to_string(travel_mm) + "," +
            std::to_string(factor * (1 + 0.01 * number) * depth_mm * (1 + 0.1 * depth_mm) +
                           1e-3 * ((i * 7 + number) % 5)) +
            "\n";
  }
  return text;
}

void write_batch(const Folder& folder, int recordings, int from = 0) {
  std::string manifest = R"([defaults]
columns = { time = "t", depth = "d", force = "F" }
units = { time = "s", position = "mm", force = "N" }
force_on = "body"
probe = { shape = "flat", radius = "10 mm" }
)";
  for (int i = from; i < recordings; ++i) {
    if (!fs::exists(folder / (std::to_string(i) + ".csv")))
      folder.write(std::to_string(i) + ".csv", press(i, 1));
    manifest += "[[recording]]\nfile = \"" + std::to_string(i) + ".csv\"\npoint = \"p" +
                std::to_string(i) + "\"\nposition = [" + std::to_string(5 * i) +
                ", 0, 40]\nnormal = [0, 0, -1]\n";
  }
  folder.write("manifest.toml", manifest);
}

// What the last fit said of residuals, bands and worst points, but for times and bases.
std::string said(const std::string& err) {
  std::string out;
  for (std::size_t at = 0; at < err.size();) {
    const std::size_t end = std::min(err.find('\n', at), err.size());
    const std::string line = err.substr(at, end - at);
    for (const char* begin : {"  rows:", "  residual:", "  worst:", "  normal   90"})
      if (line.rfind(begin, 0) == 0) out += line + "\n";
    at = end + 1;
  }
  return out;
}

class Refit : public testing::Test {
 protected:
  Outcome import(const std::string& output) {
    return palpate(folder_, "import manifest.toml -o " + output);
  }
  // One piece: a whole fit would identify other knots from the changed rows.
  Outcome fit(const std::string& output, const std::string& more = "") {
    return palpate(folder_, "fit samples.h5 --pieces 1 -o " + output + more);
  }
  // Both again: samples.h5 over the one before has the bytes of a fresh one, curves the digits of a
  // fit of all rows.
  void expect_as_from_nothing() {
    ASSERT_EQ(import("samples.h5").status, 0);
    ASSERT_EQ(import("fresh.h5").status, 0);
    EXPECT_TRUE(content_of(folder_ / "samples.h5") == content_of(folder_ / "fresh.h5"));
    const Outcome warm = fit("warm.h5", " --warm-start curves.h5");
    const Outcome whole = fit("whole.h5");
    EXPECT_EQ(said(warm.err), said(whole.err));
    EXPECT_TRUE(table("warm") == table("whole"));
  }
  // Every curve with its band, all digits. The files differ in the fingerprint alone, which a warm
  // start does not store: `run` does not make it.
  std::string table(const std::string& name) {
    const Outcome made = palpate(folder_, "tabulate " + name + ".h5 -o " + name + ".csv --band");
    EXPECT_EQ(made.status, 0) << made.err;
    return content_of(folder_ / (name + ".csv"));
  }

  Folder folder_;
};

TEST_F(Refit, a_changed_recording_ends_in_the_curves_of_a_whole_run) {
  write_batch(folder_, kRecordings);
  ASSERT_EQ(import("samples.h5").status, 0);
  fit("curves.h5");
  folder_.write("7.csv", press(7, 1.2));
  expect_as_from_nothing();
  folder_.write("7.csv", press(7, 1.2, 90));  // shorter, less deep
  expect_as_from_nothing();
}

TEST_F(Refit, recordings_removed_and_added_end_in_the_curves_of_a_whole_run) {
  write_batch(folder_, kRecordings);
  ASSERT_EQ(import("samples.h5").status, 0);
  fit("curves.h5");
  write_batch(folder_, kRecordings, 1);
  expect_as_from_nothing();
  write_batch(folder_, kRecordings + 1);
  expect_as_from_nothing();
}

}  // namespace
}  // namespace palpate::tools
