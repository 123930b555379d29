#pragma once

#include <string>

#include "libfit/core/geometry.hpp"

// The two meshers behind fill_volume. They may crash, abort or loop: call them in a child process.

namespace palpate {

/// How TetGen is asked to refine (TetGen 1.5 manual, section 4.2).
struct TetGenSettings {
  double radius_edge_ratio = 1.3;
  double min_dihedral_deg = 15;
  double max_volume_m3 = 0;        ///< of any tet
  int max_added_points = 200'000;  ///< ends a refinement that would not end
};

/// Fills a closed surface with TetGen 1.5; its triangles become the boundary unchanged. Points in
/// cavities are marked as holes. Throws an int on failure, put into words by `tetgen_failure`,
/// std::bad_alloc, or std::runtime_error where it would add more points than it may.
TetMesh fill_with_tetgen(const Surface& closed, const Points& cavities,
                         const TetGenSettings& settings);
std::string tetgen_failure(int code);

/// Fills a closed surface, which may cross itself, with CGAL Mesh_3: new vertices, close to the
/// surface within `facet_distance_m`, edges sharper than 40 degrees kept. Throws std::runtime_error
/// where it would make more than `max_nodes`. Deterministic.
TetMesh fill_with_mesh_3(const Surface& closed, double edge_m, double interior_edge_m,
                         double facet_distance_m, int max_nodes);

}  // namespace palpate
