#include "libfem/mesh/surface/surface_checks.hpp"

#include "libfem/mesh/repair/cgal_steps.hpp"
#include "libfem/mesh/repair/facts.hpp"
#include "libfit/core/text.hpp"

namespace palpate {
std::optional<std::string> why_not_closed(const Surface& surface) {
  const auto& triangles = surface.triangles;
  if (triangles.rows() == 0) return "it has no triangle";
  if (triangles.minCoeff() < 0 || triangles.maxCoeff() >= surface.vertices.rows())
    return "a triangle names a vertex that does not exist";
  if (!surface.vertices.allFinite()) return "a coordinate is not a finite number";

  const SurfaceFacts facts = surface_facts(surface);
  if (facts.border_edges > 0)
    return counted(facts.border_edges, "edge lies", "edges lie") + " on a border";
  if (facts.non_manifold_edges > 0)
    return counted(facts.non_manifold_edges, "edge has", "edges have") + " over two triangles";
  if (facts.unlike_edges > 0)
    return counted(facts.unlike_edges, "edge joins", "edges join") +
           " triangles that face opposite ways";
  if (facts.pinched_vertices > 0)
    return counted(facts.pinched_vertices, "vertex joins", "vertices join") +
           " two sheets that otherwise do not touch";
  if (!(facts.volume_m3 > 0)) return "it points inward: its volume is not positive";
  return std::nullopt;
}

bool is_self_intersecting(const Surface& surface) {
  return !repair::self_intersections(surface).empty();
}

}  // namespace palpate
