// Real recordings, from their files to an asset; skipped where they are not there.

#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "tests/support/shared_data.hpp"
#include "tests/tools/command_line.hpp"

namespace palpate::tools {
namespace {

using namespace testing_support;

constexpr int kSide_mm = 40;

// A square sheet in the plane z = 0, of 10 x 10 squares.
std::string sheet() {
  return sheet_off(10, [](std::ostream& out, int i, int j) {
    out << kSide_mm / 10 * i << ' ' << kSide_mm / 10 * j << " 0";
  });
}

// The four corners of a homogeneous specimen, each answered for by the same recordings.
std::string at_corners(const std::string& file) {
  std::ostringstream text;
  for (int k = 0; k < 4; ++k)
    text << "[[recording]]\nfile = \"" << file << "\"\npoint = \"corner" << k
         << "\"\nposition = [\"" << kSide_mm * (k % 2) << " mm\", \"" << kSide_mm * (k / 2)
         << " mm\", \"0 mm\"]\n";
  return text.str();
}

class Measured : public testing::Test {
 protected:
  void SetUp() override { PALPATE_NEEDS_DATA("data/indentation"); }
  std::string files(const char* pattern) const { return fs::canonical(data_).string() + pattern; }

  // Import, fit, tabulate with bands, refine, export, inspect.
  void walk(const std::string& recordings) const {
    const std::string body = "surface = \"sheet.off\"\nlength_unit = \"mm\"\n";
    folder_.write("sheet.off", sheet());
    folder_.write("scene.toml", "[body]\n" + body +
                                    "[probe]\nradius = \"1 mm\"\n[experiments]\n"
                                    "test_points = 16\n");
    folder_.write("manifest.toml", body + recordings);
    for (const char* line :
         {"import manifest.toml -o samples.h5", "fit samples.h5 -o curves.h5",
          "tabulate --band curves.h5 -o band.csv", "prepare --surface-only scene.toml -o body.h5",
          "refine curves.h5 --body body.h5 -o model.h5", "export model.h5 -o asset.palp"}) {
      const Outcome outcome = palpate(folder_, line);
      EXPECT_EQ(outcome.status, 0) << line << '\n' << outcome.err;
    }
    EXPECT_TRUE(holds(palpate(folder_, "inspect asset.palp").out, "reproduced bit for bit"));
  }
  struct Row {
    std::string point;
    double at_m = 0, value_N = 0, deviation_N = 0;
  };
  std::vector<Row> bands() const {
    std::vector<Row> rows;
    std::istringstream table(content_of(folder_ / "band.csv"));
    std::string line;
    std::getline(table, line);
    while (std::getline(table, line)) {
      std::vector<std::string> cells;
      std::istringstream fields(line);
      for (std::string cell; std::getline(fields, cell, ',');) cells.push_back(cell);
      if (cells.at(2) == "normal")
        rows.push_back(
            {cells.at(0), std::stod(cells.at(3)), std::stod(cells.at(4)), std::stod(cells.at(6))});
    }
    return rows;
  }
  void expect_bands(std::size_t points, double share) const {
    const auto rows = bands();
    ASSERT_EQ(rows.size(), 21 * points);
    for (const Row& row : rows) {
      EXPECT_GE(row.value_N, 0) << row.point;
      EXPECT_TRUE(row.at_m == 0 || row.deviation_N > 0) << row.point << ' ' << row.at_m;
    }
    EXPECT_LT(rows.back().deviation_N, share * rows.back().value_N);
  }

  Folder folder_;
  fs::path data_ = palpate::testing_support::shared_data("data");
};

TEST_F(Measured, five_compressions_of_each_silicone_become_an_asset) {
  for (const char* material : {"EF10_100T", "EF10_50T"}) {
    walk("[defaults]\nforce_on = \"body\"\nprobe = { shape = \"flat\", radius = \"25 mm\" }\n" +
         at_corners(files("/compression/") + material + "_*.csv"));
    expect_bands(4, 0.2);
    const auto rows = bands();
    ASSERT_GT(rows.size(), 20u);
    EXPECT_NEAR(rows[20].at_m, 19.6e-3, 0.2e-3) << material;
    EXPECT_GT(rows[20].value_N, 60) << material;
    EXPECT_LT(rows[20].value_N, 160) << material;
  }
}

}  // namespace
}  // namespace palpate::tools
