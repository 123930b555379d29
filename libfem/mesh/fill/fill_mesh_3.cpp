#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Mesh_complex_3_in_triangulation_3.h>
#include <CGAL/Mesh_criteria_3.h>
#include <CGAL/Mesh_triangulation_3.h>
#include <CGAL/Polyhedral_mesh_domain_with_features_3.h>
#include <CGAL/Random.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/make_mesh_3.h>

#include <algorithm>
#include <map>
#include <stdexcept>
#include <vector>

#include "libfem/mesh/fill/meshers.hpp"
#include "libfem/mesh/tet_quality.hpp"

namespace palpate {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using SurfaceMesh = CGAL::Surface_mesh<Kernel::Point_3>;
using Domain = CGAL::Polyhedral_mesh_domain_with_features_3<Kernel, SurfaceMesh>;
using Triangulation = CGAL::Mesh_triangulation_3<Domain, CGAL::Default, CGAL::Sequential_tag>::type;
using Complex = CGAL::Mesh_complex_3_in_triangulation_3<Triangulation, Domain::Corner_index,
                                                        Domain::Curve_index>;
using Criteria = CGAL::Mesh_criteria_3<Triangulation>;

SurfaceMesh to_surface_mesh(const Surface& surface) {
  SurfaceMesh mesh;
  std::vector<SurfaceMesh::Vertex_index> vertex;
  for (const auto& p : surface.vertices.rowwise())
    vertex.push_back(mesh.add_vertex(Kernel::Point_3(p.x(), p.y(), p.z())));
  const auto at = [&](std::int32_t v) { return vertex[static_cast<std::size_t>(v)]; };
  for (const auto& t : surface.triangles.rowwise())
    if (mesh.add_face(at(t[0]), at(t[1]), at(t[2])) == SurfaceMesh::null_face())
      throw std::runtime_error("needs a manifold surface");
  return mesh;
}

TetMesh to_tet_mesh(const Complex& complex) {
  TetMesh mesh;
  std::map<Triangulation::Vertex_handle, std::int32_t> index;
  std::vector<Vec3> nodes;
  mesh.tets.resize(static_cast<Eigen::Index>(complex.number_of_cells_in_complex()), 4);
  Eigen::Index t = 0;
  for (auto cell = complex.cells_in_complex_begin(); cell != complex.cells_in_complex_end();
       ++cell, ++t)
    for (int k = 0; k < 4; ++k) {
      const auto vertex = cell->vertex(k);
      const auto [at, is_new] = index.emplace(vertex, static_cast<std::int32_t>(nodes.size()));
      const auto& p = vertex->point();
      if (is_new) nodes.emplace_back(p.x(), p.y(), p.z());
      mesh.tets(t, k) = at->second;
    }
  mesh.nodes.resize(static_cast<Eigen::Index>(nodes.size()), 3);
  for (std::size_t i = 0; i < nodes.size(); ++i)
    mesh.nodes.row(static_cast<Eigen::Index>(i)) = nodes[i];
  for (t = 0; t < mesh.tets.rows(); ++t)
    if (tet_volume_m3(corners_of(mesh, t)) < 0) std::swap(mesh.tets(t, 0), mesh.tets(t, 1));
  return mesh;
}

}  // namespace

TetMesh fill_with_mesh_3(const Surface& closed, double edge_m, double interior_edge_m,
                         double facet_distance_m, int max_nodes) {
  using namespace CGAL::parameters;
  constexpr double kFeatureDeg = 40;
  CGAL::get_default_random() = CGAL::Random(0);  // whoever used it before
  const SurfaceMesh polyhedron = to_surface_mesh(closed);
  Domain domain(polyhedron);
  domain.detect_features(kFeatureDeg);
  // Facets as TetGen's input would have them; 25 degrees and a ratio of 2.5 are CGAL's own
  // recommendation for termination with optimisation to follow.
  const Criteria criteria(edge_size = edge_m, facet_angle = 25, facet_size = edge_m / 1.5,
                          facet_distance = facet_distance_m, cell_radius_edge_ratio = 2.5,
                          cell_size = interior_edge_m / 1.6);
  CGAL::Mesh_error_code error = CGAL::CGAL_MESH_3_NO_ERROR;
  Complex complex = CGAL::make_mesh_3<Complex>(
      domain, criteria, no_lloyd(), no_odt(), no_perturb(), no_exude(),
      mesh_3_options(maximal_number_of_vertices = static_cast<std::size_t>(max_nodes),
                     pointer_to_error_code = &error));
  if (error == CGAL::CGAL_MESH_3_MAXIMAL_NUMBER_OF_VERTICES_REACHED)
    throw std::runtime_error("wanted more than " + std::to_string(max_nodes) + " nodes");
  // No limit of time: what comes out must not depend on the machine.
  CGAL::lloyd_optimize_mesh_3(complex, domain, time_limit = 0, max_iteration_number = 10);
  CGAL::perturb_mesh_3(complex, domain, time_limit = 0, sliver_bound = 15);
  CGAL::exude_mesh_3(complex, time_limit = 0, sliver_bound = 15);
  return to_tet_mesh(complex);
}

}  // namespace palpate
