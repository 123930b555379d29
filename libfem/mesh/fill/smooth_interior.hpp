#pragma once

#include <functional>

#include "libfit/core/geometry.hpp"

namespace palpate {

/// Moves interior nodes so that the smallest dihedral angle around each grows, worst first; nodes
/// on the boundary stay. Never makes the smallest angle around a node smaller. Deterministic. After
/// Freitag and Ollivier-Gooch 1997, doi:10.1002/(SICI)1097-0207(19971115)40:21, with a pattern
/// search in place of their active-set descent.
void smooth_interior(TetMesh& mesh);

/// Pattern search over the axes and their diagonals, from a fifth of an edge down to a hundredth:
/// moves `at` to each place that `accepts`, which remembers what it accepted.
void search_place(Vec3& at, double edge_m, const std::function<bool(const Vec3&)>& accepts);

}  // namespace palpate
