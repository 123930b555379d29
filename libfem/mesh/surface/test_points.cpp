#include "libfem/mesh/surface/test_points.hpp"

#include <algorithm>
#include <cstdio>
#include <string>

#include "libfem/mesh/surface/even_decimation.hpp"
#include "libfem/mesh/surface/even_out.hpp"
#include "libfem/mesh/surface/half_edge.hpp"
#include "libfem/mesh/surface/reachable_part.hpp"
#include "libfit/core/error.hpp"

namespace palpate {
namespace {

void refuse_bad_input(const Surface& fine, const std::vector<char>& in_region,
                      const std::vector<char>& is_reachable, int count) {
  if (count < kMinTestPoints || count > kMaxTestPoints)
    throw Error("test_points", std::to_string(count) + " is not a number of test points",
                "Ask for " + std::to_string(kMinTestPoints) + " to " +
                    std::to_string(kMaxTestPoints) + ".");
  if (static_cast<Eigen::Index>(in_region.size()) != fine.vertices.rows() ||
      is_reachable.size() != in_region.size())
    throw Error("test_points", "reachable flags do not match the surface's vertices",
                "Give one flag per vertex.");
}

std::string name_of(Eigen::Index index) {
  char name[24];
  std::snprintf(name, sizeof name, "p%04d", static_cast<int>(index) + 1);
  return name;
}

/// Points in the order of the part's vertices, which is the fine surface's.
TestPoints collect(const HalfEdgeMesh& mesh, const ReachablePart& part,
                   OpenMesh::VPropHandleT<int> origin) {
  std::vector<OpenMesh::VertexHandle> order(mesh.vertices().begin(), mesh.vertices().end());
  std::sort(order.begin(), order.end(),
            [&](auto a, auto b) { return mesh.property(origin, a) < mesh.property(origin, b); });
  TestPoints points;
  const auto count = static_cast<Eigen::Index>(order.size());
  points.position.resize(count, 3);
  points.normal.resize(count, 3);
  std::vector<std::int32_t> rank(order.size());
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto v = order[static_cast<std::size_t>(i)];
    rank[static_cast<std::size_t>(v.idx())] = static_cast<std::int32_t>(i);
    points.position.row(i) = part.surface.vertices.row(mesh.property(origin, v));
    points.normal.row(i) = -part.normals.row(mesh.property(origin, v));
    points.name.push_back(name_of(i));
  }
  points.triangles.resize(static_cast<Eigen::Index>(mesh.n_faces()), 3);
  for (const auto f : mesh.faces()) {
    int k = 0;
    for (const auto v : mesh.fv_range(f))
      points.triangles(f.idx(), k++) = rank[static_cast<std::size_t>(v.idx())];
  }
  return points;
}

}  // namespace

TestPoints choose_test_points(const Surface& fine, const std::vector<char>& in_region,
                              const std::vector<char>& is_reachable, int count) {
  refuse_bad_input(fine, in_region, is_reachable, count);
  const ReachablePart part = reachable_part(fine, in_region);
  HalfEdgeMesh mesh = to_half_edges(part.surface);
  if (mesh.n_faces() != static_cast<std::size_t>(part.surface.triangles.rows()))
    throw Error("surface", "an edge of the reachable part has more than two triangles",
                "Mend the surface first.");
  OpenMesh::VPropHandleT<int> origin;
  mesh.add_property(origin);
  std::vector<char> may_stand;
  for (const auto v : mesh.vertices()) {
    mesh.property(origin, v) = v.idx();
    may_stand.push_back(is_reachable[static_cast<std::size_t>(part.vertex[std::size_t(v.idx())])]);
  }
  const auto most = static_cast<int>(std::count(may_stand.begin(), may_stand.end(), 1));
  count = std::min(count, std::max(most, 1));
  if (static_cast<std::size_t>(count) < mesh.n_vertices()) {
    decimate_evenly(mesh, part.normals, may_stand, count, origin);
    even_out(mesh, part.surface, part.normals, may_stand, origin);
  }
  return collect(mesh, part, origin);
}

}  // namespace palpate
