#pragma once

#include <array>
#include <vector>

#include "libfem/contact/face_rule.hpp"
#include "libfem/mesh/quadratic_mesh.hpp"
#include "libfem/solve/equilibrium/path_follower.hpp"

namespace palpate::fem {

/// Displacements by which the paths on one mesh moved its nodes, from before the probe touched, at
/// the nodes of another of the same body. A node takes those of the nearest tet, as its ten shape
/// functions between straight edges have them; held nodes stay.
Waypoints transferred(const Waypoints& reached, const QuadraticMesh& from, const QuadraticMesh& to);

/// Places of a surface on the boundary of a solved mesh, so that they move as it does.
/// A place belongs to the nearest boundary face that faces its way (each face as four flat
/// triangles between its six nodes), and moves by the face's own shape functions: at a node by
/// exactly what the node moves.
class SurfacePlaces {
 public:
  /// places, outward: S x 3 [m], unit normals, in the mesh's coordinates.
  SurfacePlaces(const QuadraticMesh& mesh, const Points& places, const Points& outward);

  /// Displacement [m] of the places where the mesh's nodes (N x 3) move by u: x, y, z of each in
  /// turn, rounded to multiples of quantum_m, a power of two: files of round numbers compress well.
  Eigen::VectorXf displacement(const Points& u, double quantum_m) const;

 private:
  struct FacePlace {
    std::array<std::int32_t, kFaceNodes> node;
    std::array<double, kFaceNodes> shape;
  };
  std::vector<FacePlace> places_;
};

}  // namespace palpate::fem
