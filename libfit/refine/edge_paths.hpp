#pragma once

#include <span>
#include <vector>

#include "libfit/core/geometry.hpp"

namespace palpate {

/// The vertices that share an edge with each vertex of a triangulation: ascending, each once.
class Neighbours {
 public:
  Neighbours(const Triangles& triangles, Eigen::Index vertices);
  std::span<const std::int32_t> of(std::int32_t vertex) const {
    const auto v = static_cast<std::size_t>(vertex);
    return {vertex_.data() + first_[v], static_cast<std::size_t>(first_[v + 1] - first_[v])};
  }

 private:
  std::vector<std::int32_t> first_, vertex_;  // compressed rows
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
