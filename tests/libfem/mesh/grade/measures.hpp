#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "libfem/mesh/boundary.hpp"
#include "libfem/mesh/grade/quadratic_geometry.hpp"

namespace palpate::fem {

/// Smallest and largest dihedral angle [rad] of straight tets, over all six edges of each.
struct DihedralRange {
  double smallest_rad = 0;
  double largest_rad = 0;
};
inline DihedralRange dihedral_range(const Points& nodes, const Tets& tets) {
  double largest_cosine = -1, smallest_cosine = 1;
  for (Eigen::Index t = 0; t < tets.rows(); ++t) {
    Vec3 normal[4];
    for (int f = 0; f < 4; ++f) {
      const Vec3 a = nodes.row(tets(t, kTetFace[f][0])), b = nodes.row(tets(t, kTetFace[f][1])),
                 c = nodes.row(tets(t, kTetFace[f][2]));
      normal[f] = (b - a).cross(c - a).normalized();
    }
    for (int f = 0; f < 4; ++f)
      for (int g = f + 1; g < 4; ++g) {
        const double cosine = std::clamp(-normal[f].dot(normal[g]), -1.0, 1.0);
        largest_cosine = std::max(largest_cosine, cosine);
        smallest_cosine = std::min(smallest_cosine, cosine);
      }
  }
  if (tets.rows() == 0) return {};
  return {std::acos(largest_cosine), std::acos(smallest_cosine)};
}

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
