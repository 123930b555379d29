#include <CGAL/alpha_wrap_3.h>

#include <array>

#include "libfem/mesh/repair/cgal_mesh.hpp"
#include "libfem/mesh/repair/cgal_steps.hpp"

namespace palpate::repair {

Surface wrap_surface(const Surface& surface, double alpha_m, double offset_m) {
  std::vector<CgalPoint> points;
  for (Eigen::Index v = 0; v < surface.vertices.rows(); ++v)
    points.push_back(to_cgal(Vec3(surface.vertices.row(v))));
  std::vector<std::array<std::size_t, 3>> faces;
  for (Eigen::Index f = 0; f < surface.triangles.rows(); ++f)
    faces.push_back({static_cast<std::size_t>(surface.triangles(f, 0)),
                     static_cast<std::size_t>(surface.triangles(f, 1)),
                     static_cast<std::size_t>(surface.triangles(f, 2))});
  CgalMesh mesh;
  CGAL::alpha_wrap_3(points, faces, alpha_m, offset_m, mesh);
  return from_cgal(mesh);
}

}  // namespace palpate::repair
