#include <array>
#include <cmath>
#include <map>
#include <vector>

#include "data/generators/bodies.hpp"

namespace palpate::bodies {

Surface block_mm() {
  constexpr double kEdge_mm = 5;
  constexpr std::array<int, 3> kCells{20, 20, 8};  // 100 x 100 x 40 mm
  std::map<std::array<int, 3>, std::int32_t> vertex_at;
  std::vector<std::array<int, 3>> vertices;
  std::vector<std::array<std::int32_t, 3>> triangles;
  const auto vertex = [&](const std::array<int, 3>& at) {
    const auto [entry, is_new] =
        vertex_at.try_emplace(at, static_cast<std::int32_t>(vertices.size()));
    if (is_new) vertices.push_back(at);
    return entry->second;
  };

  for (std::size_t axis = 0; axis < 3; ++axis)
    for (const bool is_far : {false, true}) {
      const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
      for (int j = 0; j < kCells[v]; ++j)
        for (int i = 0; i < kCells[u]; ++i) {
          std::array<std::int32_t, 4> corner;  // counter-clockwise seen from +axis
          for (std::size_t k = 0; k < 4; ++k) {
            std::array<int, 3> at{};
            at[axis] = is_far ? kCells[axis] : 0;
            at[u] = i + (k == 1 || k == 2);
            at[v] = j + (k >= 2);
            corner[k] = vertex(at);
          }
          if (!is_far) std::swap(corner[1], corner[3]);
          if ((i + j) % 2 == 0) {  // diagonals alternate, so that no direction is preferred
            triangles.push_back({corner[0], corner[1], corner[2]});
            triangles.push_back({corner[0], corner[2], corner[3]});
          } else {
            triangles.push_back({corner[1], corner[2], corner[3]});
            triangles.push_back({corner[1], corner[3], corner[0]});
          }
        }
    }

  std::vector<Vec3> places_mm;
  for (const auto& at : vertices) places_mm.emplace_back(kEdge_mm * Vec3(at[0], at[1], at[2]));
  return surface_of(places_mm, triangles);
}

}  // namespace palpate::bodies
