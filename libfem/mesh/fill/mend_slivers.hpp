#pragma once

#include <functional>

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

/// Moves interior nodes so that the smallest dihedral angle around each grows, worst first; nodes
/// on the boundary stay. Never makes the smallest angle around a node smaller. Deterministic. After
/// Freitag and Ollivier-Gooch 1997, doi:10.1002/(SICI)1097-0207(19971115)40:21, with a pattern
/// search in place of their active-set descent.
void smooth_interior(TetMesh& mesh);

/// Pattern search over the axes and their diagonals, from a fifth of an edge down to a hundredth:
/// moves `at` to each place that `accepts`, which remembers what it accepted.
void search_place(Vec3& at, double edge_m, const std::function<bool(const Vec3&)>& accepts);

}  // namespace palpate
