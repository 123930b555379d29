#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
#include <vector>

namespace palpate {

inline constexpr double kInfinity = std::numeric_limits<double>::infinity(),
                        kNan = std::numeric_limits<double>::quiet_NaN();

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;

/// # x 3, one point or vector per row. Positions in m unless a name says otherwise.
using Points = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
/// # x 3 vertex indices, counter-clockwise seen from outside the body.
using Triangles = Eigen::Matrix<std::int32_t, Eigen::Dynamic, 3, Eigen::RowMajor>;
/// # x 4 node indices, positive volume: (n1-n0) x (n2-n0) . (n3-n0) > 0.
using Tets = Eigen::Matrix<std::int32_t, Eigen::Dynamic, 4, Eigen::RowMajor>;

/// A triangulated surface at rest. vertices #V x 3 [m], triangles #F x 3.
/// Plain data: a reader may fill it with anything; `libfem/mesh` mends it or refuses it.
struct Surface {
  Points vertices;
  Triangles triangles;
};

/// Corners of triangle f [m].
inline std::array<Vec3, 3> corners_of(const Surface& surface, Eigen::Index f) {
  const auto corner = surface.triangles.row(f);
  return {surface.vertices.row(corner[0]), surface.vertices.row(corner[1]),
          surface.vertices.row(corner[2])};
}

/// Outward unit normal of each vertex, weighted by the angle of its triangles (Thuermer and
/// Wuethrich 1998, doi:10.1080/10867651.1998.10487487), so it does not depend on how a flat
/// neighbourhood is triangulated. #V x 3; zero where a vertex has no triangle with area.
Points vertex_normals(const Surface& surface);

/// Sum of triangle areas [m^2].
double area_m2(const Surface& surface);

/// Signed volume [m^3] by the divergence theorem about the first vertex; > 0 when a closed
/// surface points outward. Meaningless for open surfaces.
double volume_m3(const Surface& surface);

/// Extent of the axis-aligned bounding box [m]; zero without vertices.
Vec3 extent_m(const Points& points);

/// True if the first points of two lists, as many as the shorter has, are the same but for their
/// rounding to float.
bool begin_alike(const Points& a, const Points& b);

/// Patches of vertices that hang together over edges whose ends are both in, each ascending; in the
/// order of their first vertices.
std::vector<std::vector<std::int32_t>> patches_of(const Surface& surface,
                                                  const std::vector<char>& is_in);

/// A volume filled with four-node tetrahedra at rest. nodes #N x 3 [m], tets #T x 4, positive.
/// Quadratic nodes are made by the solver. region: #T, index of the tet's material (0: the body's
/// own); empty means all 0.
struct TetMesh {
  Points nodes;
  Tets tets;
  Eigen::VectorXi region;
};

/// The nearest float, as a double. Through memory: g++ 12.2 at -O3 drops the two casts for some
/// vectors of fixed size (`.cast<float>().cast<double>()`), and what is written as float then
/// differs from what was scored.
inline double rounded_to_float(double value) {
  const volatile float rounded = static_cast<float>(value);
  return static_cast<double>(rounded);
}

/// The same for each entry of a matrix of doubles.
template <class Derived>
typename Derived::PlainObject rounded_to_float(const Eigen::MatrixBase<Derived>& values) {
  return values.unaryExpr([](double value) { return rounded_to_float(value); });
}

/// A partition of 0 .. size - 1 that grows coarser; the root of a set is its least member.
/// Source: Tarjan and van Leeuwen, Worst-case analysis of set union algorithms (1984), path
/// halving.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t size) : parent_(size) {
    std::iota(parent_.begin(), parent_.end(), std::size_t{0});
  }
  std::size_t find(std::size_t member) {
    while (parent_[member] != member) member = parent_[member] = parent_[parent_[member]];
    return member;
  }
  void join(std::size_t a, std::size_t b) {
    const auto [low, high] = std::minmax({find(a), find(b)});
    parent_[high] = low;
  }

 private:
  std::vector<std::size_t> parent_;
};

}  // namespace palpate
