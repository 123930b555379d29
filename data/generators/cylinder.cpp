#include <array>
#include <cmath>
#include <vector>

#include "data/generators/bodies.hpp"

namespace palpate::bodies {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kRadius_mm = 30, kLength_mm = 100;
constexpr int kRings = 6;            // of a cap, 5 mm apart, 6 r vertices on ring r
constexpr int kAround = 6 * kRings;  // 5.2 mm apart on the side
constexpr int kRows = 22;            // 4.5 mm apart, every other turned by half a step; even
using Triangle = std::array<std::int32_t, 3>;

Vec3 on_circle(double radius_mm, double turns, double z_mm) {
  return {radius_mm * std::cos(2 * kPi * turns), radius_mm * std::sin(2 * kPi * turns), z_mm};
}

void add_side(std::vector<Vec3>& vertices, std::vector<Triangle>& triangles) {
  for (int row = 0; row <= kRows; ++row)
    for (int i = 0; i < kAround; ++i)
      vertices.push_back(
          on_circle(kRadius_mm, (i + 0.5 * (row % 2)) / kAround, kLength_mm * row / kRows));
  for (int row = 0; row < kRows; ++row)
    for (int i = 0; i < kAround; ++i) {
      const int j = (i + 1) % kAround, low = row * kAround, high = low + kAround;
      if (row % 2 == 0) {
        triangles.push_back({low + i, low + j, high + i});
        triangles.push_back({low + j, high + j, high + i});
      } else {
        triangles.push_back({low + i, high + j, high + i});
        triangles.push_back({low + i, low + j, high + j});
      }
    }
}

// Rings of 6 r vertices about the centre; the outermost is the side's, from `rim` on.
void add_cap(std::int32_t rim, bool is_top, std::vector<Vec3>& vertices,
             std::vector<Triangle>& triangles) {
  const double z_mm = is_top ? kLength_mm : 0;
  const auto centre = static_cast<std::int32_t>(vertices.size());
  vertices.push_back({0, 0, z_mm});
  std::array<std::int32_t, kRings + 1> first{centre};
  for (int ring = 1; ring < kRings; ++ring) {
    first[static_cast<std::size_t>(ring)] = static_cast<std::int32_t>(vertices.size());
    for (int i = 0; i < 6 * ring; ++i)
      vertices.push_back(on_circle(kRadius_mm * ring / kRings, i / (6.0 * ring), z_mm));
  }
  first[kRings] = rim;
  const auto add = [&](std::int32_t a, std::int32_t b, std::int32_t c) {
    triangles.push_back(is_top ? Triangle{a, b, c} : Triangle{a, c, b});
  };
  for (std::size_t ring = 1; ring <= kRings; ++ring) {
    const int size = static_cast<int>(ring), inner = size - 1;
    for (int sector = 0; sector < 6; ++sector)
      for (int k = 0; k < size; ++k) {
        const auto out = [&](int i) { return first[ring] + (sector * size + i) % (6 * size); };
        const auto in = [&](int i) {
          return inner == 0 ? centre : first[ring - 1] + (sector * inner + i) % (6 * inner);
        };
        add(in(k), out(k), out(k + 1));
        if (k < inner) add(in(k), out(k + 1), in(k + 1));
      }
  }
}

}  // namespace

Surface cylinder_mm() {
  std::vector<Vec3> vertices;
  std::vector<Triangle> triangles;
  add_side(vertices, triangles);
  add_cap(0, false, vertices, triangles);
  add_cap(kRows * kAround, true, vertices, triangles);

  return surface_of(vertices, triangles);
}

}  // namespace palpate::bodies
