#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "libfem/mesh/boundary.hpp"
#include "libfem/mesh/edge_map.hpp"
#include "libfem/mesh/grade/bisect.hpp"
#include "libfem/mesh/grade/smooth_surface.hpp"

namespace palpate::fem {

/// What a node of the boundary may do: inside ones follow, `smooth` ones go to the surface,
/// `crease` ones to the crease, `corner` ones (where creases meet) stay.
enum class NodeKind : std::int8_t { inside, smooth, crease, corner };

/// An edge of the boundary between two faces.
struct BoundaryEdge {
  std::int32_t a, b;
  Vec3 direction;  ///< sum of the base normals of its two faces
  bool is_crease;  ///< they meet at more than the crease angle
};

/// The boundary of a bisected mesh, as the base mesh shapes it.
struct Boundary {
  std::vector<BoundaryFace> faces;
  std::vector<BoundaryEdge> edges;
  EdgeMap edge_of;                ///< from two corner nodes to `edges`
  std::vector<NodeKind> kind;     ///< per corner node
  std::vector<Vec3> direction;    ///< per corner node: base normals weighted by face area
  std::vector<double> spacing_m;  ///< per base node: mean length of its boundary edges
};
Boundary classify_boundary(const TetMesh& base, const BisectedMesh& mesh);

/// Nodes on the surface, as far as elements allow.
struct NodePlacement {
  std::vector<Vec3> nodes;    ///< [m]
  std::vector<double> off_m;  ///< distance of each to where it should be; 0 inside
};

/// Where a boundary node near `guess` belongs: on the surface that faces `direction`, or on its
/// crease. Nothing if that is not known or farther than a third of `spacing_m`.
std::optional<Vec3> place_on(const SmoothSurface& surface, const Vec3& guess, NodeKind kind,
                             const Vec3& direction, double spacing_m);

/// How corner nodes are placed. by_birth: creases on creases, inside nodes in the middle of their
/// placed parents. spread: creases are not sought, and inside nodes go where the boundary's motion
/// spreads evenly (one sparse factorization); for where the first leaves nodes off the surface.
enum class Placing { by_birth, spread };

/// Corner nodes, each from the middle of its placed parents onto the surface; drawn back towards
/// the straight mesh where a tet would fall below a fifth of its volume.
NodePlacement place_corners(const BisectedMesh& mesh, const Boundary& boundary,
                            const SmoothSurface& surface, Placing placing);

/// Mid-edge nodes of boundary.edges, from the middle of the placed corners onto the surface; drawn
/// back where `smallest_jacobian` would fall below a fifth of the straight tet's.
NodePlacement place_middles(const BisectedMesh& mesh, const Boundary& boundary,
                            const std::vector<Vec3>& corners, const SmoothSurface& surface);

}  // namespace palpate::fem
