#pragma once

#include <optional>
#include <vector>

#include "libfit/core/curves.hpp"

namespace palpate {

/// How the normal curve changes along the surface from each test point, as the side force of its
/// presses says (B4a): P x 3 n, x, y, z of control value after control value [N/m]. No columns
/// where the family knows no side force.
Controls slopes_of(const FittedCurves& curves);

/// How much of their slopes test points pass on to what lies between them (B4), and the evidence:
/// mean error of the normal force at test points left out, relative, with and without slopes.
struct SlopeShare {
  double share = 0;  ///< 0 to 1/2
  int points = 0;    ///< that could be left out
  double error = 0, plain_error = 0;
};

/// Leaves out one test point at a time and predicts it from its neighbours, at four depths. 0 where
/// fewer than four points have neighbours all around, or slopes do not pay.
SlopeShare choose_slope_share(const FittedCurves& curves, const Triangles& triangles,
                              const std::vector<char>& is_usable, const Controls& slopes);

/// Rising again, from 0: a control value is at least the one before.
void clamp_rising(Eigen::Ref<Eigen::RowVectorXd> control);

}  // namespace palpate
