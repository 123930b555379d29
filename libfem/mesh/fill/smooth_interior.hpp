#pragma once

#include "libfit/core/geometry.hpp"

namespace palpate {

/// Moves interior nodes so that the smallest dihedral angle around each grows, worst first; nodes
/// on the boundary stay. Never makes the smallest angle around a node smaller. Deterministic. After
/// Freitag and Ollivier-Gooch 1997, doi:10.1002/(SICI)1097-0207(19971115)40:21, with a pattern
/// search in place of their active-set descent.
void smooth_interior(TetMesh& mesh);

}  // namespace palpate
