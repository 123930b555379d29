#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <vector>

#include "libfit/core/geometry.hpp"

namespace palpate::testing_support {

/// The surface of the cubes of a grid (count cubes of cell_m along each axis, from the origin)
/// whose middle `is_solid` takes: closed and outward, two triangles a side; manifold where no two
/// cubes meet in an edge or corner alone.
inline Surface voxel_surface(const std::array<int, 3>& count, double cell_m,
                             const std::function<bool(const Vec3&)>& is_solid) {
  const auto at = [&](const std::array<int, 3>& cell) {
    for (int k = 0; k < 3; ++k)
      if (cell[k] < 0 || cell[k] >= count[k]) return false;
    return is_solid(cell_m * Vec3(cell[0] + 0.5, cell[1] + 0.5, cell[2] + 0.5));
  };
  std::map<std::array<int, 3>, std::int32_t> number;
  std::vector<Vec3> vertices;
  std::vector<std::array<std::int32_t, 3>> triangles;
  const auto vertex = [&](const std::array<int, 3>& corner) {
    const auto [found, is_new] = number.emplace(corner, static_cast<std::int32_t>(vertices.size()));
    if (is_new) vertices.push_back(cell_m * Vec3(corner[0], corner[1], corner[2]));
    return found->second;
  };
  std::array<int, 3> cell{};
  for (cell[2] = 0; cell[2] < count[2]; ++cell[2])
    for (cell[1] = 0; cell[1] < count[1]; ++cell[1])
      for (cell[0] = 0; cell[0] < count[0]; ++cell[0])
        for (int axis = 0; axis < 3 && at(cell); ++axis)
          for (const int side : {0, 1}) {
            std::array<int, 3> beside = cell;
            beside[axis] += 2 * side - 1;
            if (at(beside)) continue;
            std::array<int, 3> a = cell;
            a[axis] += side;
            std::array<int, 3> b = a, c = a, d = a;
            const int u = (axis + 1) % 3, v = (axis + 2) % 3;
            b[u] += 1, c[u] += 1, c[v] += 1, d[v] += 1;
            const std::array<std::int32_t, 4> q{vertex(a), vertex(b), vertex(c), vertex(d)};
            const int turn = side == 1 ? 1 : 3;  // outward
            triangles.push_back({q[0], q[turn], q[2]});
            triangles.push_back({q[0], q[2], q[4 - turn]});
          }
  Surface surface{Points(static_cast<Eigen::Index>(vertices.size()), 3),
                  Triangles(static_cast<Eigen::Index>(triangles.size()), 3)};
  for (std::size_t i = 0; i < vertices.size(); ++i)
    surface.vertices.row(static_cast<Eigen::Index>(i)) = vertices[i];
  for (std::size_t i = 0; i < triangles.size(); ++i)
    surface.triangles.row(static_cast<Eigen::Index>(i)) << triangles[i][0], triangles[i][1],
        triangles[i][2];
  return surface;
}

}  // namespace palpate::testing_support
