#pragma once

#include <span>
#include <vector>

#include "libfit/core/geometry.hpp"

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

/// Where a point enters the edge graph: a vertex and how far it is [m].
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

}  // namespace palpate
