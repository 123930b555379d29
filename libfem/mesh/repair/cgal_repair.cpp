#include <CGAL/Polygon_mesh_processing/border.h>
#include <CGAL/Polygon_mesh_processing/repair_self_intersections.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Polygon_mesh_processing/triangulate_hole.h>
#include <algorithm>
#include <iterator>

#include "libfem/mesh/repair/cgal_mesh.hpp"
#include "libfem/mesh/repair/cgal_steps.hpp"

namespace palpate::repair {
namespace {

struct Border {
  std::size_t edges = 0;
  double width_m = 0;
};

Border measure(const CgalMesh& mesh, CgalMesh::Halfedge_index border) {
  Border result;
  CGAL::Bbox_3 box;
  for (const auto h : CGAL::halfedges_around_face(border, mesh)) {
    box += mesh.point(mesh.target(h)).bbox();
    ++result.edges;
  }
  result.width_m = Vec3(box.x_span(), box.y_span(), box.z_span()).norm();
  return result;
}

}  // namespace

FilledHoles fill_holes(const Surface& surface) {
  namespace pmp = CGAL::Polygon_mesh_processing;
  CgalMesh mesh = to_cgal(surface);
  std::vector<CgalMesh::Halfedge_index> borders;
  pmp::extract_boundary_cycles(mesh, std::back_inserter(borders));
  FilledHoles result;
  for (const auto border : borders) {
    const Border hole = measure(mesh, border);
    std::vector<CgalMesh::Face_index> faces;
    std::vector<CgalMesh::Vertex_index> vertices;
    if (hole.edges <= kLongestHole) {
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
    result.widest_m = std::max(result.widest_m, hole.width_m);
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

}  // namespace palpate::repair
