#pragma once

#include <string>

#include "libfit/core/geometry.hpp"

namespace palpate {

/// How TetGen is asked to refine (TetGen 1.5 manual, section 4.2).
struct TetGenSettings {
  double radius_edge_ratio, min_dihedral_deg;
  double max_volume_m3;  ///< of any tet
  int max_added_points;  ///< ends a refinement that would not end
};

/// Fills a closed surface with TetGen 1.5; its triangles become the boundary unchanged. Points in
/// cavities are marked as holes. It may crash, abort or loop: call it in a child process. Throws an
/// int on failure, put into words by `tetgen_failure`, std::bad_alloc, or std::runtime_error where
/// it would add more points than it may.
TetMesh fill_with_tetgen(const Surface& closed, const Points& cavities,
                         const TetGenSettings& settings);
std::string tetgen_failure(int code);

}  // namespace palpate
