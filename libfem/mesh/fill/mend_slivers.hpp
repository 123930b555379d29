#pragma once

#include "libfit/core/geometry.hpp"

namespace palpate {

/// Mends tets with a dihedral angle below `below_deg` where they are, worst first: a node goes to a
/// neighbour, an edge or a face gives way to others, an inner edge gets a node. The boundary stays
/// but for edges across which it is flat to 20 degrees and bulges out, which give way, and for
/// nodes and edges next to each other (3 % of an edge). Each change makes the worst angle of what
/// it touches larger and no new sliver, so it ends; a mesh without such tets stays as it is.
/// Returns how many changes were made. Deterministic. After Freitag and Ollivier-Gooch 1997,
/// doi:10.1002/(SICI)1097-0207(19971115)40:21; an edge's removal by dynamic programming after
/// Shewchuk 2002, "Two discrete optimization algorithms for the topological improvement of
/// tetrahedral meshes".
int mend_slivers(TetMesh& mesh, double below_deg);

}  // namespace palpate
