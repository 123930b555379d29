#pragma once

#include <array>
#include <vector>

#include "libfem/mesh/quadratic_mesh.hpp"
#include "libfem/solve/equilibrium/path_follower.hpp"

namespace palpate::fem {

/// Displacements of one mesh at the nodes of another of the same body. A node takes those of the
/// nearest tet, as its ten shape functions between straight edges have them; held nodes stay.
class MeshTransfer {
 public:
  MeshTransfer(const QuadraticMesh& from, const QuadraticMesh& to);

  /// u: of the nodes of `from`, #N x 3 [m]; of the nodes of `to`.
  Points operator()(const Points& u) const;

 private:
  struct NodePlace {
    std::array<std::int32_t, 10> node;
    std::array<double, 10> shape;  // zeros where held
  };
  std::vector<NodePlace> places_;
};

/// Displacements by which the paths on one mesh moved its nodes, from before the probe touched, at
/// those of another.
Waypoints transferred(const Waypoints& reached, const QuadraticMesh& from, const QuadraticMesh& to);

}  // namespace palpate::fem
