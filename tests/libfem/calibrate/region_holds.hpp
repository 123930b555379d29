#pragma once

#include <Eigen/QR>

#include "libfem/calibrate/identify.hpp"

namespace palpate::fem {

/// Whether values of the free parameters lie in the stated 95 % region.
inline bool region_holds(const Identification& found, const Eigen::VectorXd& values) {
  Eigen::VectorXd off(values.size());
  for (Eigen::Index j = 0; j < off.size(); ++j)
    off[j] = (values[j] - found.material.values[found.free[static_cast<std::size_t>(j)]]) /
             std::sqrt(found.covariance(j, j));
  return off.dot(found.correlation.completeOrthogonalDecomposition().solve(off)) <= found.region;
}

}  // namespace palpate::fem
