#include "libfem/mesh/points/self_intersection.hpp"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Surface_mesh.h>

#include <vector>

namespace palpate {

bool is_self_intersecting(const Surface& surface) {
  using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
  using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;
  Mesh mesh;
  std::vector<Mesh::Vertex_index> vertex;
  for (const auto& p : surface.vertices.rowwise())
    vertex.push_back(mesh.add_vertex(Kernel::Point_3(p.x(), p.y(), p.z())));
  const auto at = [&](std::int32_t v) { return vertex[static_cast<std::size_t>(v)]; };
  for (const auto& t : surface.triangles.rowwise())
    if (mesh.add_face(at(t[0]), at(t[1]), at(t[2])) == Mesh::null_face()) return true;
  return CGAL::Polygon_mesh_processing::does_self_intersect(mesh);
}

}  // namespace palpate
