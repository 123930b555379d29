#pragma once

#include "libfem/mesh/grade/grade_steps.hpp"

namespace palpate::fem {

template <class Mesh>
Vec3 centroid(const Mesh& mesh, Eigen::Index t) {
  Vec3 sum = Vec3::Zero();
  for (int k = 0; k < 4; ++k) sum += 0.25 * mesh.nodes.row(mesh.tets(t, k));
  return sum;
}

inline std::vector<char> held_nowhere(const TetMesh& mesh) {
  return std::vector<char>(static_cast<std::size_t>(mesh.nodes.rows()), 0);
}

inline TetNodes nodes_of(const QuadraticMesh& mesh, Eigen::Index t) {
  TetNodes nodes;
  for (int k = 0; k < 10; ++k) nodes[static_cast<std::size_t>(k)] = mesh.nodes.row(mesh.tets(t, k));
  return nodes;
}

/// Volume [m^3] enclosed by isoparametric elements, exact for their cubic determinant.
inline double quadratic_volume_m3(const QuadraticMesh& mesh) {
  // det J has degree 3: five points are exact (Zienkiewicz and Taylor, table of tet rules).
  double sum = 0;
  for (Eigen::Index t = 0; t < mesh.tets.rows(); ++t) {
    const TetNodes nodes = nodes_of(mesh, t);
    sum += -0.8 / 6 * jacobian_determinant(nodes, Eigen::Vector4d::Constant(0.25));
    for (int k = 0; k < 4; ++k) {
      Eigen::Vector4d at = Eigen::Vector4d::Constant(1.0 / 6);
      at[k] = 0.5;
      sum += 0.45 / 6 * jacobian_determinant(nodes, at);
    }
  }
  return sum;
}

}  // namespace palpate::fem
