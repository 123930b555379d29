#pragma once

#include "libfit/core/geometry.hpp"

namespace palpate {

/// A volume filled with four-node tetrahedra at rest. nodes #N x 3 [m], tets #T x 4, positive.
/// Quadratic nodes are made by the solver. region: #T, index of the tet's material (0: the body's
/// own); empty means all 0.
struct TetMesh {
  Points nodes;
  Tets tets;
  Eigen::VectorXi region;
};

}  // namespace palpate
