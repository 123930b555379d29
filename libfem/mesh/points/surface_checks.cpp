#include "libfem/mesh/points/surface_checks.hpp"

#include <algorithm>
#include <utility>
#include <vector>

namespace palpate {
namespace {

using DirectedEdge = std::pair<std::int32_t, std::int32_t>;

std::vector<DirectedEdge> sorted_edges(const Triangles& triangles) {
  std::vector<DirectedEdge> edges;
  edges.reserve(static_cast<std::size_t>(3 * triangles.rows()));
  for (const auto& t : triangles.rowwise())
    for (int k = 0; k < 3; ++k) edges.emplace_back(t[k], t[(k + 1) % 3]);
  std::sort(edges.begin(), edges.end());
  return edges;
}

/// Vertices whose triangles form more than one fan: the walk around from one triangle misses some.
/// Edges must be manifold and closed.
int count_pinched_vertices(const Surface& surface) {
  const auto& triangles = surface.triangles;
  struct Corner {
    std::int32_t vertex, from, to;  ///< triangle (vertex, from, to)
  };
  std::vector<Corner> corners;
  for (const auto& t : triangles.rowwise())
    for (int k = 0; k < 3; ++k) corners.push_back({t[k], t[(k + 1) % 3], t[(k + 2) % 3]});
  std::sort(corners.begin(), corners.end(), [](const Corner& a, const Corner& b) {
    return std::pair(a.vertex, a.from) < std::pair(b.vertex, b.from);
  });
  int pinched = 0;
  for (std::size_t first = 0, end; first < corners.size(); first = end) {
    for (end = first; end < corners.size() && corners[end].vertex == corners[first].vertex;) ++end;
    std::size_t walked = 0;
    std::int32_t at = corners[first].from;
    do {
      const auto next = std::lower_bound(
          corners.begin() + static_cast<std::ptrdiff_t>(first),
          corners.begin() + static_cast<std::ptrdiff_t>(end), at,
          [](const Corner& c, std::int32_t from) { return c.from < from; });
      at = next->to;
      ++walked;
    } while (at != corners[first].from && walked <= end - first);
    pinched += walked != end - first;
  }
  return pinched;
}

std::string counted(std::size_t count, const char* singular, const char* plural) {
  return std::to_string(count) + " " + (count == 1 ? singular : plural);
}

}  // namespace

std::optional<std::string> why_not_closed(const Surface& surface) {
  const auto& triangles = surface.triangles;
  if (triangles.rows() == 0) return "it has no triangle";
  if (triangles.minCoeff() < 0 || triangles.maxCoeff() >= surface.vertices.rows())
    return "a triangle names a vertex that does not exist";
  if (!surface.vertices.allFinite()) return "a coordinate is not a finite number";

  const auto edges = sorted_edges(triangles);
  std::size_t repeated = 0, open = 0;
  for (std::size_t e = 0; e < edges.size(); ++e) {
    repeated += e > 0 && edges[e] == edges[e - 1];
    open += !std::binary_search(edges.begin(), edges.end(),
                                DirectedEdge{edges[e].second, edges[e].first});
  }
  if (repeated > 0)
    return counted(repeated, "edge is", "edges are") +
           " shared by more than two triangles or by two that face opposite ways";
  if (open > 0) return counted(open, "edge lies", "edges lie") + " on a border";
  if (const int pinched = count_pinched_vertices(surface); pinched > 0)
    return counted(static_cast<std::size_t>(pinched), "vertex joins", "vertices join") +
           " two sheets that otherwise do not touch";
  if (!(volume_m3(surface) > 0)) return "it points inward: its volume is not positive";
  return std::nullopt;
}

}  // namespace palpate
