#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "libfem/mesh/grade/smooth_surface.hpp"
#include "libfem/mesh/topology.hpp"
#include "libfit/core/geometry.hpp"

namespace palpate::fem {

/// A straight piece of the contact's path [m], from == to is a point, and how fine it wants the
/// mesh: max(h_m, growth * (distance - reach_m)).
struct Segment {
  Vec3 from = Vec3::Zero();
  Vec3 to = Vec3::Zero();
  double h_m = 0.004;  ///< tets are no larger around the piece
  double reach_m =
      0.008;  ///< distance kept that fine; 0: size is proportional to distance from h_m on
};

/// Wanted element size: size(x) is the least that any piece of the path wants.
/// A tet's own size is `tet_size_m`, compared with size(x) at its centroid.
/// Below half the contact radius, growth decides the force error more than h_m does.
struct GradeOptions {
  std::vector<Segment> path;  ///< where contact will be: the press, and each drag
  double growth = 0.45;       ///< size gained per distance; (0, 1]
  /// Material of a place, and how large tets that the border of two regions crosses may be, over
  /// size(x), before they are made to end there: as large as others, a lump is seen too coarsely.
  RegionAt region_at = {};
  double interface_share = 1;
  /// Tets may hold several regions where size(x) is larger.
  double interface_size_m = std::numeric_limits<double>::infinity();
  /// Held places: new nodes there are held, and nodes near the border of what is held are
  /// moved onto it (grade_steps.hpp). Empty: as the base's nodes are.
  HeldAt held_at = {};
  std::vector<char> halved = {};      ///< #base tets: parts are at most half as large; empty: none
  std::int32_t max_corners = 200000;  ///< refuses to make more corner nodes than this
};

/// The base mesh bisected where contact will be, with quadratic nodes on the smooth surface.
/// base: coarse tets [m], any conforming mesh. is_held: #base nodes. Returned regions are the
/// base's. Corner nodes come first, the base's own among them with their indices, then mid-edge
/// nodes.
///
/// Longest edges are halved until every tet is small enough and none has a halved edge: conforming
/// always. Boundary nodes are then moved onto the smooth surface as far as elements allow, the
/// inside follows, and with region_at tets of at most interface_size_m end at the border between
/// regions (grade_steps.hpp).
/// `deviation_m` is the largest offset that this left, `contact_deviation_m` the mean of that over
/// what a contact touches. Where a node in contact is off by more than a twentieth of the finest
/// h_m, corners are placed by `Placing::spread`, too, and whichever is nearer to the surface there
/// is taken. A new node is held when it lies on a boundary face or in a tet of the base whose
/// corners all are, or where held_at says so; so are nodes on the border of what held_at holds.
///
/// Throws Error on a tet that is not positive and when max_corners is passed. Depends on nothing
/// but its arguments; thread-safe.
QuadraticMesh grade_mesh(const TetMesh& base, const std::vector<char>& is_held,
                         const SmoothSurface& surface, const GradeOptions& options);

/// Size of a tet [m]: the edge of the cube that six of its volume fill, or, if larger, its longest
/// edge / sqrt(3) (the cube's diagonal), so that a flat tet cannot pass for a small one. A cube
/// split in six has its own edge as size, so h means what it means on a grid; a regular tet 0.89
/// edges.
double tet_size_m(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

/// The size that grading asks for at x [m] (M13a); see GradeOptions.
double wanted_size_m(const GradeOptions& options, const Vec3& x);

}  // namespace palpate::fem
