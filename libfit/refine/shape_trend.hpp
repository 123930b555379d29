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

/// Of the logarithm of the gap's force, the share that forces follow: the power of (M12g). A ridge
/// gives way more than a half-space with its gap, and simulation blunts both. With 0, 3/4 and 1 a
/// prototype on the samples of 80 points predicted points left out to (mean, %) 10.4, 5.9, 6.4 on a
/// liver with ridges of the tool's size, 3.4, 1.4, 1.6 on a smoother one, 10.8, 5.9, 7.7 on a
/// dragon.
inline constexpr double kGapShare = 0.75;

/// A trend (1 x kComparedDepths) at the Greville abscissae of a curve's control values.
Eigen::RowVectorXd at_controls(const CurveBasis& basis, const Eigen::RowVectorXd& trend);

}  // namespace palpate
