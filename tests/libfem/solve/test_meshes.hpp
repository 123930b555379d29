#pragma once

#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <set>

#include "libfem/mesh/quadratic_mesh.hpp"
#include "libfit/core/tet_mesh.hpp"

namespace palpate::fem {

/// Box grid of nx x ny x nz cells over [0,1]^3, six tetrahedra each around a common diagonal, nodes
/// moved by `map`, which must keep orientation.
inline TetMesh grid_tets(int nx, int ny, int nz, const std::function<Vec3(const Vec3&)>& map) {
  TetMesh mesh;
  mesh.nodes.resize((nx + 1) * (ny + 1) * (nz + 1), 3);
  const auto index = [&](int i, int j, int k) { return (k * (ny + 1) + j) * (nx + 1) + i; };
  for (int k = 0; k <= nz; ++k)
    for (int j = 0; j <= ny; ++j)
      for (int i = 0; i <= nx; ++i)
        mesh.nodes.row(index(i, j, k)) =
            map(Vec3(double(i) / nx, double(j) / ny, double(k) / nz)).transpose();
  constexpr int kOrders[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {1, 0, 2}, {0, 2, 1}, {2, 1, 0}};
  mesh.tets.resize(6 * nx * ny * nz, 4);
  int t = 0;
  for (int k = 0; k < nz; ++k)
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i)
        for (int o = 0; o < 6; ++o, ++t) {
          std::array<int, 3> at{i, j, k};
          mesh.tets(t, 0) = index(at[0], at[1], at[2]);
          for (int s = 0; s < 3; ++s) {
            ++at[kOrders[o][s]];
            mesh.tets(t, s + 1) = index(at[0], at[1], at[2]);
          }
          if (o >= 3) std::swap(mesh.tets(t, 2), mesh.tets(t, 3));
        }
  return mesh;
}

/// Ten-node mesh with mid-edge nodes halfway; held nodes are those for which is_held says so.
inline QuadraticMesh quadratic(const TetMesh& mesh,
                               const std::function<bool(const Vec3&)>& is_held) {
  constexpr int kEdges[6][2] = {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};
  // Faces opposite to corners 3, 2, 1, 0, outward.
  constexpr int kFaces[4][3] = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  QuadraticMesh out;
  std::vector<Vec3> nodes;
  for (Eigen::Index n = 0; n < mesh.nodes.rows(); ++n) nodes.push_back(mesh.nodes.row(n));
  std::map<std::pair<int, int>, int> middle;
  const auto middle_of = [&](int a, int b) {
    const auto [at, is_new] = middle.try_emplace(std::minmax(a, b), static_cast<int>(nodes.size()));
    if (is_new) nodes.push_back((nodes[a] + nodes[b]) / 2);
    return at->second;
  };
  out.tets.resize(mesh.tets.rows(), 10);
  std::map<std::set<int>, std::pair<int, std::array<int, 3>>> faces;
  for (Eigen::Index t = 0; t < mesh.tets.rows(); ++t) {
    for (int c = 0; c < 4; ++c) out.tets(t, c) = mesh.tets(t, c);
    for (int e = 0; e < 6; ++e)
      out.tets(t, 4 + e) = middle_of(mesh.tets(t, kEdges[e][0]), mesh.tets(t, kEdges[e][1]));
    for (const auto& f : kFaces) {
      const std::array<int, 3> c{mesh.tets(t, f[0]), mesh.tets(t, f[1]), mesh.tets(t, f[2])};
      auto& entry = faces[{c[0], c[1], c[2]}];
      ++entry.first, entry.second = c;
    }
  }
  std::vector<std::array<int, 6>> boundary;
  for (const auto& [key, entry] : faces)
    if (entry.first == 1) {
      const auto& c = entry.second;
      boundary.push_back({c[0], c[1], c[2], middle_of(c[0], c[1]), middle_of(c[1], c[2]),
                          middle_of(c[2], c[0])});
    }
  out.faces.resize(boundary.size(), 6);
  for (std::size_t f = 0; f < boundary.size(); ++f)
    for (int a = 0; a < 6; ++a) out.faces(f, a) = boundary[f][a];
  out.nodes.resize(nodes.size(), 3);
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    out.nodes.row(n) = nodes[n].transpose();
    out.is_held.push_back(is_held(nodes[n]));
  }
  return out;
}

}  // namespace palpate::fem
