#include "libfem/mesh/surface/remesh.hpp"

#include "libfem/mesh/surface/remesh_passes.hpp"

namespace palpate {

Surface remesh(const Surface& fine, const BoxTree& boxes, const Eigen::VectorXd& wanted_m,
               double feature_angle_deg) {
  constexpr int kRounds = 12;  // Botsch and Kobbelt use 5 to 10; the first ones here only coarsen
  const Points fine_normals = vertex_normals(fine);
  Remeshing work{to_half_edges(fine), {}, fine, boxes, wanted_m, fine_normals, {}, {}};
  work.lines = mark_features(work.mesh, feature_angle_deg, 2 * wanted_m.minCoeff());
  for (Eigen::Index v = 0; v < wanted_m.size(); ++v) {
    work.size_m.push_back(wanted_m[v]);
    work.normal.push_back(fine_normals.row(v));
  }
  for (int round = 0; round < kRounds; ++round) {
    work.split_long_edges();
    work.collapse_short_edges();
    work.flip_edges();
    work.relax_vertices();
  }
  work.flip_edges();
  return to_surface(work.mesh);
}

}  // namespace palpate
