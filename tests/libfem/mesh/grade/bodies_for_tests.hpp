#pragma once

#include "libfit/core/geometry.hpp"
#include "tests/support/surfaces.hpp"

namespace palpate::fem {

using testing_support::icosphere;

/// A star-shaped surface's triangles joined to a centre inside, node 0; vertex v is node v + 1.
TetMesh star(const Surface& surface, const Vec3& centre);

/// The star of an icosphere.
TetMesh tet_ball(double radius_m, int levels);

/// Closed cylinder about the z axis from 0 to length, `around` x `along` quads, capped by fans.
Surface cylinder(double radius_m, double length_m, int around, int along);

/// The boundary of a tet mesh, with its own copy of the boundary's vertices.
Surface boundary_surface(const TetMesh& mesh);

}  // namespace palpate::fem
