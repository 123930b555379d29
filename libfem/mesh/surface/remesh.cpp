#include <algorithm>
#include <limits>

#include "libfem/mesh/surface/half_edge.hpp"

namespace palpate {
namespace {

using OpenMesh::EdgeHandle;
using OpenMesh::HalfedgeHandle;
using OpenMesh::VertexHandle;

// Botsch and Kobbelt's bounds: neither a split nor a collapse then undoes the other.
constexpr double kLongest = 4.0 / 3.0;
constexpr double kShortest = 4.0 / 5.0;
/// Least cosine between a triangle and the fine surface's normal at its corners: 66 degrees. A
/// triangle steeper than that folds over a neighbour or cuts through a crease.
constexpr double kMinFacing = 0.4;
/// Largest distance that a point may be left behind, over the wanted edge: by the collapse of its
/// vertex, and by one move of it, of which there are several.
constexpr double kLeftByCollapse = 0.12;

std::size_t at(VertexHandle v) { return static_cast<std::size_t>(v.idx()); }

/// A surface under remeshing and what it must look like. The passes of one round, in order; each
/// leaves features (edge status) and locked vertices in place, and refuses every change that turns
/// a triangle against the fine surface's normal or that leaves behind the point a vertex was at:
/// without that, the tips and rims of thin lobes retract (by 17 mm on a liver at 12 mm).
struct Remeshing {
  HalfEdgeMesh mesh;
  FeatureLines lines;
  const Surface& fine;
  const BoxTree& fine_boxes;        ///< triangle_boxes(fine)
  const Eigen::VectorXd& wanted_m;  ///< per fine vertex
  const Points& fine_normals;
  std::vector<double> size_m;  ///< per vertex of `mesh`, wanted edge length there
  std::vector<Vec3> normal;    ///< per vertex of `mesh`, outward normal of the fine surface there

  void split_long_edges() {
    std::vector<std::pair<double, EdgeHandle>> long_edges;
    for (const auto e : mesh.edges())
      if (const double ratio = length_ratio(e); ratio > kLongest) long_edges.emplace_back(ratio, e);
    std::stable_sort(long_edges.begin(), long_edges.end(),
                     [](const auto& a, const auto& b) { return a.first > b.first; });
    for (const auto& [ratio, e] : long_edges) {
      const bool is_feature = mesh.status(e).feature();
      const SurfacePoint hit = land(to_eigen(mesh.calc_edge_midpoint(e)), is_feature);
      const VertexHandle a = mesh.from_vertex_handle(mesh.halfedge_handle(e, 0));
      const VertexHandle b = mesh.to_vertex_handle(mesh.halfedge_handle(e, 0));
      const VertexHandle v = mesh.add_vertex(to_open_mesh(hit.position));
      mesh.split(e, v);
      mesh.status(v).set_feature(is_feature);
      for (const auto h : mesh.voh_range(v)) {
        const VertexHandle end = mesh.to_vertex_handle(h);
        mesh.status(mesh.edge_handle(h)).set_feature(is_feature && (end == a || end == b));
      }
      take(v, hit);
    }
  }

  void collapse_short_edges() {
    std::vector<std::pair<double, EdgeHandle>> short_edges;
    for (const auto e : mesh.edges())
      if (const double ratio = length_ratio(e); ratio < kShortest)
        short_edges.emplace_back(ratio, e);
    std::stable_sort(short_edges.begin(), short_edges.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    for (const auto& [ratio, e] : short_edges) {
      if (mesh.status(e).deleted() || length_ratio(e) >= kShortest) continue;
      for (int side = 0; side < 2; ++side) {
        const auto h = mesh.halfedge_handle(e, side);
        if (!may_collapse(h) || !mesh.is_collapse_ok(h)) continue;
        mesh.collapse(h);
        break;
      }
    }
    // Handles stay dense: arrays per vertex follow their vertices.
    std::vector<double> sizes;
    std::vector<Vec3> normals;
    OpenMesh::VPropHandleT<int> origin;
    mesh.add_property(origin);
    for (const auto v : mesh.vertices()) mesh.property(origin, v) = v.idx();
    mesh.garbage_collection();
    for (const auto v : mesh.vertices()) {
      const int from = mesh.property(origin, v);
      sizes.push_back(size_m[from]);
      normals.push_back(normal[from]);
    }
    mesh.remove_property(origin);
    size_m = std::move(sizes);
    normal = std::move(normals);
  }

  void flip_edges() {
    flip_to_rounder(mesh, 6, [&](VertexHandle a, VertexHandle b, VertexHandle c, VertexHandle d) {
      return faces_outward(a, d, c) && faces_outward(d, b, c);
    });
  }

  void relax_vertex(VertexHandle v) {
    if (mesh.status(v).locked()) return;
    const bool is_feature = mesh.status(v).feature();
    const Vec3 old = position(mesh, v);
    Vec3 sum = Vec3::Zero();
    double weights = 0;
    for (const auto h : mesh.voh_range(v)) {
      if (is_feature && !mesh.status(mesh.edge_handle(h)).feature()) continue;
      const VertexHandle w = mesh.to_vertex_handle(h);
      const double weight = 1 / size_m[at(w)];  // smaller sizes pull harder: spacing follows size
      sum += weight * position(mesh, w);
      weights += weight;
    }
    if (!(weights > 0)) return;
    Vec3 move = sum / weights - old;
    if (!is_feature) move -= move.dot(normal[at(v)]) * normal[at(v)];
    const SurfacePoint hit = land(old + move, is_feature);
    const double old_size = size_m[at(v)];
    const Vec3 old_normal = normal[at(v)];
    take(v, hit);
    // The nearest point may belong to another sheet, and a move may fold a neighbour over.
    bool is_good = is_feature || old_normal.dot(normal[at(v)]) > kMinFacing;
    for (const auto h : mesh.voh_range(v))
      is_good = is_good && faces_outward(v, mesh.to_vertex_handle(h),
                                         mesh.to_vertex_handle(mesh.next_halfedge_handle(h)));
    is_good = is_good && distance_around_m(v, old) < 0.03 * old_size;
    if (is_good) return;
    mesh.set_point(v, to_open_mesh(old));
    size_m[at(v)] = old_size;
    normal[at(v)] = old_normal;
  }

 private:
  double edge_size_m(VertexHandle a, VertexHandle b) const {
    return std::min(size_m[at(a)], size_m[at(b)]);
  }

  /// Length of an edge over its wanted one.
  double length_ratio(EdgeHandle e) const {
    const auto h = mesh.halfedge_handle(e, 0);
    return mesh.calc_edge_length(e) /
           edge_size_m(mesh.from_vertex_handle(h), mesh.to_vertex_handle(h));
  }

  SurfacePoint land(const Vec3& query, bool is_feature) const {
    return closest_point(fine, fine_boxes, is_feature ? lines.closest(query) : query)
        .value_or(SurfacePoint{});
  }

  void take(VertexHandle v, const SurfacePoint& hit) {
    mesh.set_point(v, to_open_mesh(hit.position));
    if (at(v) >= size_m.size()) {
      size_m.resize(at(v) + 1);
      normal.resize(at(v) + 1);
    }
    double size = 0;
    Vec3 direction = Vec3::Zero();
    for (int k = 0; k < 3; ++k) {
      const auto corner = fine.triangles(hit.triangle, k);
      size += hit.weight[k] * wanted_m[corner];
      direction += hit.weight[k] * fine_normals.row(corner).transpose();
    }
    size_m[at(v)] = size;
    normal[at(v)] = direction.normalized();
  }

  bool may_collapse(HalfedgeHandle h) const {
    const VertexHandle gone = mesh.from_vertex_handle(h), kept = mesh.to_vertex_handle(h);
    if (mesh.status(gone).locked()) return false;
    if (mesh.status(gone).feature() && !mesh.status(mesh.edge_handle(h)).feature()) return false;
    double left_behind = std::numeric_limits<double>::infinity();
    for (const auto around : mesh.voh_range(gone)) {
      const VertexHandle far = mesh.to_vertex_handle(around);
      if (far == kept) continue;
      if ((position(mesh, far) - position(mesh, kept)).norm() > kLongest * edge_size_m(far, kept))
        return false;
      const VertexHandle next = mesh.to_vertex_handle(mesh.next_halfedge_handle(around));
      if (next == kept) continue;
      if (!faces_outward(kept, far, next)) return false;
      left_behind =
          std::min(left_behind, nearest_on_triangle(position(mesh, gone), position(mesh, kept),
                                                    position(mesh, far), position(mesh, next))
                                    .distance_m);
    }
    if (left_behind > kLeftByCollapse * edge_size_m(gone, kept)) return false;
    // A feature line may not swing onto another: the two wings of the edge keep their own status.
    for (const HalfedgeHandle side : {h, mesh.opposite_halfedge_handle(h)}) {
      const auto wing = mesh.edge_handle(side == h ? mesh.prev_halfedge_handle(side)
                                                   : mesh.next_halfedge_handle(side));
      if (mesh.status(wing).feature()) return false;
    }
    return true;
  }

  bool faces_outward(VertexHandle a, VertexHandle b, VertexHandle c) const {
    const Vec3 facet =
        scaled_normal(position(mesh, a), position(mesh, b), position(mesh, c)).normalized();
    const Vec3 mean = (normal[at(a)] + normal[at(b)] + normal[at(c)]).normalized();
    return facet.dot(mean) > kMinFacing;
  }

  double distance_around_m(VertexHandle v, const Vec3& query) const {
    double least = std::numeric_limits<double>::infinity();
    for (const auto h : mesh.voh_range(v))
      least = std::min(
          least,
          nearest_on_triangle(query, position(mesh, v), position(mesh, mesh.to_vertex_handle(h)),
                              position(mesh, mesh.to_vertex_handle(mesh.next_halfedge_handle(h))))
              .distance_m);
    return least;
  }
};

}  // namespace

Surface remesh(const Surface& fine, const BoxTree& boxes, const Eigen::VectorXd& wanted_m) {
  const Points fine_normals = vertex_normals(fine);
  Remeshing work{to_half_edges(fine), {}, fine, boxes, wanted_m, fine_normals, {}, {}};
  work.lines = mark_features(work.mesh, 2 * wanted_m.minCoeff());
  for (Eigen::Index v = 0; v < wanted_m.size(); ++v) {
    work.size_m.push_back(wanted_m[v]);
    work.normal.push_back(fine_normals.row(v));
  }
  // Botsch and Kobbelt use 5 to 10; the first ones here only coarsen.
  for (int round = 0; round < 12; ++round) {
    work.split_long_edges();
    work.collapse_short_edges();
    work.flip_edges();
    for (const auto v : work.mesh.vertices()) work.relax_vertex(v);
  }
  work.flip_edges();
  return to_surface(work.mesh);
}

}  // namespace palpate
