#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "libfem/mesh/topology.hpp"
#include "libfit/core/error.hpp"

namespace palpate::fem {

/// A box [0, size] filled with cells[0] x cells[1] x cells[2] bricks of six tets each.
/// size_m: edges of the box [m]. Node (i, j, k) is row i + (nx+1) (j + (ny+1) k). Bricks are mirror
/// images of their neighbours, so the mesh is symmetric about every brick wall and bisection of its
/// longest edges makes three shapes only. Throws Error unless sizes and cells are positive.
/// Source: triangulation J1 of Todd 1976 (doi:10.1007/978-3-642-50327-6), bricks split as by Kuhn.
inline TetMesh structured_block(const Vec3& size_m, const std::array<int, 3>& cells) {
  for (int axis = 0; axis < 3; ++axis)
    if (!(size_m[axis] > 0) || cells[axis] < 1)
      throw Error("structured_block", "a size or a number of cells is not positive",
                  "Give three positive sizes in metres and three numbers of cells from 1 up.");
  const int nx = cells[0], ny = cells[1], nz = cells[2];
  const auto node = [&](const std::array<int, 3>& at) {
    return at[0] + (nx + 1) * (at[1] + (ny + 1) * at[2]);
  };

  TetMesh mesh;
  mesh.nodes.resize((nx + 1) * (ny + 1) * (nz + 1), 3);
  for (int k = 0; k <= nz; ++k)
    for (int j = 0; j <= ny; ++j)
      for (int i = 0; i <= nx; ++i)
        mesh.nodes.row(node({i, j, k})) << size_m[0] * i / nx, size_m[1] * j / ny,
            size_m[2] * k / nz;

  // From the brick's corner with all indices even to the one with all odd, an axis at a time.
  constexpr std::array<std::array<std::size_t, 3>, 6> kOrders{
      {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};
  mesh.tets.resize(Eigen::Index{6} * nx * ny * nz, 4);
  Eigen::Index row = 0;
  for (int k = 0; k < nz; ++k)
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i)
        for (const auto& order : kOrders) {
          const std::array<int, 3> even{i + i % 2, j + j % 2, k + k % 2};
          const std::array<int, 3> odd{i + 1 - i % 2, j + 1 - j % 2, k + 1 - k % 2};
          std::array<int, 3> at = even;
          std::array<int, 4> corner{node(at), 0, 0, 0};
          for (std::size_t step = 0; step < 3; ++step) {
            at[order[step]] = odd[order[step]];
            corner[step + 1] = node(at);
          }
          if (tet_volume_m3({mesh.nodes.row(corner[0]), mesh.nodes.row(corner[1]),
                             mesh.nodes.row(corner[2]), mesh.nodes.row(corner[3])}) < 0)
            std::swap(corner[2], corner[3]);
          mesh.tets.row(row++) << corner[0], corner[1], corner[2], corner[3];
        }
  return mesh;
}

/// The square [-1, 1] x [-1, 1] bent to the unit disc: straight near the middle, its border the
/// circle. Returns the factor by which (x, y) moves from the middle.
inline double square_to_disc(double x, double y) {
  const double ring = std::max(std::abs(x), std::abs(y)), away = std::hypot(x, y);
  return 1 - ring * ring + ring * ring * (away > 0 ? ring / away : 1);
}

/// A cylinder of height_m with its top in z = 0 about the z axis: a structured block of
/// across x across x layers bricks, each layer bent to a disc of radius_m.
inline TetMesh structured_cylinder(double radius_m, double height_m, int across, int layers) {
  TetMesh mesh = structured_block(Vec3(2, 2, 1), {across, across, layers});
  for (Eigen::Index n = 0; n < mesh.nodes.rows(); ++n) {
    const double x = mesh.nodes(n, 0) - 1, y = mesh.nodes(n, 1) - 1;
    const double pull = square_to_disc(x, y);
    mesh.nodes.row(n) << radius_m * pull * x, radius_m * pull * y,
        height_m * (mesh.nodes(n, 2) - 1);
  }
  return mesh;
}

}  // namespace palpate::fem
