#pragma once

#include <array>
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

/// A face of a tet by its corners. is_even: the order outward is an even permutation of `sorted`;
/// two positive tets lie on opposite sides of a face that they share exactly when it differs.
struct TetFace {
  std::array<std::int32_t, 3> sorted;
  BoundaryFace of;
  bool is_even;
};

/// All faces of tets, those with the same corners together; among them by tet.
std::vector<TetFace> sorted_faces(const Eigen::Ref<const Tets>& tets);

/// Calls use(begin, end) with the faces of the same corners of `faces`, which sorted_faces made.
template <typename Use>
void for_each_face(const std::vector<TetFace>& faces, Use use) {
  for (auto begin = faces.begin(); begin != faces.end();) {
    auto end = begin + 1;
    while (end != faces.end() && end->sorted == begin->sorted) ++end;
    use(begin, end);
    begin = end;
  }
}

/// The faces of a tet mesh that belong to one tet, by tet and then face.
/// Throws Error when a face belongs to three tets or more.
std::vector<BoundaryFace> boundary_faces(const Tets& tets);

/// The boundary as triangles over the tet mesh's own nodes, outward counter-clockwise.
Triangles boundary_triangles(const Tets& tets);

}  // namespace palpate::fem
