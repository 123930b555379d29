#pragma once

#include <random>

#include "libfit/core/geometry.hpp"

// Displacement fields for the tests of elements and solver.

namespace palpate::fem {

/// u = (F - 1) x.
inline Points affine(const Points& nodes, const Mat3& F) {
  return nodes * (F - Mat3::Identity()).transpose();
}

/// Each component anywhere between -size and size.
inline Points random_field(Eigen::Index nodes, double size, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-size, size);
  Points u(nodes, 3);
  for (Eigen::Index i = 0; i < u.size(); ++i) u.data()[i] = uniform(random);
  return u;
}

}  // namespace palpate::fem
