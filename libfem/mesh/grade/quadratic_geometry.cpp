#include "libfem/mesh/grade/quadratic_geometry.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <limits>

#include "libfem/mesh/boundary.hpp"

namespace palpate::fem {

double jacobian_determinant(const TetNodes& nodes, const Eigen::Vector4d& at) {
  Eigen::Matrix<double, 3, 4> by_coordinate;  // dx/dL_k, the four taken as independent
  for (int k = 0; k < 4; ++k) by_coordinate.col(k) = (4 * at[k] - 1) * nodes[k];
  for (int e = 0; e < 6; ++e) {
    const int a = kTetEdge[e][0], b = kTetEdge[e][1];
    by_coordinate.col(a) += 4 * at[b] * nodes[4 + e];
    by_coordinate.col(b) += 4 * at[a] * nodes[4 + e];
  }
  Mat3 jacobian;
  for (int k = 0; k < 3; ++k) jacobian.col(k) = by_coordinate.col(k + 1) - by_coordinate.col(0);
  return jacobian.determinant();
}

double smallest_jacobian(const TetNodes& nodes) {
  constexpr double kNear = 0.58541019662496852, kFar = 0.13819660112501050;  // degree-2 rule
  double smallest = jacobian_determinant(nodes, Eigen::Vector4d::Constant(0.25));
  for (int k = 0; k < 4; ++k) {
    Eigen::Vector4d at = Eigen::Vector4d::Constant(kFar);
    at[k] = kNear;
    smallest = std::min({smallest, jacobian_determinant(nodes, at),
                         jacobian_determinant(nodes, Eigen::Vector4d::Unit(k))});
  }
  return smallest;
}

}  // namespace palpate::fem
