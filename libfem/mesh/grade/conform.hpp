#pragma once

#include <vector>

#include "libfem/mesh/grade/place_nodes.hpp"
#include "libfem/mesh/quadratic_mesh.hpp"

namespace palpate::fem {

/// Makes tets lie on one side of the border between regions (after Labelle and Shewchuk 2007,
/// doi:10.1145/1276377.1276448): inside nodes within 0.35 edges of the border are moved onto it,
/// then edges that still cross it are split there, with all tets around them. placed: the nodes of
/// `mesh` on the surface. Nodes that are new are appended to both; on the boundary they go to the
/// surface as others do. `boundary` is that of the mesh before and stale afterwards.
/// Where the border turns within a tet, or is crossed twice by an edge, the corners do not see it
/// and the tet holds two regions.
void conform_to_regions(BisectedMesh& mesh, NodePlacement& placed, const Boundary& boundary,
                        const SmoothSurface& surface, const RegionAt& region_at);

/// Makes the border of what is held a border of elements, as far as nodes can move: of each edge
/// that crosses it the nearer end is moved onto it, where no tet is spoilt; nodes of the surface go
/// along its edges, those of creases along creases. No edge is split: what is held does not move,
/// and elements in it cost and tell nothing. Returns which corner nodes are on the border.
std::vector<char> conform_to_held(const BisectedMesh& mesh, NodePlacement& placed,
                                  const Boundary& boundary, const SmoothSurface& surface,
                                  const HeldAt& held_at);

/// Moves mid-edge nodes from `first` on whose edges lie in the border onto it, where no element is
/// spoilt.
void curve_borders(QuadraticMesh& mesh, std::int32_t first, const RegionAt& region_at);

}  // namespace palpate::fem
