#pragma once

#include <vector>

#include "libfem/mesh/surface/half_edge.hpp"

namespace palpate {

/// Decimates a half-edge surface to `count` of its vertices, evenly spaced, with OpenMesh.
/// normals: per vertex, outward unit. may_stand: per vertex; others are removed first. Guards
/// against flipped and needle triangles are loosened in stages until the count is reached or
/// topology forbids more. Leaves the mesh garbage-collected; `origin` follows each vertex to tell
/// its index at the start.
void decimate_evenly(HalfEdgeMesh& mesh, const Points& normals, const std::vector<char>& may_stand,
                     int count, OpenMesh::VPropHandleT<int> origin);

}  // namespace palpate
