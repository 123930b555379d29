#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "libfit/core/closest_point.hpp"
#include "libfit/core/geometry.hpp"

namespace palpate {

/// Corners of a tetrahedron [m], in the order of `Tets`.
using TetCorners = std::array<Vec3, 4>;

TetCorners corners_of(const TetMesh& mesh, Eigen::Index tet);

/// Six times the signed volume [m^3].
inline double six_volumes(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  return (b - a).cross(c - a).dot(d - a);
}

/// Signed volume [m^3]; positive in the order of `Tets`.
double tet_volume_m3(const TetCorners& corner);

/// Smallest of the six angles between faces [deg]; 70.5 in a regular tetrahedron, 0 when flat.
double min_dihedral_deg(const TetCorners& corner);

/// A mesh's worst elements. A tet below kSliverDeg is a sliver.
inline constexpr double kSliverDeg = 5;
struct TetQuality {
  double min_dihedral_deg = 0;
  double min_volume_m3 = 0;
  int slivers = 0;
  double volume_m3 = 0;
};
/// All zero for a mesh without tets.
TetQuality quality_of(const TetMesh& mesh);

/// The point of a volume (or of one tet) nearest to a query: weight of the tet's corners, sum 1.
struct VolumePoint {
  std::int32_t tet = -1;
  Eigen::Vector4d weight = Eigen::Vector4d::Zero();
  double distance_m = std::numeric_limits<double>::infinity();  ///< 0 inside
};

/// Nearest point of one tet, whose number is left at -1.
VolumePoint nearest_in_tet(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c,
                           const Vec3& d);

/// Nearest point among the tets whose nearest point `accept(VolumePoint)` takes, no farther than
/// max_m; of two as near, that of the lower tet. Empty when there is none. boxes: of the tets.
/// Thread-safe.
template <class Accept>
std::optional<VolumePoint> closest_in_volume(const TetMesh& volume, const BoxTree& boxes,
                                             const Vec3& query, double max_m, Accept&& accept) {
  std::optional<VolumePoint> hit;
  double squared_best = max_m * max_m;
  boxes.visit_nearest(query, squared_best, [&](std::int32_t t, double& best) {
    const auto corner = volume.tets.row(t);
    VolumePoint point =
        nearest_in_tet(query, volume.nodes.row(corner[0]), volume.nodes.row(corner[1]),
                       volume.nodes.row(corner[2]), volume.nodes.row(corner[3]));
    point.tet = t;
    const double squared = point.distance_m * point.distance_m;
    const bool is_better = squared < best || (squared == best && (!hit || t < hit->tet));
    if (!is_better || !accept(static_cast<const VolumePoint&>(point))) return;
    best = squared;
    hit = point;
  });
  return hit;
}

}  // namespace palpate

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
