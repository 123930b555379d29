#pragma once

#include "libfem/mesh/surface/half_edge.hpp"

namespace palpate {

/// Lets the vertices of a decimated surface hop among the vertices of the part they were chosen
/// from, towards the middle of their neighbours, and flips edges, for a few rounds.
/// part: the surface before decimation; normals: per vertex of it, outward; `origin`: index in it
/// of each mesh vertex, kept up to date. Borders stay borders. No triangle is folded over.
void even_out(HalfEdgeMesh& mesh, const Surface& part, const Points& normals,
              OpenMesh::VPropHandleT<int> origin);

}  // namespace palpate
