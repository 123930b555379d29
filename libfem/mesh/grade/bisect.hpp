#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "libfem/mesh/boundary.hpp"
#include "libfem/mesh/grade/grade_mesh.hpp"

namespace palpate::fem {

/// A tet that knows where it came from.
struct BisectedTet {
  std::array<std::int32_t, 4> node;
  std::array<std::int32_t, 4> face;  ///< opposite each corner: base boundary face, -1 inside
  std::int32_t base;                 ///< tet of the base mesh it is part of
};

/// A bisected mesh with its family tree; straight: base facets stay flat.
struct BisectedMesh {
  std::vector<Vec3> nodes;                           ///< the base's first [m]
  std::vector<std::array<std::int32_t, 2>> parents;  ///< of node base_nodes + i: the edge it split
  std::vector<BisectedTet> tets;
  std::vector<BoundaryFace> base_faces;  ///< of the base mesh: what `face` indexes
  std::int32_t base_nodes = 0;
};

/// Longest-edge bisection until every tet satisfies the options and no edge hangs.
/// Longest by length rounded to float, then by node numbers: a strict order of all edges, which is
/// what makes neighbours agree and the propagation end. Throws Error past options.max_corners.
BisectedMesh bisect(const TetMesh& base, const GradeOptions& options);

}  // namespace palpate::fem
