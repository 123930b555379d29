#pragma once

#include <Eigen/Geometry>
#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <algorithm>
#include <numbers>
#include <utility>
#include <vector>

#include "libfit/core/closest_point.hpp"
#include "libfit/core/geometry.hpp"

// The half-edge surface of this folder. Included by its .cpp files only: OpenMesh goes no further.

namespace palpate {

struct HalfEdgeTraits : OpenMesh::DefaultTraits {
  using Point = OpenMesh::Vec3d;
  using Normal = OpenMesh::Vec3d;
  VertexAttributes(OpenMesh::Attributes::Status);
  EdgeAttributes(OpenMesh::Attributes::Status);
  FaceAttributes(OpenMesh::Attributes::Status | OpenMesh::Attributes::Normal);
  HalfedgeAttributes(OpenMesh::Attributes::Status | OpenMesh::Attributes::PrevHalfedge);
};
using HalfEdgeMesh = OpenMesh::TriMesh_ArrayKernelT<HalfEdgeTraits>;

inline Vec3 to_eigen(const OpenMesh::Vec3d& p) { return {p[0], p[1], p[2]}; }
inline OpenMesh::Vec3d to_open_mesh(const Vec3& p) { return {p.x(), p.y(), p.z()}; }

inline Vec3 position(const HalfEdgeMesh& mesh, OpenMesh::VertexHandle v) {
  return to_eigen(mesh.point(v));
}

/// Normal times twice the area.
inline Vec3 scaled_normal(const Vec3& a, const Vec3& b, const Vec3& c) {
  return (b - a).cross(c - a);
}

/// 1 for an equilateral triangle, 0 for a degenerate one: 4 sqrt(3) area / sum of squared edges.
inline double roundness(const Vec3& a, const Vec3& b, const Vec3& c) {
  const double squared = (b - a).squaredNorm() + (c - b).squaredNorm() + (a - c).squaredNorm();
  return squared > 0 ? 2 * std::numbers::sqrt3 * scaled_normal(a, b, c).norm() / squared : 0;
}

/// Flips edges that are no features where the worse of both triangles gets rounder, in sweeps until
/// none does. may_flip(a, b, c, d): whether edge ab may become cd.
template <class MayFlip>
void flip_to_rounder(HalfEdgeMesh& mesh, int max_sweeps, const MayFlip& may_flip) {
  int flips = 1;
  for (int sweep = 0; sweep < max_sweeps && flips > 0; ++sweep) {
    flips = 0;
    for (const auto e : mesh.edges()) {
      if (mesh.status(e).feature() || !mesh.is_flip_ok(e)) continue;
      const auto h = mesh.halfedge_handle(e, 0), o = mesh.halfedge_handle(e, 1);
      const auto a = mesh.from_vertex_handle(h), b = mesh.to_vertex_handle(h);
      const auto c = mesh.to_vertex_handle(mesh.next_halfedge_handle(h));
      const auto d = mesh.to_vertex_handle(mesh.next_halfedge_handle(o));
      const Vec3 pa = position(mesh, a), pb = position(mesh, b), pc = position(mesh, c),
                 pd = position(mesh, d);
      const double before = std::min(roundness(pa, pb, pc), roundness(pb, pa, pd));
      const double after = std::min(roundness(pa, pd, pc), roundness(pd, pb, pc));
      if (!(after > before + 1e-9) || !may_flip(a, b, c, d)) continue;
      mesh.flip(e);
      ++flips;
    }
  }
}

/// Builds the half-edge structure; the surface must be manifold (borders allowed).
inline HalfEdgeMesh to_half_edges(const Surface& surface) {
  HalfEdgeMesh mesh;
  std::vector<OpenMesh::VertexHandle> vertex;
  for (const auto& p : surface.vertices.rowwise())
    vertex.push_back(mesh.add_vertex({p.x(), p.y(), p.z()}));
  const auto at = [&](std::int32_t v) { return vertex[v]; };
  for (const auto& t : surface.triangles.rowwise()) mesh.add_face(at(t[0]), at(t[1]), at(t[2]));
  return mesh;
}

/// Vertices and triangles that are left, in the mesh's order. Call garbage_collection() first.
inline Surface to_surface(const HalfEdgeMesh& mesh) {
  Surface surface;
  surface.vertices.resize(mesh.n_vertices(), 3);
  surface.triangles.resize(mesh.n_faces(), 3);
  for (const auto v : mesh.vertices()) surface.vertices.row(v.idx()) = position(mesh, v);
  for (const auto f : mesh.faces()) {
    int k = 0;
    for (const auto v : mesh.fv_range(f)) surface.triangles(f.idx(), k++) = v.idx();
  }
  return surface;
}

/// The sharp edges of a fine surface, as segments to project onto.
struct FeatureLines {
  std::vector<std::pair<Vec3, Vec3>> segments;

  /// Nearest point of any segment; the query itself when there is none.
  Vec3 closest(const Vec3& query) const;
};

/// Marks edges whose triangles turn by more than 60 degrees as features, and their vertices;
/// vertices where a line ends, branches or turns sharply are locked (they stay where they are).
/// Strings of sharp edges shorter than `min_length_m` in all are noise and not marked.
FeatureLines mark_features(HalfEdgeMesh& mesh, double min_length_m);

/// Decimates a half-edge surface to `count` of its vertices, evenly spaced, with OpenMesh, then
/// lets them hop among the vertices of the part they were chosen from, towards the middle of their
/// neighbours, and flips edges, for a few rounds.
/// part: the surface before decimation; normals: per vertex of it, outward unit; may_stand: per
/// vertex of it, where vertices may stay and hop; others are removed first, or leave for the
/// nearest such. Guards against flipped and needle triangles are loosened in stages until the count
/// is reached or topology forbids more. Leaves the mesh garbage-collected; `origin` is each
/// vertex's index in the part, kept up to date. Borders stay borders. No triangle is folded over.
void space_evenly(HalfEdgeMesh& mesh, const Surface& part, const Points& normals,
                  const std::vector<char>& may_stand, int count,
                  OpenMesh::VPropHandleT<int> origin);

/// Wanted edge length at each vertex of a fine surface, #V [m]. boxes: triangle_boxes(fine).
/// The least of the target, the edge whose chord strays by 0.08 of the target on the local
/// curvature (sqrt(6 e r - 3 e^2), Dunyach et al. 2013, doi:10.2312/conf/EG2013/short/029-032), and
/// the local thickness, never below 0.4 of the target; then limited in growth from vertex to
/// vertex. Around lumens 2.5 thicknesses, up to 5 away from the region (from_region_m: #V).
/// Curvature finer than the target is smoothed away first: noise is not a feature.
Eigen::VectorXd wanted_edge_m(const Surface& fine, const BoxTree& boxes, double target_edge_m,
                              const Eigen::VectorXd& from_region_m);

/// Lets no vertex's size exceed a neighbour's by more than half their distance.
void limit_growth(Eigen::VectorXd& size_m, const Surface& fine);

/// A surface with the shape of `fine` and edges of about `wanted_m` (#V, per fine vertex [m]),
/// vertices on `fine`, feature lines kept as edges.
/// fine: closed, manifold, outward. The result is closed and manifold; whether it crosses itself
/// or strays is for the caller to check. Deterministic.
/// Source: Botsch and Kobbelt 2004, doi:10.1145/1057432.1057457 (split, collapse, flip, relax),
/// with the sizes of Dunyach et al. 2013.
Surface remesh(const Surface& fine, const BoxTree& boxes, const Eigen::VectorXd& wanted_m);

}  // namespace palpate
