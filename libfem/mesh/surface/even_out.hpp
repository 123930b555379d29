#pragma once

#include <vector>

#include "libfem/mesh/surface/half_edge.hpp"

namespace palpate {

/// Lets the vertices of a decimated surface hop among the vertices of the part they were chosen
/// from, towards the middle of their neighbours, and flips edges, for a few rounds.
/// part: the surface before decimation; normals: per vertex of it, outward; may_stand: per vertex
/// of it, where vertices may hop, and leave others for the nearest such; `origin`: index in it
/// of each mesh vertex, kept up to date. Borders stay borders. No triangle is folded over.
void even_out(HalfEdgeMesh& mesh, const Surface& part, const Points& normals,
              const std::vector<char>& may_stand, OpenMesh::VPropHandleT<int> origin);

}  // namespace palpate
