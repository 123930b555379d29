#pragma once

#include <vector>

#include "libfit/core/surface.hpp"

namespace palpate {

/// Where a point enters the edge graph: a vertex and how far it is [m].
struct EdgePathSeed {
  std::int32_t vertex = 0;
  double distance_m = 0;
};
using EdgePathSeeds = std::vector<EdgePathSeed>;

/// Shortest paths along the edges of a surface (Dijkstra 1959, doi:10.1007/BF01386390): an upper
/// bound of distances on the surface, and infinite between parts that do not touch.
class EdgePaths {
 public:
  explicit EdgePaths(const Surface& surface);

  /// #V: which source is nearest along the surface, the lowest index among equals; -1 where none
  /// leads. A source without seeds owns nothing. O(V log V).
  std::vector<std::int32_t> nearest_source(const std::vector<EdgePathSeeds>& sources) const;

  /// Vertices within `most_m` of one source, and its seeds whatever their distance; ascending.
  /// Work grows with the vertices found.
  std::vector<std::int32_t> within(const EdgePathSeeds& source, double most_m);

 private:
  template <class Visit>
  void for_each_neighbour(std::int32_t vertex, const Visit& visit) const;

  const Surface& surface_;
  std::vector<std::int32_t> first_, neighbour_;  // compressed rows: neighbours of each vertex
  std::vector<double> distance_;                 // of `within`, infinite between calls
};

}  // namespace palpate
