#pragma once

// A small block that is quick to simulate, as files that the program reads.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "tests/tools/command_line.hpp"

namespace palpate::tools::testing_support {

inline const std::string kPressKeys = R"(columns = { time = "t", depth = "d", force = "F" }
units = { time = "s", position = "mm", force = "N" }
force_on = "body"
)";

/// A manifest of presses on the block's top, from the CSV files that `file` matches.
inline std::string press_manifest(const std::string& file) {
  return "[[recording]]\nfile = \"" + file + "\"\n" + kPressKeys +
         "position = [0, 0, 40]\nnormal = [0, 0, -1]\n";
}

/// Such a file: 100 rows of a press of 2 mm, in which a spring answers from 1 mm on.
inline std::string press_csv(double stiffness_N_m) {
  std::string text = "t,d,F\n";
  for (int i = 0; i < 100; ++i)
    text += std::to_string(0.01 * i) + "," + std::to_string(0.03 * i) + "," +
            std::to_string(stiffness_N_m * 1e-3 * std::max(0.0, 0.03 * i - 1) + 1e-4 * (i % 3)) +
            "\n";
  return text;
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

struct BlockMesh {
  std::vector<std::array<double, 3>> vertices;
  std::vector<std::array<int, 3>> faces;
};

// A block of 80 x 80 x 30 whose top is a grid, so that it has vertices to press on: six grids with
// coinciding borders, which the repair welds.
inline BlockMesh block_mesh(int cells) {
  BlockMesh block;
  const auto side = [&](auto&& place) {
    const int first = static_cast<int>(block.vertices.size());
    for (int j = 0; j <= cells; ++j)
      for (int i = 0; i <= cells; ++i) {
        const auto [x, y, z] = place(double(i) / cells, double(j) / cells);
        block.vertices.push_back({80 * x, 80 * y, 30 * z});
      }
    for (int j = 0; j < cells; ++j)
      for (int i = 0; i < cells; ++i) {
        const int a = first + j * (cells + 1) + i, b = a + 1, c = b + cells + 1, d = a + cells + 1;
        block.faces.insert(block.faces.end(), {{a, b, c}, {a, c, d}});
      }
  };
  side([](double s, double t) { return std::array{s, t, 1.0}; });
  side([](double s, double t) { return std::array{t, s, 0.0}; });
  side([](double s, double t) { return std::array{s, 0.0, t}; });
  side([](double s, double t) { return std::array{t, 1.0, s}; });
  side([](double s, double t) { return std::array{0.0, t, s}; });
  side([](double s, double t) { return std::array{1.0, s, t}; });
  return block;
}

inline std::string block_off(int cells) {
  const BlockMesh block = block_mesh(cells);
  std::string text = "OFF\n" + std::to_string(block.vertices.size()) + " " +
                     std::to_string(block.faces.size()) + " 0\n";
  for (const auto& [x, y, z] : block.vertices)
    text += std::to_string(x) + " " + std::to_string(y) + " " + std::to_string(z) + "\n";
  for (const auto& [a, b, c] : block.faces)
    text += "3 " + std::to_string(a) + " " + std::to_string(b) + " " + std::to_string(c) + "\n";
  return text;
}

/// The scene and its block in a folder of their own.
struct BlockFolder : Folder {
  explicit BlockFolder(const std::string& scene = kScene) {
    write("scene.toml", scene), write("block.off", block_off(8));
  }
};

// That folder, and `palpate run` on it.
class BlockRun : public testing::Test {
 protected:
  Outcome run(const std::string& out, const std::string& options = "") {
    return palpate(folder, "run scene.toml -o " + out + " " + options);
  }
  BlockFolder folder;
};

}  // namespace palpate::tools::testing_support
