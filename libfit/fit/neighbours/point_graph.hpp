#pragma once

#include <vector>

#include "libfit/core/geometry.hpp"

namespace palpate::fit {

/// Two neighbouring test points, first < second. weight: (h / distance)^2 with h the graph's median
/// distance of neighbours, so that what is penalised is a gradient along the surface.
struct PointEdge {
  std::int32_t first = 0, second = 0;
  double weight = 0;
};

/// Neighbours among the test points that take part, ascending. position: P x 3 [m], normal: P x 3
/// inward unit, takes_part: P. triangles: rows index the points; their edges are the neighbours.
/// Empty triangles: the Gabriel graph of the points on their surface (no third point within the
/// ball over the two), which is connected on each sheet and has no length to be chosen. Points
/// whose normals are more than 60 degrees apart are never neighbours and, without triangles, nor
/// are points one above the other (two sheets that face alike). O(P log P).
/// Source: Gabriel and Sokal 1969, doi:10.2307/2412323.
std::vector<PointEdge> point_graph(const Points& position, const Points& normal,
                                   const std::vector<char>& takes_part,
                                   const Triangles& triangles = {});

}  // namespace palpate::fit
