#pragma once

#include <functional>

#include "libfit/core/geometry.hpp"

namespace palpate::bodies {

/// A field that is negative inside a body, its gradient about 1 near the surface; lengths in mm.
using Field = std::function<double(const Vec3& x_mm)>;

/// What the mesh of a field must satisfy; lengths in mm.
struct ImplicitMeshOptions {
  double reach_mm = 130;      ///< the body lies in the ball of this radius about the origin
  double radius_mm = 3;       ///< circumradius of triangles, at most
  double distance_mm = 0.2;   ///< of a triangle's circumcentre to the surface, at most
  int smoothing_passes = 10;  ///< vertices to the middle of their neighbours, along the surface
};

/// An even triangle mesh of the surface field = 0, closed and outward.
/// Delaunay refinement with angles of 30 degrees or more (Boissonnat and Oudot 2005,
/// doi:10.1016/j.gmod.2005.01.004, in CGAL), then smoothing with every vertex put back on the
/// surface. Vertices are sorted by position, so the order does not depend on the mesher's memory.
Surface mesh_of_field(const Field& field, const ImplicitMeshOptions& options);

/// Whether two triangles of a surface cross or overlap.
bool crosses_itself(const Surface& surface);

}  // namespace palpate::bodies
