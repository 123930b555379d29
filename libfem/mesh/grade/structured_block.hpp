#pragma once

#include <array>

#include "libfit/core/tet_mesh.hpp"

namespace palpate::fem {

/// A box [0, size] filled with cells[0] x cells[1] x cells[2] bricks of six tets each.
/// size_m: edges of the box [m]. Node (i, j, k) is row i + (nx+1) (j + (ny+1) k). Bricks are mirror
/// images of their neighbours, so the mesh is symmetric about every brick wall and bisection of its
/// longest edges makes three shapes only. Throws Error unless sizes and cells are positive.
/// Source: triangulation J1 of Todd 1976 (doi:10.1007/978-3-642-50327-6), bricks split as by Kuhn.
TetMesh structured_block(const Vec3& size_m, const std::array<int, 3>& cells);

}  // namespace palpate::fem
