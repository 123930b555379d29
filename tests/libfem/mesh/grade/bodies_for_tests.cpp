#include "tests/libfem/mesh/grade/bodies_for_tests.hpp"

#include <cmath>

#include "libfem/mesh/repair/facts.hpp"
#include "libfem/mesh/topology.hpp"

namespace palpate::fem {

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
  return star(icosphere(levels, radius_m), Vec3::Zero());
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
  return compact(mesh.nodes, boundary_triangles(mesh.tets));
}

}  // namespace palpate::fem
