#include "libfem/mesh/surface/half_edge.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace palpate {
namespace {

using OpenMesh::VertexHandle;

/// Least cosine of a triangle to the mean normal of its corners, where a change may lead.
constexpr double kMinFacing = 0.3;

/// Neighbours of each vertex of the part, and which vertices lie on its border.
struct PartGraph {
  std::vector<std::vector<int>> neighbours;
  std::vector<char> is_border;
};

PartGraph graph_of(const Surface& part) {
  const HalfEdgeMesh mesh = to_half_edges(part);
  PartGraph graph;
  for (const auto v : mesh.vertices()) {
    graph.is_border.push_back(mesh.is_boundary(v));
    graph.neighbours.emplace_back();
    for (const auto w : mesh.vv_range(v)) graph.neighbours.back().push_back(w.idx());
  }
  return graph;
}

class EvenOut {
 public:
  EvenOut(HalfEdgeMesh& mesh, const Surface& part, const Points& normals,
          const std::vector<char>& may_stand, OpenMesh::VPropHandleT<int> origin)
      : mesh_(mesh),
        part_(part),
        normals_(normals),
        may_stand_(may_stand),
        origin_(origin),
        graph_(graph_of(part)) {
    is_used_.assign(graph_.neighbours.size(), 0);
    for (const auto v : mesh_.vertices()) is_used_[mesh_.property(origin_, v)] = 1;
  }

  void run() {
    constexpr int kRounds =
        10;  // hops are half-way, so the last moves are a thousandth of the first
    for (int round = 0; round < kRounds; ++round) {
      flip_edges();
      for (const auto v : mesh_.vertices()) hop(v);
    }
    flip_edges();
    for (const auto v : mesh_.vertices()) leave(v);
  }

 private:
  Vec3 part_position(int v) const { return part_.vertices.row(v); }

  double facing(VertexHandle a, VertexHandle b, VertexHandle c) const {
    const Vec3 facet =
        scaled_normal(position(mesh_, a), position(mesh_, b), position(mesh_, c)).normalized();
    Vec3 mean = Vec3::Zero();
    for (const VertexHandle v : {a, b, c})
      mean += normals_.row(mesh_.property(origin_, v)).transpose();
    return facet.dot(mean.normalized());
  }

  /// Worst roundness around a vertex; negative when a triangle is folded.
  double worst_around(VertexHandle v) const {
    double worst = 1;
    for (const auto h : mesh_.voh_range(v)) {
      if (mesh_.is_boundary(h)) continue;
      const VertexHandle b = mesh_.to_vertex_handle(h);
      const VertexHandle c = mesh_.to_vertex_handle(mesh_.next_halfedge_handle(h));
      if (facing(v, b, c) < kMinFacing) return -1;
      worst =
          std::min(worst, roundness(position(mesh_, v), position(mesh_, b), position(mesh_, c)));
    }
    return worst;
  }

  /// Best place of the vertex: the middle of its neighbours (of its border neighbours, on a
  /// border), long edges pulling harder.
  Vec3 wanted(VertexHandle v) const {
    const bool is_border = mesh_.is_boundary(v);
    Vec3 sum = Vec3::Zero();
    double weights = 0;
    for (const auto h : mesh_.voh_range(v)) {
      if (is_border && !mesh_.is_boundary(mesh_.edge_handle(h))) continue;
      const Vec3 p = position(mesh_, mesh_.to_vertex_handle(h));
      const double weight = (p - position(mesh_, v)).norm();
      sum += weight * p;
      weights += weight;
    }
    return weights > 0 ? Vec3(sum / weights) : position(mesh_, v);
  }

  /// A border vertex at a corner of the border is a feature of the part and stays.
  bool is_pinned(VertexHandle v) const {
    if (!mesh_.is_boundary(v)) return false;
    std::vector<Vec3> arms;
    for (const auto h : mesh_.voh_range(v))
      if (mesh_.is_boundary(mesh_.edge_handle(h)))
        arms.push_back(
            (position(mesh_, mesh_.to_vertex_handle(h)) - position(mesh_, v)).normalized());
    return arms.size() != 2 || arms[0].dot(arms[1]) > -0.7;  // turns by more than 45 degrees
  }

  /// Walks over the part, downhill in distance to `goal`, through free vertices (of the border, for
  /// a border vertex), keeping to the sheet where it started.
  int walk(int from, const Vec3& goal, bool is_border) const {
    int at = from;
    double least = (part_position(at) - goal).squaredNorm();
    for (;;) {
      int best = at;
      for (const int w : graph_.neighbours[at]) {
        if (is_border && !graph_.is_border[w]) continue;
        const double squared_distance = (part_position(w) - goal).squaredNorm();
        if (squared_distance >= least) continue;
        least = squared_distance;
        best = w;
      }
      if (best == at) return at;
      at = best;
    }
  }

  void place(VertexHandle v, int part_vertex) {
    is_used_[mesh_.property(origin_, v)] = 0;
    is_used_[part_vertex] = 1;
    mesh_.property(origin_, v) = part_vertex;
    mesh_.set_point(v, to_open_mesh(part_position(part_vertex)));
  }

  void hop(VertexHandle v) {
    if (is_pinned(v)) return;
    const int old = mesh_.property(origin_, v);
    const Vec3 goal = (wanted(v) + position(mesh_, v)) / 2;  // half-way: neighbours move too
    const int next = walk(old, goal, mesh_.is_boundary(v));
    if (is_used_[next] || !may_stand_[next]) return;
    if (!mesh_.is_boundary(v) && graph_.is_border[next]) return;
    const double before = worst_around(v);
    place(v, next);
    if (worst_around(v) < std::min(before, 0.5)) place(v, old);
  }

  /// From where no point may stand to the nearest vertex of the part, by edges, where one may.
  void leave(VertexHandle v) {
    const int old = mesh_.property(origin_, v);
    if (may_stand_[old]) return;
    std::vector<int> found{old};
    std::vector<char> is_found(graph_.neighbours.size(), 0);
    is_found[old] = 1;
    for (std::size_t i = 0; i < found.size(); ++i) {
      const int at = found[i];
      if (may_stand_[at] && !is_used_[at]) {
        place(v, at);
        if (worst_around(v) >= 0) return;
        place(v, old);
      }
      for (const int w : graph_.neighbours[at])
        if (!is_found[w]) {
          is_found[w] = 1;
          found.push_back(w);
        }
    }
  }

  // Not across a crease: the new triangles face the surface at least about as well.
  void flip_edges() {
    flip_to_rounder(mesh_, 4, [&](VertexHandle a, VertexHandle b, VertexHandle c, VertexHandle d) {
      const double before = std::min(facing(a, b, c), facing(b, a, d));
      const double after = std::min(facing(a, d, c), facing(d, b, c));
      return after > std::max(kMinFacing, before - 0.1);
    });
  }

  HalfEdgeMesh& mesh_;
  const Surface& part_;
  const Points& normals_;
  const std::vector<char>& may_stand_;
  OpenMesh::VPropHandleT<int> origin_;
  PartGraph graph_;
  std::vector<char> is_used_;
};

}  // namespace

void even_out(HalfEdgeMesh& mesh, const Surface& part, const Points& normals,
              const std::vector<char>& may_stand, OpenMesh::VPropHandleT<int> origin) {
  EvenOut(mesh, part, normals, may_stand, origin).run();
}

}  // namespace palpate
