#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "libfem/mesh/grade/grade_mesh.hpp"
#include "libfem/mesh/grade/smooth_surface.hpp"
#include "libfem/mesh/topology.hpp"

namespace palpate::fem {

/// From an edge {a, b} in either order to an index >= 0.
/// Open addressing in flat arrays: a few nanoseconds a look-up, no allocation per edge.
class EdgeMap {
 public:
  explicit EdgeMap(std::size_t expected = 64) {
    std::size_t slots = 64;
    while (slots < 2 * expected) slots *= 2;
    slots_.resize(slots);
  }

  /// Index of the edge, or -1.
  std::int32_t find(std::int32_t a, std::int32_t b) const {
    return slots_[slot_of(key_of(a, b))].value;
  }

  /// Index of the edge, and whether it is new; a new edge gets `value`.
  std::pair<std::int32_t, bool> insert(std::int32_t a, std::int32_t b, std::int32_t value) {
    if (2 * (size_ + 1) > slots_.size()) grow();
    const std::uint64_t key = key_of(a, b);
    Slot& slot = slots_[slot_of(key)];
    if (slot.value >= 0) return {slot.value, false};
    slot = {key, value};
    ++size_;
    return {value, true};
  }

 private:
  struct Slot {
    std::uint64_t key = 0;
    std::int32_t value = -1;
  };

  static std::uint64_t key_of(std::int32_t a, std::int32_t b) {
    const auto [low, high] = std::minmax(a, b);
    return (static_cast<std::uint64_t>(low) << 32) | static_cast<std::uint32_t>(high);
  }

  // Finalizer of splitmix64 (Steele, Lea and Flood 2014): neighbouring keys scatter.
  std::size_t slot_of(std::uint64_t key) const {
    std::uint64_t h = key;
    h = (h ^ (h >> 30)) * 0xbf58476d1ce4e5b9ULL;
    h = (h ^ (h >> 27)) * 0x94d049bb133111ebULL;
    std::size_t slot = (h ^ (h >> 31)) & (slots_.size() - 1);
    while (slots_[slot].value >= 0 && slots_[slot].key != key)
      slot = (slot + 1) & (slots_.size() - 1);
    return slot;
  }

  void grow() {
    std::vector<Slot> old(2 * slots_.size());
    old.swap(slots_);
    for (const Slot& slot : old)
      if (slot.value >= 0) slots_[slot_of(slot.key)] = slot;
  }

  std::vector<Slot> slots_;
  std::size_t size_ = 0;
};

/// Positions of a quadratic tet's ten nodes [m], in the order of QuadraticMesh.
using TetNodes = std::array<Vec3, 10>;

/// det dx/dxi [m^3] of a quadratic tet at volume coordinates `at` (sum 1); 6 V when straight.
double jacobian_determinant(const TetNodes& nodes, const Eigen::Vector4d& at);

/// Smallest determinant [m^3] over the 4 quadrature points, the 4 corners and the centroid.
double smallest_jacobian(const TetNodes& nodes);

/// A tet and its origin in the base mesh.
struct BisectedTet {
  std::array<std::int32_t, 4> node;
  std::array<std::int32_t, 4> face;  ///< opposite each corner: base boundary face, -1 inside
  std::int32_t base;                 ///< tet of the base mesh it is part of
};

/// A bisected mesh with its family tree; straight: base facets stay flat.
struct BisectedMesh {
  std::vector<Vec3> nodes;                           ///< the base's first [m]
  std::vector<std::array<std::int32_t, 2>> parents;  ///< of node base_nodes + i: the edge it split
  std::vector<BisectedTet> tets;
  std::vector<BoundaryFace> base_faces;  ///< of the base mesh: what `face` indexes
  std::int32_t base_nodes = 0;
};

/// Longest-edge bisection until every tet satisfies the options and no edge hangs.
/// Longest by length rounded to float, then by node numbers: a strict order of all edges, which is
/// what makes neighbours agree and the propagation end. Throws Error past options.max_corners.
BisectedMesh bisect(const TetMesh& base, const GradeOptions& options);

/// Motion that a node of the boundary is allowed: inside ones follow, `smooth` ones go to the
/// surface, `crease` ones to the crease, `corner` ones (where creases meet) stay.
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
  std::vector<Vec3> nodes;       ///< [m]
  std::vector<double> offset_m;  ///< distance of each to where it should be; 0 inside
};

/// Place of a boundary node near `guess`: on the surface that faces `direction`, or on its
/// crease. Nothing if that is not known or farther than a third of `spacing_m`.
std::optional<Vec3> place_on(const SmoothSurface& surface, const Vec3& guess, NodeKind kind,
                             const Vec3& direction, double spacing_m);

/// Order of placing corner nodes. by_birth: creases on creases, inside nodes in the middle of their
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

/// Share of the segment from a to b at which region_at changes, a's own region before it, to
/// 2^-halvings (4e-9); `limit` where it is no nearer.
double region_change(const RegionAt& region_at, const Vec3& a, const Vec3& b, double limit = 1,
                     int halvings = 28);

/// Makes tets lie on one side of the border between regions (after Labelle and Shewchuk 2007,
/// doi:10.1145/1276377.1276448): inside nodes within half an edge of the border are moved onto it,
/// then edges that still cross it are split there, with all tets around them. placed: the nodes of
/// `mesh` on the surface. Nodes that are new are appended to both; on the boundary they go to the
/// surface as others do. `boundary` is that of the mesh before and stale afterwards.
/// Where the border turns within a tet, or is crossed twice by an edge, the corners do not see it
/// and the tet holds two regions.
void conform_to_regions(BisectedMesh& mesh, NodePlacement& placed, const Boundary& boundary,
                        const SmoothSurface& surface, const GradeOptions& options);

/// Makes the border of what is held a border of elements, as far as nodes can move: of each edge
/// that crosses it the nearer end is moved onto it, where no tet is spoilt; nodes of the surface go
/// along its edges, those of creases along creases. No edge is split: what is held does not move,
/// and elements in it have no influence. Returns which corner nodes are on the border.
std::vector<char> conform_to_held(const BisectedMesh& mesh, NodePlacement& placed,
                                  const Boundary& boundary, const SmoothSurface& surface,
                                  const HeldAt& held_at);

/// Moves mid-edge nodes from `first` on whose edges lie in the border onto it, where no element is
/// spoilt.
void curve_borders(QuadraticMesh& mesh, std::int32_t first, const RegionAt& region_at);

}  // namespace palpate::fem
