#include "libfem/mesh/surface/surface_checks.hpp"

#include <algorithm>

#include "libfem/mesh/repair/cgal_steps.hpp"
#include "libfem/mesh/repair/facts.hpp"
#include "libfem/mesh/topology.hpp"
#include "libfit/core/text.hpp"

namespace palpate {
namespace {

double one_sided_deviation_m(const Surface& from, const Surface& to, const BoxTree& boxes) {
  double largest = 0;
  const auto sample = [&](const Vec3& p) {
    if (const auto hit = closest_point(to, boxes, p)) largest = std::max(largest, hit->distance_m);
  };
  for (Eigen::Index f = 0; f < from.triangles.rows(); ++f) {
    Vec3 corner[3];
    for (int k = 0; k < 3; ++k) corner[k] = from.vertices.row(from.triangles(f, k));
    for (int k = 0; k < 3; ++k) {
      const int next = (k + 1) % 3;
      if (from.triangles(f, k) > from.triangles(f, next)) continue;  // once per edge, when closed
      sample(corner[k]);
      sample((corner[k] + corner[next]) / 2);
    }
    sample((corner[0] + corner[1] + corner[2]) / 3);
  }
  return largest;
}

}  // namespace

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

Surface crossing_part(const Surface& surface) {
  std::vector<std::size_t> triangles;
  for (const auto& [a, b] : repair::self_intersections(surface))
    triangles.insert(triangles.end(), {a, b});
  sort_unique(triangles);
  return {surface.vertices, surface.triangles(triangles, Eigen::all)};
}

double deviation_m(const Surface& a, const BoxTree& boxes_of_a, const Surface& b) {
  return std::max(one_sided_deviation_m(b, a, boxes_of_a),
                  one_sided_deviation_m(a, b, triangle_boxes(b)));
}

}  // namespace palpate
