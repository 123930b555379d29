#pragma once

#include "libfem/mesh/surface/feature_lines.hpp"
#include "libfem/mesh/surface/half_edge.hpp"
#include "libfit/core/closest_point.hpp"

namespace palpate {

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

  void split_long_edges();
  void collapse_short_edges();
  void flip_edges();
  void relax_vertices();

 private:
  double edge_size_m(OpenMesh::VertexHandle a, OpenMesh::VertexHandle b) const;
  double edge_length_m(OpenMesh::EdgeHandle e) const { return mesh.calc_edge_length(e); }
  SurfacePoint land(const Vec3& query, bool is_feature) const;
  void take(OpenMesh::VertexHandle v, const SurfacePoint& hit);
  bool may_collapse(OpenMesh::HalfedgeHandle h) const;
  bool is_flip_better(OpenMesh::EdgeHandle e) const;
  bool faces_outward(OpenMesh::VertexHandle a, OpenMesh::VertexHandle b,
                     OpenMesh::VertexHandle c) const;
  void relax_vertex(OpenMesh::VertexHandle v);
  double distance_around_m(OpenMesh::VertexHandle v, const Vec3& query) const;
};

}  // namespace palpate
