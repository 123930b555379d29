#pragma once

#include "libfit/core/surface.hpp"

namespace palpate {

/// Whether two triangles of a closed manifold surface meet anywhere but in a shared edge or
/// vertex, decided exactly. True as well when the surface is not manifold.
/// Source: CGAL 5.5, Polygon_mesh_processing/self_intersections.h.
bool is_self_intersecting(const Surface& surface);

}  // namespace palpate
