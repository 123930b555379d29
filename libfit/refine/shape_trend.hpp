#pragma once

#include "libfit/core/curves.hpp"
#include "libfit/refine/gap_force.hpp"

namespace palpate {

/// Logarithms of what forces at a place are blended over (M12g, M12f), at compared depths, but for
/// a constant. Empty where forces are blended as they are.
struct ShapeTrend {
  Controls at_point;     ///< P x kComparedDepths
  Controls at_vertex;    ///< V x kComparedDepths
  bool smooths = false;  ///< vertices at test points, too (M12f)
  bool is_used() const { return at_point.size() > 0; }
};

/// Of the logarithm of the gap's force, the share that forces follow. A ridge gives way more than a
/// half-space with its gap, and a fine simulation blunts both. With 0, 1/2, 3/4 and 1, test points
/// left out are predicted to (mean, %) 10.4, 6.7, 5.8, 6.2 on a liver with ridges of the tool's
/// size, 3.4, 1.7, 1.2, 1.3 on a smoother one, 3.9, 3.6, 3.5, 3.6 on a hand.
inline constexpr double kGapShare = 0.75;

/// A trend (1 x kComparedDepths) at the Greville abscissae of a curve's control values.
Eigen::RowVectorXd at_controls(const CurveBasis& basis, const Eigen::RowVectorXd& trend);

}  // namespace palpate
