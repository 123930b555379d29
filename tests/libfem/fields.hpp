#pragma once

#include <random>

#include "libfem/elements/block_matrix.hpp"
#include "libfit/core/geometry.hpp"

// Displacement fields, and a stiffness as a dense matrix, for the tests of elements and solver.

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

inline Eigen::MatrixXd dense(const SymmetricBlockMatrix& K) {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(K.size(), K.size());
  for (int c = 0; c < K.size(); ++c)
    for (auto k = K.column_start()[c]; k < K.column_start()[c + 1]; ++k)
      out(K.row_index()[k], c) = out(c, K.row_index()[k]) = K.values()[k];
  return out;
}

}  // namespace palpate::fem
