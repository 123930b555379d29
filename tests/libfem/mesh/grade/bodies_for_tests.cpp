#include "tests/libfem/mesh/grade/bodies_for_tests.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "libfem/mesh/boundary.hpp"

namespace palpate::fem {

Surface icosphere(double radius_m, int levels) {
  const double g = 0.5 * (1 + std::sqrt(5.0));
  std::vector<Vec3> x{{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                      {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  std::vector<Eigen::Vector3i> f{{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                                 {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                                 {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                                 {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<int, int>, int> middle;
    const auto between = [&](int a, int b) {
      const auto [at, is_new] =
          middle.try_emplace({std::min(a, b), std::max(a, b)}, static_cast<int>(x.size()));
      if (is_new) x.push_back((x[a] / x[a].norm() + x[b] / x[b].norm()) / 2);
      return at->second;
    };
    std::vector<Eigen::Vector3i> finer;
    for (const auto& t : f) {
      const int a = between(t[0], t[1]), b = between(t[1], t[2]), c = between(t[2], t[0]);
      finer.insert(finer.end(), {{t[0], a, c}, {a, t[1], b}, {c, b, t[2]}, {a, b, c}});
    }
    f = std::move(finer);
  }
  Surface out;
  out.vertices.resize(static_cast<Eigen::Index>(x.size()), 3);
  for (std::size_t v = 0; v < x.size(); ++v)
    out.vertices.row(static_cast<Eigen::Index>(v)) = radius_m * x[v].normalized();
  out.triangles.resize(static_cast<Eigen::Index>(f.size()), 3);
  for (std::size_t t = 0; t < f.size(); ++t)
    out.triangles.row(static_cast<Eigen::Index>(t)) = f[t].transpose();
  return out;
}

TetMesh star(const Surface& surface, const Vec3& centre) {
  TetMesh mesh;
  mesh.nodes.resize(surface.vertices.rows() + 1, 3);
  mesh.nodes << centre.transpose(), surface.vertices;
  mesh.tets.resize(surface.triangles.rows(), 4);
  for (Eigen::Index t = 0; t < mesh.tets.rows(); ++t)
    mesh.tets.row(t) << 0, surface.triangles.row(t).array() + 1;
  return mesh;
}

TetMesh tet_ball(double radius_m, int levels) {
  return star(icosphere(radius_m, levels), Vec3::Zero());
}

Surface cylinder(double radius_m, double length_m, int around, int along) {
  Surface out;
  out.vertices.resize(around * (along + 1) + 2, 3);
  for (int k = 0; k <= along; ++k)
    for (int i = 0; i < around; ++i) {
      const double angle = 2 * 3.14159265358979323846 * i / around;
      out.vertices.row(k * around + i) << radius_m * std::cos(angle), radius_m * std::sin(angle),
          length_m * k / along;
    }
  const int bottom = around * (along + 1), top = bottom + 1;
  out.vertices.row(bottom) << 0, 0, 0;
  out.vertices.row(top) << 0, 0, length_m;
  out.triangles.resize(2 * around * along + 2 * around, 3);
  Eigen::Index row = 0;
  for (int i = 0; i < around; ++i) {
    const int j = (i + 1) % around;
    for (int k = 0; k < along; ++k) {
      const int a = k * around + i, b = k * around + j;
      out.triangles.row(row++) << a, b, b + around;
      out.triangles.row(row++) << a, b + around, a + around;
    }
    out.triangles.row(row++) << bottom, j, i;
    out.triangles.row(row++) << top, along * around + i, along * around + j;
  }
  return out;
}

Surface boundary_surface(const TetMesh& mesh) {
  Surface out;
  out.triangles = boundary_triangles(mesh.tets);
  std::vector<std::int32_t> vertex_of(static_cast<std::size_t>(mesh.nodes.rows()), -1);
  std::vector<std::int32_t> used;
  for (Eigen::Index i = 0; i < out.triangles.size(); ++i) {
    std::int32_t& n = out.triangles.data()[i];
    if (vertex_of[n] < 0) {
      vertex_of[n] = static_cast<std::int32_t>(used.size());
      used.push_back(n);
    }
    n = vertex_of[n];
  }
  out.vertices.resize(static_cast<Eigen::Index>(used.size()), 3);
  for (std::size_t v = 0; v < used.size(); ++v)
    out.vertices.row(static_cast<Eigen::Index>(v)) = mesh.nodes.row(used[v]);
  return out;
}

}  // namespace palpate::fem
