#include "libfem/mesh/repair/facts.hpp"

#include <Eigen/Geometry>
#include <algorithm>

#include "libfem/mesh/topology.hpp"
#include "libfit/core/text.hpp"

namespace palpate {

SurfaceFacts surface_facts(const Surface& surface) {
  SurfaceFacts facts;
  facts.vertices = surface.vertices.rows();
  facts.triangles = surface.triangles.rows();
  if (facts.triangles == 0) return facts;
  const Triangles& faces = surface.triangles;
  for_each_edge(sorted_sides(faces), [&](auto begin, auto end) {
    if (end - begin == 1) ++facts.border_edges;
    if (end - begin > 2) ++facts.non_manifold_edges;
    if (end - begin == 2 && begin->is_forward == (begin + 1)->is_forward) ++facts.unlike_edges;
  });
  facts.pinched_vertices = std::ssize(pinched_vertices(faces, facts.vertices));
  const Components parts = components(faces);
  facts.components = std::int64_t(parts.number);
  std::vector<double> volume_m3(parts.number, 0);
  const Vec3 origin = surface.vertices.row(faces(0, 0));
  for (Eigen::Index f = 0; f < faces.rows(); ++f) {
    const auto corner = [&](int k) -> Vec3 {
      return surface.vertices.row(faces(f, k)).transpose() - origin;
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

std::optional<std::string> why_not_closed(const Surface& surface) {
  if (surface.triangles.rows() == 0) return "it has no triangle";
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

double mean_edge_m(const Surface& surface) {
  double sum = 0;
  for (const auto& t : surface.triangles.rowwise())
    for (int k = 0; k < 3; ++k)
      sum += (surface.vertices.row(t[k]) - surface.vertices.row(t[(k + 1) % 3])).norm();
  return sum / static_cast<double>(3 * surface.triangles.rows());
}

Surface compact(const Points& vertices, const Triangles& triangles) {
  Surface out{{}, triangles};
  const auto used = renumber({out.triangles.data(), std::size_t(out.triangles.size())},
                             vertices.rows(), Numbering::by_use);
  out.vertices = vertices(used, Eigen::all);
  return out;
}

std::vector<Surface> parts_of(const Surface& surface) {
  std::vector<std::size_t> part_of(surface.vertices.rows());
  const auto patches = patches_of(surface, std::vector<char>(part_of.size(), 1));
  for (std::size_t p = 0; p < patches.size(); ++p)
    for (const std::int32_t v : patches[p]) part_of[v] = p;
  std::vector<std::vector<Eigen::Index>> faces(patches.size());
  for (Eigen::Index f = 0; f < surface.triangles.rows(); ++f)
    faces[part_of[surface.triangles(f, 0)]].push_back(f);
  std::vector<Surface> parts;
  for (const auto& list : faces)
    parts.push_back(compact(surface.vertices, surface.triangles(list, Eigen::all)));
  return parts;
}

Surface outer_surface(const Surface& closed) {
  const std::vector<char> is_lumen = faces_of_lumens(closed.vertices, closed.triangles);
  std::vector<Eigen::Index> faces;
  for (Eigen::Index f = 0; f < closed.triangles.rows(); ++f)
    if (!is_lumen[f]) faces.push_back(f);
  return compact(closed.vertices, closed.triangles(faces, Eigen::all));
}

}  // namespace palpate
