#pragma once

#include <array>

#include "libfit/core/geometry.hpp"

namespace palpate::fem {

/// A box [0, size] filled with cells[0] x cells[1] x cells[2] bricks of six tets each.
/// size_m: edges of the box [m]. Node (i, j, k) is row i + (nx+1) (j + (ny+1) k). Bricks are mirror
/// images of their neighbours, so the mesh is symmetric about every brick wall and bisection of its
/// longest edges makes three shapes only. Throws Error unless sizes and cells are positive.
/// Source: triangulation J1 of Todd 1976 (doi:10.1007/978-3-642-50327-6), bricks split as by Kuhn.
TetMesh structured_block(const Vec3& size_m, const std::array<int, 3>& cells);

/// The square [-1, 1] x [-1, 1] bent to the unit disc: straight near the middle, its border the
/// circle. Gives the factor by which (x, y) moves towards or away from the middle.
double square_to_disc(double x, double y);

/// A cylinder of height_m with its top in z = 0 about the z axis: a structured block of
/// across x across x layers bricks, each layer bent to a disc of radius_m. Throws Error as
/// structured_block.
TetMesh structured_cylinder(double radius_m, double height_m, int across, int layers);

}  // namespace palpate::fem
