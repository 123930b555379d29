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
  facts.pinched_vertices = static_cast<std::int64_t>(
      repair::count_pinched_vertices(faces, static_cast<std::size_t>(facts.vertices)));
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

double mean_edge_m(const Surface& surface) {
  double sum = 0;
  for (const auto& t : surface.triangles.rowwise())
    for (int k = 0; k < 3; ++k)
      sum += (surface.vertices.row(t[k]) - surface.vertices.row(t[(k + 1) % 3])).norm();
  return sum / static_cast<double>(3 * surface.triangles.rows());
}

Surface compact(const Points& vertices, const Triangles& triangles) {
  Surface out{{}, triangles};
  std::vector<std::int32_t> number(static_cast<std::size_t>(vertices.rows()), -1);
  std::vector<std::int32_t> used;
  for (Eigen::Index i = 0; i < triangles.size(); ++i) {
    std::int32_t& v = out.triangles.data()[i];
    std::int32_t& at = number[static_cast<std::size_t>(v)];
    if (at < 0) {
      at = static_cast<std::int32_t>(used.size());
      used.push_back(v);
    }
    v = at;
  }
  out.vertices = vertices(used, Eigen::all);
  return out;
}

std::vector<Surface> parts_of(const Surface& surface) {
  const auto vertices = static_cast<std::size_t>(surface.vertices.rows());
  const auto patches = patches_of(surface, std::vector<char>(vertices, 1));
  std::vector<std::size_t> patch_of(vertices);
  std::vector<std::int32_t> number(vertices);
  for (std::size_t p = 0; p < patches.size(); ++p)
    for (std::size_t i = 0; i < patches[p].size(); ++i) {
      patch_of[static_cast<std::size_t>(patches[p][i])] = p;
      number[static_cast<std::size_t>(patches[p][i])] = static_cast<std::int32_t>(i);
    }
  std::vector<std::vector<std::int32_t>> corners(patches.size());
  for (const auto& triangle : surface.triangles.rowwise())
    for (const std::int32_t v : triangle)
      corners[patch_of[static_cast<std::size_t>(v)]].push_back(number[static_cast<std::size_t>(v)]);
  std::vector<Surface> parts;
  for (std::size_t p = 0; p < patches.size(); ++p)
    parts.push_back({surface.vertices(patches[p], Eigen::all),
                     Eigen::Map<Triangles>(corners[p].data(),
                                           static_cast<Eigen::Index>(corners[p].size() / 3), 3)});
  return parts;
}

}  // namespace palpate
