#pragma once

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/boost/graph/Euler_operations.h>
#include <CGAL/boost/graph/helpers.h>

#include <cstdint>
#include <vector>

#include "libfem/mesh/repair/facts.hpp"
#include "libfit/core/error.hpp"
#include "libfit/core/geometry.hpp"

/// Between Surface and CGAL's half-edge mesh; for the cgal_*.cpp files only.
namespace palpate::repair {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using CgalPoint = Kernel::Point_3;
using CgalMesh = CGAL::Surface_mesh<CgalPoint>;

inline CgalPoint to_cgal(const Vec3& p) { return {p.x(), p.y(), p.z()}; }

/// Face i of the mesh is triangle i, vertex i vertex i.
inline CgalMesh to_cgal(const Surface& surface) {
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

inline Surface from_cgal(CgalMesh& mesh) {
  mesh.collect_garbage();
  Surface surface;
  surface.vertices.resize(static_cast<Eigen::Index>(mesh.number_of_vertices()), 3);
  for (const auto v : mesh.vertices()) {
    const CgalPoint& p = mesh.point(v);
    surface.vertices.row(static_cast<Eigen::Index>(v.idx())) << p.x(), p.y(), p.z();
  }
  surface.triangles.resize(static_cast<Eigen::Index>(mesh.number_of_faces()), 3);
  Eigen::Index f = 0;
  for (const auto face : mesh.faces()) {
    int k = 0;
    for (const auto v : mesh.vertices_around_face(mesh.halfedge(face)))
      if (k < 3) surface.triangles(f, k++) = static_cast<std::int32_t>(v.idx());
    ++f;
  }
  return surface;
}

}  // namespace palpate::repair
