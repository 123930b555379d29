#pragma once

#include "libfit/core/geometry.hpp"

namespace palpate {

/// A triangulated surface at rest. vertices #V x 3 [m], triangles #F x 3.
/// Plain data: a reader may fill it with anything; `libfem/mesh` mends it or refuses it.
struct Surface {
  Points vertices;
  Triangles triangles;
};

/// Outward unit normal of each vertex, weighted by the angle of its triangles (Thuermer and
/// Wuethrich 1998, doi:10.1080/10867651.1998.10487487), so it does not depend on how a flat
/// neighbourhood is triangulated. #V x 3; zero where a vertex has no triangle with area.
Points vertex_normals(const Surface& surface);

/// Sum of triangle areas [m^2].
double area_m2(const Surface& surface);

/// Signed volume [m^3] by the divergence theorem about the first vertex; > 0 when a closed
/// surface points outward. Meaningless for open surfaces.
double volume_m3(const Surface& surface);

/// Extent of the axis-aligned bounding box [m]; zero without vertices.
Vec3 extent_m(const Points& points);

}  // namespace palpate
