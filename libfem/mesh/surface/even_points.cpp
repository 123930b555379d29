#include <Eigen/Geometry>
#include <OpenMesh/Tools/Decimater/DecimaterT.hh>
#include <OpenMesh/Tools/Decimater/ModBaseT.hh>
#include <algorithm>
#include <vector>

#include "libfem/mesh/surface/half_edge.hpp"

namespace palpate {
namespace {

using OpenMesh::HalfedgeHandle;
using OpenMesh::VertexHandle;

/// Sum of squared distances to planes, weighted by area (Garland and Heckbert 1997).
struct ErrorQuadric {
  Mat3 second = Mat3::Zero();
  Vec3 first = Vec3::Zero();
  double zeroth = 0, weight = 0;

  void add_plane(const Vec3& unit_normal, const Vec3& point, double plane_weight) {
    const double offset = unit_normal.dot(point);
    second += plane_weight * unit_normal * unit_normal.transpose();
    first += plane_weight * offset * unit_normal;
    zeroth += plane_weight * offset * offset;
    weight += plane_weight;
  }
  void add(const ErrorQuadric& other) {
    second += other.second;
    first += other.first;
    zeroth += other.zeroth;
    weight += other.weight;
  }
  double mean_squared_distance(const Vec3& p) const {
    return weight > 0 ? std::max(p.dot(second * p) - 2 * first.dot(p) + zeroth, 0.0) / weight : 0;
  }
};

/// Least cosine of a triangle to the surface's normal, and least roundness, that a collapse leaves.
struct Guards {
  double facing, roundness;
};

/// Collapses the closest pair first, which keeps the least spacing large (sample elimination),
/// and weighs in how far the surface would stray.
template <class MeshT>
class ModEvenSpacing : public OpenMesh::Decimater::ModBaseT<MeshT> {
 public:
  DECIMATING_MODULE(ModEvenSpacing, MeshT, EvenSpacing);

  explicit ModEvenSpacing(MeshT& mesh) : Base(mesh, false) { mesh.add_property(quadric_); }
  ~ModEvenSpacing() override { Base::mesh().remove_property(quadric_); }

  void set(const Guards& guards, const Points& normals, const std::vector<char>& may_stand,
           OpenMesh::VPropHandleT<int> origin) {
    guards_ = guards;
    normals_ = &normals;
    may_stand_ = &may_stand;
    origin_ = origin;
  }

  void initialize() override {
    auto& mesh = Base::mesh();
    for (const auto v : mesh.vertices()) mesh.property(quadric_, v) = ErrorQuadric{};
    for (const auto f : mesh.faces()) add_face(f);
    for (const auto h : mesh.halfedges())
      if (mesh.is_boundary(h)) add_border(h);
  }

  float collapse_priority(const CollapseInfo& collapse) override {
    const bool goes = !may_stand(collapse.v0), stays = may_stand(collapse.v1);
    if ((!goes && !stays) || is_guarded(collapse)) return float(Base::ILLEGAL_COLLAPSE);
    // A tenth of an edge of stray counts like the edge itself.
    constexpr double kStrayWeight = 100;
    const auto& mesh = Base::mesh();
    const Vec3 kept = position(mesh, collapse.v1);
    const double squared_edge = (kept - position(mesh, collapse.v0)).squaredNorm();
    ErrorQuadric both = mesh.property(quadric_, collapse.v0);
    both.add(mesh.property(quadric_, collapse.v1));
    const double priority = squared_edge + kStrayWeight * both.mean_squared_distance(kept);
    return float(goes ? 1e-9 * priority : priority);  // all of them before any other
  }

  void postprocess_collapse(const CollapseInfo& collapse) override {
    auto& mesh = Base::mesh();
    mesh.property(quadric_, collapse.v1).add(mesh.property(quadric_, collapse.v0));
  }

 private:
  void add_face(OpenMesh::FaceHandle f) {
    auto& mesh = Base::mesh();
    VertexHandle corner[3];
    int k = 0;
    for (const auto v : mesh.fv_range(f)) corner[k++] = v;
    const Vec3 a = position(mesh, corner[0]);
    const Vec3 normal = scaled_normal(a, position(mesh, corner[1]), position(mesh, corner[2]));
    const double length = normal.norm();
    if (!(length > 0)) return;
    for (const VertexHandle v : corner)
      mesh.property(quadric_, v).add_plane(normal / length, a, length);
  }

  /// A plane through the border edge, upright on its triangle: what strays from it uncovers area.
  void add_border(HalfedgeHandle h) {
    auto& mesh = Base::mesh();
    const VertexHandle from = mesh.from_vertex_handle(h), to = mesh.to_vertex_handle(h);
    const HalfedgeHandle inner = mesh.opposite_halfedge_handle(h);
    const Vec3 a = position(mesh, from), b = position(mesh, to);
    const Vec3 apex = position(mesh, mesh.to_vertex_handle(mesh.next_halfedge_handle(inner)));
    const Vec3 upright = (b - a).cross(scaled_normal(a, b, apex));
    const double length = upright.norm();
    if (!(length > 0)) return;
    for (const VertexHandle v : {from, to})
      mesh.property(quadric_, v).add_plane(upright / length, a, (b - a).squaredNorm());
  }

  bool is_guarded(const CollapseInfo& collapse) {
    const auto& mesh = Base::mesh();
    const Vec3 kept = position(mesh, collapse.v1);
    for (const auto f : mesh.vf_range(collapse.v0)) {
      if (f == collapse.fl || f == collapse.fr) continue;
      Vec3 corner[3], mean = Vec3::Zero();
      int k = 0;
      for (const auto v : mesh.fv_range(f)) {
        const VertexHandle used = v == collapse.v0 ? collapse.v1 : VertexHandle(v);
        corner[k++] = used == collapse.v1 ? kept : position(mesh, used);
        mean += normals_->row(mesh.property(origin_, used)).transpose();
      }
      const Vec3 facet = scaled_normal(corner[0], corner[1], corner[2]).normalized();
      if (facet.dot(mean.normalized()) < guards_.facing) return true;
      if (roundness(corner[0], corner[1], corner[2]) < guards_.roundness) return true;
    }
    return false;
  }

  bool may_stand(VertexHandle v) { return (*may_stand_)[Base::mesh().property(origin_, v)] != 0; }

  OpenMesh::VPropHandleT<ErrorQuadric> quadric_;
  OpenMesh::VPropHandleT<int> origin_;
  const Points* normals_ = nullptr;
  const std::vector<char>* may_stand_ = nullptr;
  Guards guards_ = {};
};

// Sensible triangles first; then whatever the asked count needs, short of folding over.
constexpr Guards kStages[] = {{0.5, 0.3}, {0.3, 0.1}, {0.0, 0.02}};

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
    // Hops go half the distance, so the last moves are a thousandth of the first.
    for (int round = 0; round < 10; ++round) {
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
    const Vec3 goal = (wanted(v) + position(mesh_, v)) / 2;  // half: neighbours move too
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

void decimate_evenly(HalfEdgeMesh& mesh, const Points& normals, const std::vector<char>& may_stand,
                     int count, OpenMesh::VPropHandleT<int> origin) {
  for (const Guards& guards : kStages) {
    const auto left = static_cast<int>(mesh.n_vertices());
    if (left <= count) return;
    OpenMesh::Decimater::DecimaterT<HalfEdgeMesh> decimater(mesh);
    ModEvenSpacing<HalfEdgeMesh>::Handle handle;
    decimater.add(handle);
    decimater.module(handle).set(guards, normals, may_stand, origin);
    decimater.initialize();
    decimater.decimate(left - count);
    mesh.garbage_collection();
  }
}

}  // namespace

void space_evenly(HalfEdgeMesh& mesh, const Surface& part, const Points& normals,
                  const std::vector<char>& may_stand, int count,
                  OpenMesh::VPropHandleT<int> origin) {
  decimate_evenly(mesh, normals, may_stand, count, origin);
  EvenOut(mesh, part, normals, may_stand, origin).run();
}

}  // namespace palpate
