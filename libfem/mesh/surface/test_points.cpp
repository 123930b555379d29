#include "libfem/mesh/surface/surface.hpp"

#include <fmt/core.h>
#include <algorithm>
#include <string>
#include <utility>

#include "libfem/mesh/surface/half_edge.hpp"
#include "libfem/mesh/topology.hpp"
#include "libfit/core/error.hpp"

namespace palpate {
namespace {

/// The part of a surface that a tool can touch, on its own.
struct ReachablePart {
  Surface surface;  ///< vertices in the order of the whole surface, unused ones left out
  Points normals;   ///< per vertex of `surface`, outward unit, of the WHOLE surface
  std::vector<std::int32_t> vertex;  ///< of the whole surface, per vertex of `surface`
};

using TriangleList = std::vector<Eigen::Index>;

/// Drops all but the largest fan at vertices that have several; true when something was dropped.
/// Of fans as large, the one stays whose last triangle comes first.
bool drop_pinches(const Surface& fine, TriangleList& kept) {
  const Triangles triangles = fine.triangles(kept, Eigen::all);
  DisjointSets fan_of = corner_fans(triangles);
  std::vector<std::pair<int, int>> rank(triangles.size());  // of each fan: size, last triangle
  std::vector<std::size_t> largest(fine.vertices.rows());   // fan of each vertex
  for (int c = 0; c < triangles.size(); ++c) {
    auto& [size, last] = rank[fan_of.find(c)];
    ++size;
    last = -c / 3;
  }
  for (int c = 0; c < triangles.size(); ++c) {
    const std::size_t fan = fan_of.find(c);
    std::size_t& best = largest[triangles(c / 3, c % 3)];
    if (rank[fan] >= rank[best] || triangles(best / 3, best % 3) != triangles(c / 3, c % 3))
      best = fan;
  }
  const std::size_t before = kept.size();
  std::size_t f = 0;
  std::erase_if(kept, [&](Eigen::Index) {
    bool is_dropped = false;
    for (int k = 0; k < 3; ++k) is_dropped |= fan_of.find(3 * f + k) != largest[triangles(f, k)];
    ++f;
    return is_dropped;
  });
  return kept.size() < before;
}

/// Triangles whose three vertices are reachable, without those that would make a vertex join two
/// sheets (the largest sheet at the vertex stays). Throws Error when no triangle is left or an
/// index is out of range.
ReachablePart reachable_part(const Surface& fine, const std::vector<char>& is_reachable) {
  TriangleList kept;
  for (Eigen::Index f = 0; f < fine.triangles.rows(); ++f) {
    const auto t = fine.triangles.row(f);
    if (is_reachable[t[0]] && is_reachable[t[1]] && is_reachable[t[2]]) kept.push_back(f);
  }
  while (drop_pinches(fine, kept)) {
  }
  if (kept.empty())
    throw Error("reachable part", "no triangle of the surface can be touched",
                "Widen the region, or hold less of the surface.");

  ReachablePart part{{{}, fine.triangles(kept, Eigen::all)}, {}, {}};
  Triangles& triangles = part.surface.triangles;
  part.vertex = renumber({triangles.data(), std::size_t(triangles.size())}, fine.vertices.rows(),
                         Numbering::ascending);
  part.surface.vertices = fine.vertices(part.vertex, Eigen::all);
  part.normals = vertex_normals(fine)(part.vertex, Eigen::all);
  return part;
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
    const auto v = order[i];
    rank[v.idx()] = static_cast<std::int32_t>(i);
    points.position.row(i) = part.surface.vertices.row(mesh.property(origin, v));
    points.normal.row(i) = -part.normals.row(mesh.property(origin, v));
    points.name.push_back(fmt::format("p{:04}", i + 1));
  }
  points.triangles = to_surface(mesh).triangles.unaryExpr([&](int v) { return rank[v]; });
  return points;
}

}  // namespace

TestPoints choose_test_points(const Surface& fine, const std::vector<char>& in_region,
                              const std::vector<char>& is_reachable, int count) {
  if (count < kMinTestPoints || count > kMaxTestPoints)
    throw Error("test_points", std::to_string(count) + " is not a number of test points",
                "Ask for " + std::to_string(kMinTestPoints) + " to " +
                    std::to_string(kMaxTestPoints) + ".");
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
    may_stand.push_back(is_reachable[part.vertex[v.idx()]]);
  }
  const auto most = static_cast<int>(std::count(may_stand.begin(), may_stand.end(), 1));
  count = std::min(count, std::max(most, 1));
  if (static_cast<std::size_t>(count) < mesh.n_vertices())
    space_evenly(mesh, part.surface, part.normals, may_stand, count, origin);
  return collect(mesh, part, origin);
}

}  // namespace palpate
