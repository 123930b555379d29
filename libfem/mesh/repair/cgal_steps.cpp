#include "libfem/mesh/repair/repair_steps.hpp"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/border.h>
#include <CGAL/Polygon_mesh_processing/repair_self_intersections.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Polygon_mesh_processing/triangulate_hole.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/alpha_wrap_3.h>

#include <algorithm>
#include <cstdint>
#include <iterator>

#include "libfem/mesh/repair/facts.hpp"
#include "libfem/mesh/topology.hpp"
#include "libfit/core/error.hpp"

namespace palpate::repair {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using CgalPoint = Kernel::Point_3;
using CgalMesh = CGAL::Surface_mesh<CgalPoint>;

CgalPoint to_cgal(const Vec3& p) { return {p.x(), p.y(), p.z()}; }

/// Face i of the mesh is triangle i, vertex i vertex i.
CgalMesh to_cgal(const Surface& surface) {
  const SurfaceFacts facts = surface_facts(surface);
  const auto refuse = []() {
    throw Error("surface", "is not manifold and oriented, which this repair needs", "Wrap it.");
  };
  if (!facts.is_manifold || !facts.is_oriented || facts.triangles == 0) refuse();
  CgalMesh mesh;
  for (Eigen::Index v = 0; v < surface.vertices.rows(); ++v)
    mesh.add_vertex(to_cgal(Vec3(surface.vertices.row(v))));
  for (Eigen::Index f = 0; f < surface.triangles.rows(); ++f) {
    const auto corner = [&](int k) {
      return CgalMesh::Vertex_index(static_cast<std::uint32_t>(surface.triangles(f, k)));
    };
    if (mesh.add_face(corner(0), corner(1), corner(2)) == CgalMesh::null_face()) refuse();
  }
  return mesh;
}

Surface from_cgal(CgalMesh& mesh) {
  mesh.collect_garbage();
  Surface surface;
  surface.vertices.resize(mesh.number_of_vertices(), 3);
  for (const auto v : mesh.vertices()) {
    const CgalPoint& p = mesh.point(v);
    surface.vertices.row(v.idx()) << p.x(), p.y(), p.z();
  }
  surface.triangles.resize(mesh.number_of_faces(), 3);
  Eigen::Index f = 0;
  for (const auto face : mesh.faces()) {
    int k = 0;
    for (const auto v : mesh.vertices_around_face(mesh.halfedge(face)))
      if (k < 3) surface.triangles(f, k++) = static_cast<std::int32_t>(v.idx());
    ++f;
  }
  return surface;
}

}  // namespace

FilledHoles fill_holes(const Surface& surface) {
  namespace pmp = CGAL::Polygon_mesh_processing;
  CgalMesh mesh = to_cgal(surface);
  std::vector<CgalMesh::Halfedge_index> borders;
  pmp::extract_boundary_cycles(mesh, std::back_inserter(borders));
  FilledHoles result;
  for (const auto border : borders) {
    CGAL::Bbox_3 box;
    std::size_t edges = 0;
    for (const auto h : CGAL::halfedges_around_face(border, mesh)) {
      box += mesh.point(mesh.target(h)).bbox();
      ++edges;
    }
    std::vector<CgalMesh::Face_index> faces;
    std::vector<CgalMesh::Vertex_index> vertices;
    if (edges <= kLongestHole) {
      try {
        pmp::triangulate_and_refine_hole(mesh, border, std::back_inserter(faces),
                                         std::back_inserter(vertices));
      } catch (const std::exception&) {
        faces.clear();  // counted below as left
      }
    }
    if (faces.empty()) {
      const CgalPoint& p = mesh.point(mesh.target(border));
      result.left.emplace_back(p.x(), p.y(), p.z());
      continue;
    }
    ++result.filled;
    result.triangles += faces.size();
    result.widest_m =
        std::max(result.widest_m, Vec3(box.x_span(), box.y_span(), box.z_span()).norm());
  }
  result.surface = from_cgal(mesh);
  return result;
}

std::vector<std::pair<std::size_t, std::size_t>> self_intersections(const Surface& surface) {
  const CgalMesh mesh = to_cgal(surface);
  std::vector<std::pair<CgalMesh::Face_index, CgalMesh::Face_index>> found;
  CGAL::Polygon_mesh_processing::self_intersections<CGAL::Sequential_tag>(
      mesh, std::back_inserter(found));
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  for (const auto& [a, b] : found) pairs.push_back(std::minmax<std::size_t>(a.idx(), b.idx()));
  std::ranges::sort(pairs);
  return pairs;
}

Surface crossing_part(const Surface& surface) {
  std::vector<std::size_t> triangles;
  for (const auto& [a, b] : self_intersections(surface)) triangles.insert(triangles.end(), {a, b});
  sort_unique(triangles);
  return {surface.vertices, surface.triangles(triangles, Eigen::all)};
}

std::optional<Surface> without_self_intersections(const Surface& surface) {
  CgalMesh mesh = to_cgal(surface);
  try {
    namespace pmp = CGAL::Polygon_mesh_processing;
    if (!pmp::experimental::remove_self_intersections(mesh)) return std::nullopt;
  } catch (const std::exception&) {
    return std::nullopt;  // a construction that rounding spoiled
  }
  if (mesh.number_of_faces() == 0) return std::nullopt;
  return from_cgal(mesh);
}

Surface wrap_surface(const Surface& surface, double alpha_m, double offset_m,
                     const std::vector<Vec3>& seeds) {
  std::vector<CgalPoint> points;
  for (Eigen::Index v = 0; v < surface.vertices.rows(); ++v)
    points.push_back(to_cgal(Vec3(surface.vertices.row(v))));
  std::vector<Triangle> faces;
  for (const auto& t : surface.triangles.rowwise()) faces.push_back({t[0], t[1], t[2]});
  CgalMesh mesh;
  std::vector<CgalPoint> inside;
  for (const Vec3& seed : seeds) inside.push_back(to_cgal(seed));
  if (inside.empty())
    CGAL::alpha_wrap_3(points, faces, alpha_m, offset_m, mesh);
  else
    CGAL::alpha_wrap_3(points, faces, alpha_m, offset_m, mesh, CGAL::parameters::default_values(),
                       CGAL::parameters::seed_points(std::ref(inside)));
  return from_cgal(mesh);
}

}  // namespace palpate::repair
