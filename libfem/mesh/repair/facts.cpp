#include "libfem/mesh/repair/facts.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <string>

#include "libfem/mesh/repair/topology.hpp"
#include "libfit/core/error.hpp"

namespace palpate {

SurfaceFacts surface_facts(const Surface& surface) {
  SurfaceFacts facts;
  facts.vertices = surface.vertices.rows();
  facts.triangles = surface.triangles.rows();
  if (facts.triangles == 0) return facts;
  if (surface.triangles.minCoeff() < 0 || surface.triangles.maxCoeff() >= facts.vertices)
    throw Error("surface", "a triangle uses a vertex that is not there", "Read the mesh again.");

  const auto faces = repair::to_faces(surface.triangles);
  repair::for_each_edge(repair::sorted_sides(faces), [&](auto begin, auto end) {
    if (end - begin == 1) ++facts.border_edges;
    if (end - begin > 2) ++facts.non_manifold_edges;
    if (end - begin == 2 && begin->is_forward == (begin + 1)->is_forward) ++facts.unlike_edges;
  });
  const auto vertices = static_cast<std::size_t>(facts.vertices);
  std::vector<char> is_used(vertices, 0);
  for (const auto& face : faces)
    for (const auto corner : face) is_used[static_cast<std::size_t>(corner)] = 1;
  facts.unused_vertices = std::ranges::count(is_used, 0);
  facts.pinched_vertices =
      static_cast<std::int64_t>(repair::count_pinched_vertices(faces, vertices));
  const repair::Components parts = repair::components(faces);
  facts.components = static_cast<std::int64_t>(parts.number);
  std::vector<double> volume_m3(parts.number, 0);
  const Vec3 origin = surface.vertices.row(faces[0][0]);
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const auto corner = [&](std::size_t k) -> Vec3 {
      return surface.vertices.row(faces[f][k]).transpose() - origin;
    };
    volume_m3[parts.of_face[f]] += corner(0).dot(corner(1).cross(corner(2))) / 6;
  }
  facts.cavities = std::ranges::count_if(volume_m3, [](double volume) { return volume < 0; });
  facts.is_closed = facts.border_edges == 0 && facts.non_manifold_edges == 0;
  facts.is_manifold = facts.non_manifold_edges == 0 && facts.pinched_vertices == 0;
  facts.is_oriented = facts.non_manifold_edges == 0 && facts.unlike_edges == 0;
  facts.extent_m = extent_m(surface.vertices);
  facts.area_m2 = area_m2(surface);
  facts.volume_m3 = palpate::volume_m3(surface);
  return facts;
}

}  // namespace palpate
