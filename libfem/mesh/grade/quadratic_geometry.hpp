#pragma once

#include <array>

#include "libfem/mesh/quadratic_mesh.hpp"

namespace palpate::fem {

/// Positions of a quadratic tet's ten nodes [m], in the order of QuadraticMesh.
using TetNodes = std::array<Vec3, 10>;

/// det dx/dxi [m^3] of a quadratic tet at volume coordinates `at` (sum 1); 6 V when straight.
double jacobian_determinant(const TetNodes& nodes, const Eigen::Vector4d& at);

/// Smallest determinant [m^3] over the 4 quadrature points, the 4 corners and the centroid.
double smallest_jacobian(const TetNodes& nodes);

}  // namespace palpate::fem
