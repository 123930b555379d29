#pragma once

#include <cstdint>
#include <vector>

#include "libfit/core/geometry.hpp"

namespace palpate::fem {

/// Corners of a tet's four faces, face k opposite corner k, outward counter-clockwise.
inline constexpr int kTetFace[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
/// Corners of a tet's six edges, in the order of a quadratic tet's mid-edge nodes.
inline constexpr int kTetEdge[6][2] = {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};

/// A face that only one tet has.
struct BoundaryFace {
  std::int32_t tet;
  int face;  ///< 0..3, opposite that corner
};

/// The faces of a tet mesh that belong to one tet, by tet and then face.
/// Throws Error when a face belongs to three tets or more.
std::vector<BoundaryFace> boundary_faces(const Tets& tets);

/// The boundary as triangles over the tet mesh's own nodes, outward counter-clockwise.
Triangles boundary_triangles(const Tets& tets);

}  // namespace palpate::fem
