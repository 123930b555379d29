#pragma once

#include <span>
#include <vector>

#include "libfit/core/body.hpp"
#include "libfit/core/curves.hpp"

namespace palpate {

/// Lists of numbers in one array (compressed rows).
class NumberLists {
 public:
  std::span<const std::int32_t> of(std::int32_t list) const {
    return {number_.data() + first_[list], number_.data() + first_[list + 1]};
  }

 protected:
  /// A list for each vertex: number(t, k, i), i < each, of its corner k of triangle t.
  template <class Number>
  NumberLists(const Triangles& triangles, Eigen::Index vertices, int each, const Number& number)
      : first_(vertices + 1), number_(triangles.size() * each) {
    for (const std::int32_t v : triangles.reshaped()) first_[v + 1] += each;
    for (std::size_t v = 1; v < first_.size(); ++v) first_[v] += first_[v - 1];
    std::vector<std::int32_t> next(first_.begin(), first_.end() - 1);
    for (std::int32_t t = 0; t < triangles.rows(); ++t)
      for (int k = 0; k < 3; ++k)
        for (int i = 0; i < each; ++i) number_[next[triangles(t, k)]++] = number(t, k, i);
  }
  std::vector<std::int32_t> first_, number_;
};

/// The triangles at each vertex, ascending.
struct TrianglesAt : NumberLists {
  TrianglesAt(const Triangles& triangles, Eigen::Index vertices)
      : NumberLists(triangles, vertices, 1, [](int t, int, int) { return t; }) {}
};

/// The vertices that share an edge with each vertex of a triangulation: ascending, each once.
struct Neighbours : NumberLists {
  Neighbours(const Triangles& triangles, Eigen::Index vertices);
};

/// Entry of a point into the edge graph: a vertex and its distance [m].
struct EdgePathSeed {
  std::int32_t vertex = 0;
  double distance_m = 0;
};
using EdgePathSeeds = std::vector<EdgePathSeed>;

/// Which source is nearest to each vertex along the surface, and how far it is.
/// source #V: -1 where none leads. distance_m #V [m]: infinite there.
struct NearestSource {
  std::vector<std::int32_t> source;
  std::vector<double> distance_m;
};

/// Shortest paths along the edges of a surface from all sources at once (Dijkstra 1959,
/// doi:10.1007/BF01386390): an upper bound of distances on the surface, and infinite between parts
/// that do not touch. Among equals the lowest source. A source without seeds owns nothing.
/// O(V log V).
NearestSource nearest_source(const Surface& surface, const std::vector<EdgePathSeeds>& sources);

/// Cosine of 75 degrees, between normals that go together: passes the chords of a coarse
/// triangulation and refuses the other side of a thin part.
inline constexpr double kMinCosine = 0.25881904510252074;

/// True where a normal, of any length, is within acos(cosine) of a unit vector.
inline bool faces_alike(const Vec3& normal, const Vec3& unit, double cosine = kMinCosine) {
  return normal.dot(unit) > cosine * normal.norm();
}

/// Blend of three rows.
template <class Corners>
Vec3 blended(const Points& rows, const Corners& corners, const Vec3& weight) {
  Vec3 out = Vec3::Zero();
  for (int k = 0; k < 3; ++k) out += weight[k] * rows.row(corners[k]).transpose();
  return out;
}

/// The place of each test point on the surface: the corners of the nearest triangle whose
/// interpolated normal is within acos(min_cosine) of the point's. position, inward: P x 3.
/// outward_normal: #V x 3 of the surface. No seed for a point farther than max_m from the surface.
std::vector<EdgePathSeeds> place_on_surface(const Points& position, const Points& inward,
                                            const Surface& surface, const Points& outward_normal,
                                            double min_cosine, double max_m);

/// Test-point triangles dual to the cells of nearest test points: a fine triangle whose vertices
/// belong to three points joins them. cell: #V, the nearest point along the surface. Same
/// orientation as the surface; a triangle facing against the normals of its points (it closes the
/// surface behind the outermost ones) is dropped. Each once, ascending.
Triangles triangulate_over(const Surface& surface, const std::vector<std::int32_t>& cell,
                           const Points& position, const Points& inward);

/// The triangles of the test points, over rows of `position` instead: points are paired by position
/// within 1e-6 of `size_m` (the body's diagonal). position P x 3 [m].
/// Empty when the pairing is not one to one: then the points are not the body's own.
Triangles match_triangles(const Points& position, const TestPoints& points, double size_m);

/// The test points that answer for each fine vertex, and their weights. V rows; a row of zero
/// weights is a vertex that nothing answers for.
struct Blend {
  Triangles point;
  Points weight;
  double largest_projection_m = 0;
};

/// Area coordinates of each wanted vertex on its test-point triangle: the nearest one that faces
/// alike and is not too far, among those around the point that is nearest along the surface (two
/// rings). is_usable: per point; the weight of an unusable corner goes to the others. seeds: per
/// point, where it sits on the surface (none for points left out).
Blend blend_by_area(const FittedCurves& curves, const Surface& fine, const Points& outward_normal,
                    const std::vector<char>& is_wanted, const Triangles& triangles,
                    const std::vector<char>& is_usable, const std::vector<EdgePathSeeds>& seeds);

/// All weight on the point that is nearest along the surface. cell: #V, -1 for none.
Blend blend_by_cell(const std::vector<std::int32_t>& cell, const std::vector<char>& is_wanted);

}  // namespace palpate
