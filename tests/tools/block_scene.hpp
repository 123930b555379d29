#pragma once

// A small block that is quick to simulate, as files that the program reads.

#include <gtest/gtest.h>

#include <array>
#include <string>

#include "tests/tools/command_line.hpp"

namespace palpate::tools::testing_support {

/// A manifest of presses on the block's top, from the CSV files that `file` matches.
inline std::string press_manifest(const std::string& file) {
  return "[[recording]]\nfile = \"" + file + R"("
columns = { time = "t", depth = "d", force = "F" }
units = { time = "s", position = "mm", force = "N" }
force_on = "body"
position = [0, 0, 40]
normal = [0, 0, -1]
)";
}

inline const std::string kScene = R"([body]
surface = "block.off"
length_unit = "mm"
mesh_size = "20 mm"
fixed = [ { below = { axis = "z", at = "1 mm" } } ]
[material]
young = "10 kPa"
poisson = 0.45
[probe]
radius = "8 mm"
friction = 0.3
[experiments]
test_points = 4
region = { box = [["20 mm", "20 mm", "29 mm"], ["60 mm", "60 mm", "31 mm"]] }
depth = "4 mm"
press_steps = 5
drag_depths = ["3 mm"]
drag_distance = "5 mm"
drag_directions = 1
drag_steps = 9
[fit]
tolerance = 0.02
[validate]
points = 2
causes = false
)";

// A block of 80 x 80 x 30 mm whose top is a grid, so that it has vertices to press on.
inline std::string block_off(int cells) {
  std::string vertices, faces;
  int count = 0, triangles = 0;
  const auto vertex = [&](double x, double y, double z) {
    vertices +=
        std::to_string(80 * x) + " " + std::to_string(80 * y) + " " + std::to_string(30 * z) + "\n";
    ++count;
  };
  // Six grids with coinciding borders: the repair welds them.
  const auto side = [&](auto&& place) {
    const int first = count;
    for (int j = 0; j <= cells; ++j)
      for (int i = 0; i <= cells; ++i) place(double(i) / cells, double(j) / cells);
    for (int j = 0; j < cells; ++j)
      for (int i = 0; i < cells; ++i) {
        const int a = first + j * (cells + 1) + i, b = a + 1, c = b + cells + 1, d = a + cells + 1;
        for (const auto& t : {std::array{a, b, c}, std::array{a, c, d}}) {
          faces += "3 " + std::to_string(t[0]) + " " + std::to_string(t[1]) + " " +
                   std::to_string(t[2]) + "\n";
          ++triangles;
        }
      }
  };
  side([&](double s, double t) { vertex(s, t, 1); });
  side([&](double s, double t) { vertex(t, s, 0); });
  side([&](double s, double t) { vertex(s, 0, t); });
  side([&](double s, double t) { vertex(t, 1, s); });
  side([&](double s, double t) { vertex(0, t, s); });
  side([&](double s, double t) { vertex(1, s, t); });
  return "OFF\n" + std::to_string(count) + " " + std::to_string(triangles) + " 0\n" + vertices +
         faces;
}

// The scene in a folder of its own, and `palpate run` on it.
class BlockRun : public testing::Test {
 protected:
  void SetUp() override {
    scene = folder.write("scene.toml", kScene);
    folder.write("block.off", block_off(8));
  }
  Outcome run(const std::string& out, const std::string& options = "") {
    return palpate(folder,
                   "run " + scene.string() + " -o " + (folder / out).string() + " " + options);
  }
  Folder folder;
  fs::path scene;
};

}  // namespace palpate::tools::testing_support
