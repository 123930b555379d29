#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "libfit/core/closest_point.hpp"
#include "libfit/core/geometry.hpp"

namespace palpate {

/// Corners of a triangle.
using Triangle = std::array<std::int32_t, 3>;

/// A list of points, or of the corners of cells, as the rows of a matrix; a view.
template <class Row>
auto rows_of(const std::vector<Row>& list) {
  using Scalar = typename Row::value_type;
  constexpr int kWidth = sizeof(Row) / sizeof(Scalar);
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, kWidth, Eigen::RowMajor>;
  return Eigen::Map<const Matrix>(reinterpret_cast<const Scalar*>(list.data()), list.size(),
                                  kWidth);
}

/// Sorts and keeps one of each.
template <class List>
void sort_unique(List& list) {
  std::ranges::sort(list);
  list.erase(std::ranges::unique(list).begin(), list.end());
}

/// Flags cells that have the corners of an earlier one, in whatever order.
template <class Cell>
std::vector<char> repeats(std::vector<Cell> cells) {
  std::vector<std::pair<Cell, std::size_t>> sorted(cells.size());
  for (std::size_t c = 0; c < cells.size(); ++c) {
    std::ranges::sort(cells[c]);
    sorted[c] = {cells[c], c};
  }
  std::ranges::sort(sorted);
  std::vector<char> is_repeat(cells.size(), 0);
  for (std::size_t i = 1; i < sorted.size(); ++i)
    is_repeat[sorted[i].second] = sorted[i].first == sorted[i - 1].first;
  return is_repeat;
}

/// Renumbers the corners of cells without gaps and returns the old number of each new one: in the
/// order of first use, or ascending. corners: below `count`.
enum class Numbering { by_use, ascending };
std::vector<std::int32_t> renumber(std::span<std::int32_t> corners, std::size_t count,
                                   Numbering numbering);

/// A triangle's side from corner `corner` to the next, as its edge low-high.
struct TriangleSide {
  std::int32_t low, high;
  std::int32_t face;
  std::int8_t corner;
  bool is_forward;  ///< the triangle runs from low to high
};

/// All sides, those of one edge together; within an edge by face.
std::vector<TriangleSide> sorted_sides(const Eigen::Ref<const Triangles>& triangles);

/// Calls use(begin, end) with the sides of each edge of `sides`, which sorted_sides made.
template <typename Use>
void for_each_edge(const std::vector<TriangleSide>& sides, Use use) {
  for (auto begin = sides.begin(); begin != sides.end();) {
    auto end = begin + 1;
    while (end != sides.end() && end->low == begin->low && end->high == begin->high) ++end;
    use(begin, end);
    begin = end;
  }
}

/// Component of each face, numbered from 0 in the order of faces; faces that share an edge belong
/// together.
struct Components {
  std::vector<std::size_t> of_face;
  std::size_t number = 0;
};
Components components(const Eigen::Ref<const Triangles>& triangles);

/// Flags triangles of a closed surface whose component encloses a void: those of lumens.
std::vector<char> faces_of_lumens(const Points& vertices,
                                  const Eigen::Ref<const Triangles>& triangles);

/// Joins the corners (3 f + k) of two triangles at both ends of the edge that these sides share.
void join_fans(const Eigen::Ref<const Triangles>& triangles, const TriangleSide& a,
               const TriangleSide& b, DisjointSets& corners);

/// Sets of the corners of triangles, 3 f + k each: those at one vertex whose triangles share an
/// edge there, one after another, are one set, a fan.
DisjointSets corner_fans(const Eigen::Ref<const Triangles>& triangles);

/// Cells around each of `count` vertices, ascending.
template <class Cells>
std::vector<std::vector<std::int32_t>> cells_around(const Cells& cells, std::size_t count) {
  std::vector<std::vector<std::int32_t>> around(count);
  for (std::int32_t c = 0; c < cells.rows(); ++c)
    for (const std::int32_t v : cells.row(c)) around[v].push_back(c);
  return around;
}

/// Vertices below `count` whose triangles fall into several fans that share no edge there;
/// ascending.
std::vector<std::int32_t> pinched_vertices(const Eigen::Ref<const Triangles>& triangles,
                                           std::size_t count);

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

/// Index of the material that fills a place [m]; 0 is the body's own.
using RegionAt = std::function<int(const Vec3& rest_position)>;

/// True of held places of the body at rest [m]; a place of its boundary may be where the
/// inside beside it is not.
using HeldAt = std::function<bool(const Vec3& rest_position, bool is_on_boundary)>;

/// Ten-node tetrahedra at rest, what the solver works on.
/// nodes #N x 3 [m]. tets #T x 10: corners 0-3 as in `Tets`, then mid-edge nodes of
/// (0,1) (1,2) (2,0) (0,3) (1,3) (2,3). faces #F x 6: boundary triangles, corners 0-2 outward
/// counter-clockwise, then mid-edge nodes of (0,1) (1,2) (2,0). Mid-edge nodes need not be halfway:
/// where the boundary is curved they lie on it (isoparametric).
/// region: #T, index of the tet's material (0: the body's own); empty means all 0.
/// base: #T, the tet of the base mesh that each is a part of.
/// is_held: #N, displacement fixed to zero. deviation_m: largest distance between a boundary node
/// and the surface it should lie on, where it could not be moved there without spoiling an element;
/// contact_deviation_m: the mean over the nodes that one contact touches, where the mesh is finest,
/// largest of the contacts, which acts on a force.
struct QuadraticMesh {
  Points nodes;
  Eigen::Matrix<std::int32_t, Eigen::Dynamic, 10, Eigen::RowMajor> tets;
  Eigen::Matrix<std::int32_t, Eigen::Dynamic, 6, Eigen::RowMajor> faces;
  std::vector<char> is_held;
  double deviation_m = 0;
  double contact_deviation_m = 0;
  Eigen::VectorXi region;
  std::vector<std::int32_t> base;
};

}  // namespace palpate::fem
