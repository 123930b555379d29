#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "libfit/core/geometry.hpp"

namespace palpate {

/// Properties of a surface, as numbers to print or to decide by.
struct SurfaceFacts {
  std::int64_t vertices = 0, triangles = 0;
  std::int64_t components = 0;          ///< joined by edges
  std::int64_t cavities = 0;            ///< components of negative volume
  std::int64_t border_edges = 0;        ///< with one triangle
  std::int64_t non_manifold_edges = 0;  ///< with three or more triangles
  std::int64_t pinched_vertices = 0;    ///< where triangles meet that share no edge (bow ties)
  std::int64_t unlike_edges = 0;        ///< whose two triangles are oriented against each other
  bool is_closed = false;               ///< each edge has two triangles (and there is one)
  bool is_manifold = false;             ///< no non-manifold edge, no pinched vertex
  bool is_oriented = false;             ///< neighbours agree on a side
  Vec3 extent_m = Vec3::Zero();
  double area_m2 = 0;
  double volume_m3 = 0;  ///< signed, positive outward; means something only if closed and oriented
};

/// Facts of any surface, mended or not. Linear in its size, except for sorting edges.
SurfaceFacts surface_facts(const Surface& surface);

/// Why a surface bounds no volume, as a sentence's end ("3 edges lie on a border"), or nothing when
/// it is closed, 2-manifold, consistently oriented and points outward in all. By surface_facts;
/// self-intersection is not looked for.
std::optional<std::string> why_not_closed(const Surface& surface);

/// Mean length of a triangle's edges.
double mean_edge_m(const Surface& surface);

/// Triangles with the vertices that they use, in the order in which they do.
Surface compact(const Points& vertices, const Triangles& triangles);

/// The parts of a surface that share no vertex.
std::vector<Surface> parts_of(const Surface& surface);

/// Returns a closed surface without its cavities, the parts that point inward.
Surface outer_surface(const Surface& closed);

}  // namespace palpate
