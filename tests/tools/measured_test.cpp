// Real recordings, from their files to an asset; skipped where they are not there.

#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "tests/support/shared_data.hpp"
#include "tests/tools/command_line.hpp"

namespace palpate::tools {
namespace {

using namespace testing_support;

// A square sheet in the plane z = 0, of 10 x 10 squares.
std::string sheet(double side) {
  return sheet_off(10, [side](std::ostream& out, int i, int j) {
    out << side / 10 * i << ' ' << side / 10 * j << " 0";
  });
}

// The four corners of a homogeneous specimen, each answered for by the same recordings.
std::string at_corners(const std::string& file, const char* unit, double side) {
  std::ostringstream text;
  for (int k = 0; k < 4; ++k)
    text << "[[recording]]\nfile = \"" << file << "\"\npoint = \"corner" << k
         << "\"\nposition = [\"" << side * (k % 2) << ' ' << unit << "\", \"" << side * (k / 2)
         << ' ' << unit << "\", \"0 mm\"]\n";
  return text.str();
}

class Measured : public testing::Test {
 protected:
  void SetUp() override { PALPATE_NEEDS_DATA("data/indentation"); }
  std::string path(const char* name) const { return (folder_ / name).string(); }
  std::string files(const char* pattern) const { return fs::canonical(data_).string() + pattern; }

  // Import, fit, tabulate with bands, refine, export, inspect; says what the import said.
  std::string walk(const char* unit, double side, const std::string& recordings,
                   int status_of_fit = 0) {
    folder_.write("sheet.off", sheet(side));
    folder_.write("scene.toml", std::string("[body]\nsurface = \"sheet.off\"\nlength_unit = \"") +
                                    unit + "\"\n[probe]\nradius = \"1 " + unit +
                                    "\"\n[experiments]\ntest_points = 16\n");
    folder_.write("manifest.toml", std::string("surface = \"sheet.off\"\nlength_unit = \"") + unit +
                                       "\"\n" + recordings);
    const Outcome imported =
        run("import " + path("manifest.toml") + " -o " + path("samples.h5"), 0);
    run("fit " + path("samples.h5") + " -o " + path("curves.h5"), status_of_fit);
    run("tabulate --band " + path("curves.h5") + " -o " + path("band.csv"), 0);
    run("prepare --surface-only " + path("scene.toml") + " -o " + path("body.h5"), 0);
    run("refine " + path("curves.h5") + " --body " + path("body.h5") + " -o " + path("model.h5"),
        0);
    run("export " + path("model.h5") + " -o " + path("asset.palp"), 0);
    EXPECT_NE(run("inspect " + path("asset.palp"), 0).out.find("reproduced bit for bit"),
              std::string::npos);
    return imported.err;
  }
  Outcome run(const std::string& line, int status) const {
    const Outcome outcome = palpate(folder_, line);
    EXPECT_EQ(outcome.status, status) << line << '\n' << outcome.err;
    return outcome;
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
    walk("mm", 40,
         "[defaults]\nforce_on = \"body\"\nprobe = { shape = \"flat\", radius = \"25 mm\" }\n" +
             at_corners(files("/compression/") + material + "_*.csv", "mm", 40));
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
