#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "libfit/core/disjoint_sets.hpp"
#include "libfit/core/geometry.hpp"

namespace palpate::repair {

using Triangle = std::array<std::int32_t, 3>;

/// A triangle's side from corner `corner` to the next, as its edge low-high.
struct Side {
  std::int32_t low, high;
  std::int32_t face;
  std::int8_t corner;
  bool is_forward;  ///< the triangle runs from low to high
};

/// All sides, those of one edge together; within an edge by face.
std::vector<Side> sorted_sides(const std::vector<Triangle>& faces);

/// Calls use(begin, end) with the sides of each edge of `sides`, which sorted_sides made.
template <typename Use>
void for_each_edge(const std::vector<Side>& sides, Use use) {
  for (auto begin = sides.begin(); begin != sides.end();) {
    auto end = begin + 1;
    while (end != sides.end() && end->low == begin->low && end->high == begin->high) ++end;
    use(begin, end);
    begin = end;
  }
}
/// Component of each face, numbered from 0 in the order of faces; faces that share an edge belong
/// together.
struct Components {
  std::vector<std::size_t> of_face;
  std::size_t number = 0;
};
Components components(const std::vector<Triangle>& faces);

/// Number of vertices whose faces fall into several fans that share no edge there.
std::size_t count_pinched_vertices(const std::vector<Triangle>& faces, std::size_t vertices);

std::vector<Triangle> to_faces(const Triangles& triangles);
Surface to_surface(const std::vector<Vec3>& points, const std::vector<Triangle>& faces);

}  // namespace palpate::repair
