#pragma once

#include "libfit/core/curves.hpp"

namespace palpate {

/// How the normal curve changes along the surface from each test point, as the side force of its
/// presses says (B4a): P x 3 n, x, y, z of control value after control value [N/m]. No columns
/// where the family knows no side force.
Controls slopes_of(const FittedCurves& curves);

/// Rising again, from 0: a control value is at least the one before.
void clamp_rising(Eigen::Ref<Eigen::RowVectorXd> control);

}  // namespace palpate
