#pragma once

#include "libfem/mesh/grade/quadratic_geometry.hpp"

namespace palpate::fem {

/// Volume [m^3] enclosed by isoparametric elements, exact for their cubic determinant.
inline double quadratic_volume_m3(const QuadraticMesh& mesh) {
  // det J has degree 3: five points are exact (Zienkiewicz and Taylor, table of tet rules).
  double sum = 0;
  for (Eigen::Index t = 0; t < mesh.tets.rows(); ++t) {
    TetNodes nodes;
    for (int k = 0; k < 10; ++k) nodes[k] = mesh.nodes.row(mesh.tets(t, k));
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
