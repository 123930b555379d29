#include <CGAL/Polygon_mesh_processing/repair_self_intersections.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>

#include <algorithm>

#include "libfem/mesh/repair/cgal_mesh.hpp"
#include "libfem/mesh/repair/cgal_steps.hpp"

namespace palpate::repair {

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
