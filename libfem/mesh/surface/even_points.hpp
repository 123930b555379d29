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

/// Lets the vertices of a decimated surface hop among the vertices of the part they were chosen
/// from, towards the middle of their neighbours, and flips edges, for a few rounds.
/// part: the surface before decimation; normals: per vertex of it, outward; may_stand: per vertex
/// of it, where vertices may hop, and leave others for the nearest such; `origin`: index in it
/// of each mesh vertex, kept up to date. Borders stay borders. No triangle is folded over.
void even_out(HalfEdgeMesh& mesh, const Surface& part, const Points& normals,
              const std::vector<char>& may_stand, OpenMesh::VPropHandleT<int> origin);

}  // namespace palpate
